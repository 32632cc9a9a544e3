"""`rollerrig stability`: files, keys, messages."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from typer.testing import CliRunner

from rollerrig.cli.app import build_app
from rollerrig.results import load_run
from rollerrig.studies.stability import STABILITY_KEYS

runner = CliRunner()


def run(*arguments: str):
    return runner.invoke(build_app(), ["stability", *arguments])


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    out = tmp_path_factory.mktemp("stability")
    options = [
        "--speeds-kmh",
        "100:260:80",
        "--nonlinear",
        "--duration",
        "1",
        "--processes",
        "1",
        "--disturbance-mm",
        "1",
    ]
    result = run("bogie_rollers_constant", *options, "--out", str(out))
    assert result.exit_code == 0, result.output
    return out


def test_everything_is_written(folder) -> None:
    names = {path.name for path in folder.iterdir()}
    assert {"report.html", "stability.nc", "modes.csv", "shapes.csv", "runs.csv", "summary.json"} <= names


def test_summary_keys_are_documented(folder) -> None:
    summary = json.loads((folder / "summary.json").read_text())
    documented = {key.split(".")[0] for key in STABILITY_KEYS}
    assert set(summary) - {"keys"} == documented
    assert summary["keys"] == STABILITY_KEYS
    assert 240 < summary["linear_critical_speed_kmh"] < 260
    assert len(summary["nonlinear"]["runs"]) >= 3


def test_the_report_holds_every_section(folder) -> None:
    text = (folder / "report.html").read_text()
    for heading in ("Modes", "Mode shapes", "Runs from a disturbance", "Case"):
        assert f"<h2>{heading}</h2>" in text
    assert "Linear critical speed: 253" in text


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
