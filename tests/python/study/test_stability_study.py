"""`rollerrig stability`: files, keys, messages."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from typer.testing import CliRunner

from rollerrig.cli.app import build_app
from rollerrig.config import load_case
from rollerrig.results import load_run
from rollerrig.studies.stability import (
    MOST_CYCLE_SPEEDS,
    STABILITY_KEYS,
    cycle_speeds,
    stability_study,
    write_study,
)

runner = CliRunner()


def run(*arguments: str):
    return runner.invoke(build_app(), ["stability", *arguments])


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    out = tmp_path_factory.mktemp("stability")
    options = ["--speeds-kmh", "100:260:80", "--tolerance-kmh", "50", "--longest", "8", "--processes", "1"]
    result = run("bogie_rollers_constant", *options, "--out", str(out))
    assert result.exit_code == 0, result.output
    return out


def test_everything_is_written(folder) -> None:
    names = {path.name for path in folder.iterdir()}
    assert {"report.html", "stability.nc", "modes.csv", "shapes.csv", "limit_cycles.csv", "summary.json"} <= names


def test_summary_keys_are_documented(folder) -> None:
    summary = json.loads((folder / "summary.json").read_text())
    documented = {key.split(".")[0] for key in STABILITY_KEYS}
    assert set(summary) - {"keys"} == documented
    assert summary["keys"] == STABILITY_KEYS
    assert 240 < summary["linear_critical_speed_kmh"] < 260
    cycles = summary["limit_cycles"]
    assert {f"limit_cycles.{key}" for key in cycles} == {
        key for key in STABILITY_KEYS if key.startswith("limit_cycles.")
    }
    assert len(cycles["points"]) >= 6
    assert cycles["bifurcation"] == "subcritical"


def test_the_report_holds_every_section(folder) -> None:
    text = (folder / "report.html").read_text()
    for heading in ("Modes", "Limit cycles", "Mode shapes", "Case"):
        assert f"<h2>{heading}</h2>" in text
    assert "Linear critical speed: 253" in text
    assert "Critical speed by continuation: " in text
    assert text.count("<img") == 7


def test_the_data_are_those_of_the_table(folder) -> None:
    data = load_run(folder / "stability.nc")
    assert list(data["speed"].to_numpy()) == [100.0, 180.0, 260.0]
    rows = (folder / "modes.csv").read_text().splitlines()
    assert len(rows) == 1 + data.sizes["speed"] * data.sizes["mode"]


def test_bad_speeds_are_refused(tmp_path) -> None:
    for speeds in ("300:60:20", "0:60:20", "fast"):
        result = run("bogie_rollers_constant", "--speeds-kmh", speeds, "--out", str(tmp_path))
        assert result.exit_code == 2
        assert "--speeds-kmh" in result.output


def interrupt_at(fraction: float):
    def progress(done: float, _text: str) -> None:
        if done >= fraction:
            raise KeyboardInterrupt

    return progress


def test_ctrl_c_keeps_the_speeds_that_were_done(tmp_path) -> None:
    case = load_case("wheelset_rollers")
    study = stability_study(case, [20.0, 25.0, 30.0, 35.0], with_limit_cycles=False, progress=interrupt_at(0.5))
    assert study.interrupted
    assert study.modes["speed"].to_numpy().tolist() == [20.0, 25.0]
    write_study(study, tmp_path)
    assert json.loads((tmp_path / "summary.json").read_text())["interrupted"] is True


def test_ctrl_c_keeps_the_runs_that_were_done(tmp_path) -> None:
    study = stability_study(
        load_case("wheelset_rollers"), [20, 40, 60], progress=interrupt_at(0.2)
    )  # 0.1 the modes, then a quarter of 0.54 each
    assert study.interrupted
    assert study.cycles is not None
    assert len(study.cycles.down) == 1
    write_study(study, tmp_path)
    assert "Interrupted" in (tmp_path / "report.html").read_text()


def test_without_limit_cycles_no_run_is_made(tmp_path) -> None:
    result = run("wheelset_rollers", "--speeds-kmh", "40:80:20", "--no-limit-cycles", "--out", str(tmp_path))
    assert result.exit_code == 0, result.output
    assert "limit_cycles" not in json.loads((tmp_path / "summary.json").read_text())
    assert not (tmp_path / "limit_cycles.csv").exists()


def test_runs_are_spread_over_the_range() -> None:
    chosen = cycle_speeds(list(range(60, 301)))
    assert len(chosen) == MOST_CYCLE_SPEEDS
    assert (chosen[0], chosen[-1]) == (60.0, 300.0)
    assert cycle_speeds([80.0]) == [80.0]


def test_ctrl_c_ends_the_command_with_130(tmp_path) -> None:
    """To the whole process group, as a terminal sends it, also while the workers are still starting."""
    command = [sys.executable, "-c", "from rollerrig.cli import main; main()", "stability", "wheelset_rollers"]
    options = ["--speeds-kmh", "20:400:20", "--longest", "600", "--disturbance-mm", "6", "--out", str(tmp_path)]
    process = subprocess.Popen([*command, *options], stderr=subprocess.PIPE, text=True, start_new_session=True)
    time.sleep(4.0)
    os.killpg(process.pid, signal.SIGINT)
    _, errors = process.communicate(timeout=60)
    assert process.returncode == 130, errors
    assert "Traceback" not in errors
