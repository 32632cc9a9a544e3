"""`rollerrig serve` as a user meets it."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from typer.testing import Result

from called import called
from rollerrig.cli.interfaces import histogram_lines, state_lines

pytestmark = pytest.mark.skipif(not sys.platform.startswith("linux"), reason="the server is written for Linux")

CASE = """
name = "short_brake"
[vehicle]
use = "manchester_vehicle_1"
cut = "leading_bogie"
[support]
use = "full_scale_rig"
[contact]
material = "steel"
friction = 0.3
creepage_regularisation_speed = "1 m/s"
[motion]
speed = "120 km/h"
drive = "free"
[adhesion]
rail = "low"
[brake]
demand = [[0.0, 0.0], ["0.1 s", "3.8 bar"]]
[slide_protection]
[rig_control]
[time]
duration = "0.2 s"
output_step = "10 ms"
"""


@pytest.fixture(scope="module")
def case(tmp_path_factory: pytest.TempPathFactory) -> str:
    path = tmp_path_factory.mktemp("serve") / "short_brake.toml"
    path.write_text(CASE)
    return str(path)


def serve(*arguments: object) -> Result:
    return called("serve", *arguments)


@pytest.fixture(scope="module")
def recorded(case: str) -> tuple[Result, Path]:
    path = Path(case).with_name("run.npz")
    return serve(case, "--at-once", "--lock-step", "--record", path, "--outputs", "train.*"), path


def test_a_run_tells_its_times_and_keeps_its_record(recorded: tuple[Result, Path]) -> None:
    done, path = recorded
    assert done.exit_code == 0, done.output
    assert "neither encrypted nor signed" in done.stderr
    for word in ("200 periods; to its end", "step: median", "deadlines missed: 0", "memory:"):
        assert word in done.stdout
    with np.load(path) as kept:
        assert kept["commands"].shape == (200, 4)
        assert kept["sensors"].shape == (201, len(kept["outputs"]))


def test_a_record_is_replayed_to_the_same_bytes(case: str, recorded: tuple[Result, Path]) -> None:
    done = serve(case, "--replay", recorded[1], "--outputs", "train.*")
    assert done.exit_code == 0, done.output
    assert "200 periods" in done.stdout
    assert "the same bytes" in done.stdout


def test_a_record_of_other_commands_is_not_the_same_run(
    case: str, recorded: tuple[Result, Path], tmp_path: Path
) -> None:
    with np.load(recorded[1]) as kept:
        parts = {name: kept[name] for name in kept.files}
    parts["commands"] = parts["commands"].copy()
    parts["commands"][120:, 2] = 2.0
    np.savez(tmp_path / "other.npz", **parts)
    done = serve(case, "--replay", tmp_path / "other.npz", "--outputs", "train.*")
    assert done.exit_code == 3
    assert "sensors differ from t = 0.1" in done.stderr


def test_other_options_than_those_of_the_record_are_refused(case: str, recorded: tuple[Result, Path]) -> None:
    for options, what in (
        (["--outputs", "train.speed"], "outputs"),
        (["--outputs", "train.*", "--rate", "500 Hz"], "rate"),
    ):
        done = serve(case, "--replay", recorded[1], *options)
        assert done.exit_code == 2
        assert what in done.stderr


def test_a_model_file_is_served_without_its_case(case: str, tmp_path: Path) -> None:
    path = tmp_path / "rig.model"
    assert called("assemble", case, "--out", path, "--external", "slide_protection").exit_code == 0
    records = [tmp_path / "case.npz", tmp_path / "model.npz"]
    for source, record in zip((case, path), records, strict=True):
        options = ["--rate", "200 Hz", "--at-once", "--lock-step", "--record", record]  # the sample time of the file
        done = serve(source, *options)
        assert done.exit_code == 0, done.output
    with np.load(records[0]) as one, np.load(records[1]) as other:
        assert one["sensors"].tobytes() == other["sensors"].tobytes()
    for options, message in (
        (["--external", "slide_protection"], "rollerrig assemble --external"),
        (["--rate", "3 kHz"], "3 kHz"),
    ):
        done = serve(path, *options)
        assert done.exit_code == 2
        assert message in done.stderr
        assert len(done.stderr.splitlines()) == 1
    (tmp_path / "cut.model").write_bytes(path.read_bytes()[:-9])
    done = serve(tmp_path / "cut.model")
    assert (done.exit_code, len(done.stderr.splitlines())) == (2, 1)
    assert serve(tmp_path / "none.model").exit_code == 2


def test_the_histogram_counts_every_step_and_wake_up() -> None:
    lines = histogram_lines([(900, 0, 3), (1000, 0, 2), (40_000, 5, 0), (60_000, 6, 1), (65_000, 1, 0)])
    assert [line.split() for line in lines[1:]] == [
        ["1", "us", "0", "5"],
        ["64", "us", "11", "1"],
        ["128", "us", "1", "0"],
    ]


def test_the_live_view_tells_deadlines_and_frames() -> None:
    frames = {"accepted": 40, "corrupt": 2, "late": 0}
    times = (50, 30_000, 40_000, 90_000, 100_000)
    told = {"state": 1, "time": 0.05, "step": times, "wake": times, "misses": 3, "periods": 50, "silent": 4, "trips": 1}
    shown = state_lines(told | {"frames": frames, "skipped": 2, "first_trip": 0.03})
    assert shown == [
        "running, t = 0.050 s, 50 periods",
        "step: median 30.0, 99 % 40.0, 99.99 % 90.0, longest 100.0 us, of 50",
        "wake-up: median 30.0, 99 % 40.0, 99.99 % 90.0, longest 100.0 us, of 50",
        "deadlines missed: 3, given up: 2",
        "frames: 40 accepted, 2 corrupt",
        "silent for 4 periods; watchdog: 1 times, first at t = 0.030 s: safe state",
    ]


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--udp", "loopback:5005"], "allowed: a port from 0 to 65535"),
        (["--udp", "127.0.0.1:70000"], "allowed: a port from 0 to 65535"),
        (["--udp", "203.0.113.7:0"], "udp: 203.0.113.7:0"),
        (["--shm", "a/b"], "allowed: a name without '/'"),
        (["--shm", "rig", "--udp", "5005"], "in place of --udp"),
        (["--rate", "3 kHz"], "multiple of time.sampling_step"),
        (["--external", "rig_controller"], "did you mean 'rig_control'"),
        (["--safe", "valve"], "allowed: NAME=VALUE"),
        (["--record", "/proc/nowhere/run.npz"], "/proc/nowhere"),
        (["--record", __file__], __file__),
        (["--replay", "/nowhere/run.npz"], "needed: a file of `rollerrig serve --record`"),
    ],
)
def test_bad_input_is_one_line_and_exit_code_2(case: str, options: list[str], message: str) -> None:
    done = serve(case, *options)
    assert done.exit_code == 2, done.output
    assert message in done.stderr
    assert len(done.stderr.splitlines()) == 1


def test_a_port_in_use_is_one_line_and_nothing_is_written(case: str, tmp_path: Path) -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as taken:
        taken.bind(("127.0.0.1", 0))
        port = taken.getsockname()[1]
        done = serve(case, "--udp", port, "--record", tmp_path / "run.npz")
    assert done.exit_code == 2
    assert f"udp: 127.0.0.1:{port}" in done.stderr
    assert len(done.stderr.splitlines()) == 1
    assert not list(tmp_path.iterdir())


@pytest.mark.slow
def test_ctrl_c_ends_a_server_that_waits_and_tells_what_it_was(case: str) -> None:
    command = [sys.executable, "-c", "from rollerrig.cli import main; main()", "serve", case]
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    with subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=environment
    ) as server:
        assert server.stderr is not None
        while "encrypted" not in server.stderr.readline():
            assert server.poll() is None
        time.sleep(1.0)  # until it waits
        server.send_signal(signal.SIGINT)
        out, _ = server.communicate(timeout=20)
    assert server.returncode == 130
    assert "0 periods; interrupted" in out
