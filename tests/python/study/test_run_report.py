"""The report of a run: what a reader needs stands in it."""

from __future__ import annotations

import csv
import fnmatch
import json
from html import unescape
from pathlib import Path

import pytest

from rollerrig import load_case, simulate
from rollerrig.results import summarise
from rollerrig.studies.run import COUNTERS, run_report, write_run
from rollerrig.studies.wheel_rail_forces import READINGS_KEYS


def test_every_counter_of_the_contact_model_is_explained() -> None:
    run = simulate(load_case("wheelset_rollers").with_changes({"time.duration": "20 ms"}))
    summary = summarise(run)
    assert set(COUNTERS) == set(summary["contact"])
    text = unescape(run_report(run, summary, []))
    assert all(meaning in text for meaning in COUNTERS.values())
    assert "10^" not in text


def test_readings_are_in_the_files_and_every_key_is_explained(tmp_path: Path) -> None:
    run = simulate(load_case("bogie_track").with_changes({"time.duration": "0.3 s", "vehicle.cut": "vehicle"}))
    write_run(run, tmp_path)
    summary = json.loads((tmp_path / "summary.json").read_text())
    assert all(key in summary["keys"] for key in READINGS_KEYS)
    found = [f"readings.{q}.{p}.{key}" for q, ps in summary["readings"].items() for p, row in ps.items() for key in row]
    assert all(any(fnmatch.fnmatch(key, pattern) for pattern in READINGS_KEYS) for key in found)
    with (tmp_path / "readings.csv").open() as file:
        rows = list(csv.DictReader(file))
    load = next(row for row in rows if (row["quantity"], row["place"]) == ("wheel_load", "wheelset_3_left"))
    number = summary["readings"]["wheel_load"]["wheelset_3_left"]["quasi_static"]
    assert float(load["quasi_static"]) == pytest.approx(number, rel=1e-8)  # nine digits
    assert load["limit"] == ""
    text = unescape((tmp_path / "report.html").read_text())
    for title in (
        "Readings",
        "Wheel forces",
        "Y/Q",
        "Sum of guiding forces",
        "Wear number",
        "Accelerations of the car body",
    ):
        assert f">{title}</h2>" in text
    assert "Accelerations are not filtered: a filter at 0.4 Hz needs a run of at least 2.5 s" in text
