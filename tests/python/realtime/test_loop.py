"""What the loop promises of itself: no allocation, the same cost at every speed."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from python.realtime.running import brake_case
from rollerrig import simulate
from rollerrig.interfaces.realtime.server import serve_case

COUNTER = """
#define _GNU_SOURCE
#include <stddef.h>
extern void* __libc_malloc(size_t);
static __thread long calls = 0;
void* malloc(size_t size) { ++calls; return __libc_malloc(size); }
long malloc_calls(void) { return calls; }
"""

RUNS = """
import ctypes
from python.realtime.running import brake_case
from rollerrig.interfaces.realtime.server import serve_case
from rollerrig.interfaces.realtime.server import open_server
calls = ctypes.CDLL(None).malloc_calls
calls.restype = ctypes.c_long
for duration, lock_step in ((0.2, False), (0.2, False), (1.2, False), (0.2, True), (0.2, True), (1.2, True)):
    served = serve_case(brake_case(**{"time.duration": duration}), "1 kHz", lock_step=lock_step)
    server = open_server(served, "127.0.0.1", 0, at_once=True, lock_step=True)
    before = calls()
    server.run()
    print(server.statistics()["periods"], calls() - before)
"""
"""The brake bites after 0.5 s."""


@pytest.mark.slow
@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="counts the calls of glibc's malloc")
def test_a_thousand_periods_more_allocate_nothing_more(tmp_path: Path) -> None:
    compiler = shutil.which("cc") or shutil.which("gcc")
    if compiler is None:
        pytest.skip("no C compiler")
    (tmp_path / "counter.c").write_text(COUNTER)
    library = tmp_path / "counter.so"
    subprocess.run([compiler, "-shared", "-fPIC", "-O1", "-o", library, tmp_path / "counter.c"], check=True)
    environment = os.environ | {"LD_PRELOAD": str(library), "PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    done = subprocess.run([sys.executable, "-c", RUNS], capture_output=True, text=True, env=environment, check=False)
    assert done.returncode == 0, done.stderr
    runs = [[int(word) for word in line.split()] for line in done.stdout.splitlines()]
    for short, long in (runs[1:3], runs[4:6]):  # in real time and in lock-step the methods differ
        assert (short[0], long[0]) == (200, 1200)
        assert short[1] == long[1] > 0  # the start of a run does allocate


@pytest.mark.slow
def test_standstill_and_walking_pace_take_the_evaluations_of_200_km_h() -> None:
    """What a step costs in time is for benchmarks/real_time.py; evaluations are counted."""
    evaluations = []
    for speed in ("0 km/h", "1 m/s", "200 km/h"):
        case = brake_case(**{"motion.speed": speed, "time.duration": 1.0})
        run = simulate(serve_case(case, "1 kHz").case)
        evaluations.append(json.loads(run.attrs["solver_statistics"])["derivative_calls"])
    assert max(evaluations) < 1.05 * min(evaluations)


@pytest.mark.slow
def test_in_real_time_no_step_stops_for_a_jacobian_or_is_done_again() -> None:
    """The method of `simulate` renews its matrices now and then, in a step that takes thirty times the others."""
    case = brake_case(**{"time.duration": 2.0})
    steps, usual = (
        json.loads(simulate(serve_case(case, "1 kHz", lock_step=lock_step).case).attrs["solver_statistics"])
        for lock_step in (False, True)
    )
    assert (steps["jacobian_calls"], steps["rejected_steps"], steps["steps"]) == (0, 0, 2000)
    assert usual["jacobian_calls"] > 0
