"""Identical commands write identical bytes, one worker or two: all measured times stand in timing.json, and nowhere else."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

import rollerrig as rr
from called import called

ENTRY = [sys.executable, "-c", "from rollerrig.cli import main; main()"]
TIMING = "timing.json"

COMMANDS = {
    "creep": ("creep", "--law", "table", "--law", "fastsim", "--demands", "0.5,8"),
    "curving": ("curving", "vehicle_curve", "--radii-m", "1000", "--deficiencies-mm", "0"),
    "stability": ("stability", "bogie_rollers_constant", "--speeds-kmh", "240:260:20", "--no-limit-cycles"),
    "envelope": ("envelope", "CASE", "--torques-knm=-6,-2", "--adhesions", "0.05,0.3", "--loads", "1", "--duration", "0.6",
                 "--refine", "0"),
    "adhesion": ("adhesion", "CASE", "--no-error-budget"),
    "control": ("control", "CASE", "--duration", "1", "--families", "delay", "--no-loop"),
    "lateral": ("lateral", "LATERAL"),
    "scale": ("scale", "CASE", "--strategy", "dlr", "--run", "--no-error-budget"),
    "compare": ("compare", "manchester_vehicle_1", "--cut", "leading_wheelset", "--speeds-kmh", "60,80", "--radii-m", "0.725",
                "--duration", "1"),
    "wsp": ("wsp", "CASE", "--programme", "PROGRAMME", "--starts", "2"),
}  # fmt: skip
"""Command -> its words; CASE, LATERAL and PROGRAMME are short ones written for the test."""
ALONE = {"creep", "curving"}
"""Without --processes: run twice as it is; so are `run` and `conicity` in their own tests."""
PROGRAMME = """
name = "short"
stop = [{ name = "drag", kind = "drag", speed = "40 km/h", rail = "low", gradient = -0.04, duration = "2 s" }]
limit = [{ criterion = "air", at_most = 1.0, origin = "test" }]
"""
MANY_RUNS = {"adhesion", "creep", "control", "envelope", "lateral", "scale", "compare", "wsp"}
"""Ten seconds and more of runs and files each; they take the same way to their files as the one that is left."""


def files(folder: Path) -> dict[str, bytes]:
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


@pytest.mark.slow
@pytest.mark.parametrize(
    "command", [pytest.param(name, marks=[pytest.mark.long] if name in MANY_RUNS else []) for name in COMMANDS]
)
def test_identical_commands_write_identical_bytes(command: str, tmp_path: Path) -> None:
    short = {"time.duration": "1 s"}
    (tmp_path / "case.toml").write_text(rr.load_case("adhesion_brake").with_changes(short).to_toml())
    (tmp_path / "lateral.toml").write_text(rr.load_case("adhesion_lateral").with_changes(short).to_toml())
    (tmp_path / "programme.toml").write_text(PROGRAMME)
    places = {name: tmp_path / f"{name.lower()}.toml" for name in ("CASE", "LATERAL", "PROGRAMME")}
    words = [str(places.get(word, word)) for word in COMMANDS[command]]
    found = []
    for processes in ("1", "2"):
        out = tmp_path / processes
        more = [] if command in ALONE else ["--processes", processes]
        if processes == "1":
            assert called(*words, "--out", out, *more).exit_code == 0
        else:
            subprocess.run([*ENTRY, *words, "--out", out, *more], check=True, capture_output=True)
        found.append(files(out))
    one, two = found
    assert one.keys() == two.keys()
    assert [name for name in one if one[name] != two[name] and name != TIMING] == []
    assert json.loads(one[TIMING])["wall time [s]"] > 0.0
    if command == "creep":
        assert json.loads(one[TIMING])["processor time of a call [ns]"].keys() == {"table", "fastsim"}
        assert "nanoseconds" not in one["summary.json"].decode()
