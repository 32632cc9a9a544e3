"""Workers end with the program that started them, whatever ends it and whatever they are at."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from rollerrig.analysis.crew import Progress

BOUND = 10.0
"""A worker asks for its parent's end before it loads anything: within a second, unless the machine is busy [s]."""

pytestmark = pytest.mark.skipif(not Path("/proc/self/task").is_dir(), reason="looks for processes in /proc")


def report(folder: Path, _progress: Progress) -> None:
    """Say that a worker is here, and work for long."""
    (folder / str(os.getpid())).touch()
    time.sleep(600.0)


def be_done(folder: Path, _progress: Progress) -> None:
    """Say that a worker is here, which then waits for more."""
    (folder / str(os.getpid())).touch()


def either(job: tuple[str, Path], progress: Progress) -> None:
    {"busy": report, "idle": be_done}[job[0]](job[1], progress)


def alive(process: int) -> bool:
    try:
        state = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0]
    except OSError:
        return False
    return state != "Z"  # one that nobody has asked for its exit code yet


def children(process: int) -> list[int]:
    return [int(number) for number in Path(f"/proc/{process}/task/{process}/children").read_text().split()]


def gone_within(processes: list[int], seconds: float) -> bool:
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        if not any(map(alive, processes)):
            return True
        time.sleep(0.02)
    return False


def program(folder: Path, kinds: tuple[str, str]) -> subprocess.Popen[bytes]:
    script = f"""
import sys
sys.path.insert(0, {str(Path(__file__).parent)!r})
from pathlib import Path
import test_workers
from rollerrig.analysis.parallel import run_jobs
run_jobs(test_workers.either, [(kind, Path({str(folder)!r})) for kind in {kinds!r}], processes=2)
"""
    return subprocess.Popen([sys.executable, "-c", script])


@pytest.mark.parametrize("kinds", [("busy", "busy"), ("busy", "idle")], ids=" and ".join)
def test_workers_end_when_the_program_is_killed(tmp_path: Path, kinds: tuple[str, str]) -> None:
    parent = program(tmp_path, kinds)
    try:
        end = time.monotonic() + 60.0
        while len(list(tmp_path.iterdir())) < 2:
            assert time.monotonic() < end, "the workers never started"
            assert parent.poll() is None
            time.sleep(0.02)
        workers = children(parent.pid)
        assert len(workers) >= 2
    finally:
        parent.kill()
        parent.wait()
    try:
        assert gone_within(workers, BOUND)
    finally:
        for worker in filter(alive, workers):
            os.kill(worker, signal.SIGKILL)


@pytest.mark.parametrize("delay", [0.0, 0.3])
def test_workers_that_have_not_begun_end_too(tmp_path: Path, delay: float) -> None:
    """Killed while the workers import: they cannot have asked yet to be told of their parent's end."""
    parent = program(tmp_path, ("busy", "busy"))
    try:
        end = time.monotonic() + 60.0
        while len(workers := children(parent.pid)) < 2:
            assert time.monotonic() < end, "the workers never started"
            assert parent.poll() is None
            time.sleep(0.002)
        time.sleep(delay)
        workers = children(parent.pid)
    finally:
        parent.kill()
        parent.wait()
    try:
        assert gone_within(workers, BOUND)
    finally:
        for worker in filter(alive, workers):
            os.kill(worker, signal.SIGKILL)
