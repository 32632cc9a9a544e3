"""`rollerrig run`: files, numbers and the report of one simulation."""

from __future__ import annotations

import base64
import csv
import json
import math
import re
from dataclasses import replace
from pathlib import Path

import pytest

from reported import unexplained, unreported
from rollerrig import load_case
from rollerrig.analysis.hunting import LateralRest
from rollerrig.analysis.signals import FinalMotion
from rollerrig.study.frame import Outcome
from rollerrig.study.run import CONTACT, QUANTITIES, Results, RunStudy

RESTS = [f"lateral_rest.{name}" for name in ("body", "amplitude_mm", "frequency_hz", "growth_rate_per_s", "decision")]
FORCES = ("wheel_forces", "y_over_q", "sum_of_guiding_forces", "wear_number", "accelerations_of_the_car_body")


@pytest.fixture(scope="module")
def outcome() -> Outcome[Results]:
    found = RunStudy(load_case("bogie_track").with_changes({"time.duration": "0.3 s", "vehicle.cut": "vehicle"})).run()
    assert found is not None
    return found


@pytest.fixture(scope="module")
def folder(outcome: Outcome[Results], tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("run")
    outcome.write(path)
    return path


@pytest.mark.slow
def test_every_number_is_registered_and_every_registered_quantity_reported(folder: Path) -> None:
    summary = json.loads((folder / "summary.json").read_text())
    assert unexplained(QUANTITIES, summary) == []
    assert unreported(QUANTITIES, summary) == RESTS  # the run is too short for them


@pytest.mark.slow
def test_every_counter_of_the_contact_model_is_explained(outcome: Outcome[Results]) -> None:
    assert {quantity.name for quantity in CONTACT} == set(outcome.numbers["contact"])


@pytest.mark.slow
def test_running_safety_is_the_same_in_all_files(outcome: Outcome[Results], folder: Path) -> None:
    with (folder / "running_safety.csv").open() as file:
        rows = list(csv.DictReader(file))
    load = next(row for row in rows if (row["quantity"], row["place"]) == ("wheel_load", "wheelset_3_left"))
    number = outcome.numbers["running_safety"]["wheel_load"]["wheelset_3_left"]["sections"]["straight"]["quasi_static"]
    assert float(load["quasi_static"]) == pytest.approx(number, rel=1e-8)  # nine digits
    assert load["limit"] == ""
    assert "a filter at 0.4 Hz needs a run of at least 2.5 s" in outcome.numbers["running_safety_notes"][-1]


@pytest.mark.slow
def test_figures_show_the_run(folder: Path) -> None:
    drawn = {path.stem for path in (folder / "figures").iterdir()}
    assert drawn >= {"motion", "sliding", "energy", *FORCES}
    assert "track" not in drawn  # straight and smooth


def test_a_run_with_one_sample_has_a_report_without_figures(tmp_path: Path) -> None:
    case = load_case("wheelset_rollers").with_changes({"time.duration": "1 ms", "time.output_step": "1 ms"})
    found = RunStudy(case).run()
    assert found is not None
    one = Outcome(found.study, Results(found.results.run.isel(time=[0]), found.results.assessment, found.results.rows))
    one.write(tmp_path)
    assert (tmp_path / "report.html").exists()


@pytest.mark.slow
def test_the_integrator_is_counted_in_words(folder: Path) -> None:
    text = (folder / "report.html").read_text()
    for words in ("evaluations of the right-hand side", "evaluations of the Jacobian", "smallest step [s]"):
        assert f"<td>{words}</td>" in text
    assert "derivative calls" not in text


@pytest.mark.slow
def test_a_report_says_first_what_the_vehicle_did(outcome: Outcome[Results]) -> None:
    run, rest = outcome.results.run, FinalMotion(6.1e-3, 5.1, 0.0)
    decaying, over = replace(rest, rate=-1.0), FinalMotion(0.0, math.nan, math.nan)
    for final, decision, said in (
        (rest, "persists", "It hunts: {}, in the last third of the run by ±6.1 mm at 5.1 Hz, which changes by +0 %/s."),
        (decaying, "decays", "The motion decays: {}, in the last third"),
        (decaying, "open", "Not decided whether it hunts: {}, in the last third of the run by ±6.1 mm"),
        (over, "decays", "The motion decays: {}, and no longer"),
    ):
        results = replace(outcome.results, rest=LateralRest("wheelset_1", 7e-3, final, decision))
        first, second, *_ = outcome.study.summary(results, outcome.study.numbers(results))
        assert first.startswith(said.format("wheelset 1 moved sideways by up to 7 mm"))
        assert second.startswith("Running safety: Y/Q reaches ")
    assert run.sizes["time"] > 1
    unsaid = outcome.study.summary(replace(outcome.results, rest=None), outcome.numbers)
    assert unsaid[0].startswith("Running safety")


@pytest.mark.slow
def test_pictures_that_are_seen_on_paper_only_have_few_colours(folder: Path) -> None:
    text = (folder / "report.html").read_text()
    shown = re.findall(r'<figure id="figure-(\w+)"><div class="scroll"><img src="data:image/png;base64,([^"]+)"', text)
    assert {"motion", "wheel_forces"} <= {name for name, _ in shown}
    for name, numbers in shown:
        whole = (folder / "figures" / f"{name}.png").read_bytes()
        few = base64.b64decode(numbers)
        assert len(few) < 0.6 * len(whole), name
        assert few[16:24] == whole[16:24], name  # as wide and as high
