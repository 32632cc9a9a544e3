"""`rollerrig paper --quick`: every figure, registered numbers, the same bytes twice; Ctrl-C keeps what is done."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

from rollerrig.study.frame import Outcome
from rollerrig.study.paper import CAPTIONS, QUANTITIES, PaperStudy, Results
from rollerrig.study.paper_plan import QUICK


def files(folder: Path) -> dict[str, bytes]:
    return {str(path.relative_to(folder)): path.read_bytes() for path in sorted(folder.rglob("*")) if path.is_file()}


@pytest.fixture(scope="module")
def outcome() -> Outcome[Results]:
    found = PaperStudy(QUICK).run()
    assert found is not None
    return found


@pytest.fixture(scope="module")
def folder(outcome, tmp_path_factory) -> Path:
    out = tmp_path_factory.mktemp("paper")
    outcome.write(out)
    return out


def test_every_figure_is_drawn_and_shown(folder) -> None:
    drawn = {path.stem for path in (folder / "figures").glob("*.svg")}
    assert drawn == set(CAPTIONS)
    text = (folder / "report.html").read_text()
    assert text.count("<figure>") == len(CAPTIONS)
    assert "Not computed" not in text
    words = re.sub(r'src="data:[^"]*"', "", text)
    assert not re.search(r"\bnan\b", words, re.IGNORECASE)


def test_traction_agrees_with_theory(outcome) -> None:
    summary = outcome.numbers
    failed = [check["name"] for check in summary["checks"] if not check["passed"]]
    assert failed == []
    assert summary["checks_passed"] == len(summary["checks"]) > 15
    assert all(check["reason"] for check in summary["checks"])


def test_a_wrong_run_fails_its_checks(outcome) -> None:
    """A force, an energy and a symmetry that are wrong are found."""
    from rollerrig.study.paper_checks import traction_checks
    from rollerrig.study.paper_plan import traction_case

    run, theory = outcome.results.traction, outcome.results.theory
    left = run["wheel"] == "wheelset_1_left"
    wrong = run.assign(longitudinal_force=run["longitudinal_force"].where(~left, 1.01 * run["longitudinal_force"]))
    wrong = wrong.assign_attrs(energy_relative_residual=1e-3)
    fitted = theory.assign(longitudinal_force=1.1 * theory["longitudinal_force"])
    failed = {check.name for check in traction_checks(wrong, fitted, traction_case(QUICK)) if not check.passed}
    assert failed == {
        "left = right, longitudinal force",
        "longitudinal force at the end, front: what accelerates wheelset and roller",
        "longitudinal force at the end, rear: what accelerates wheelset and roller",
        "traction: energy, work in = kinetic + potential + dissipated",
    }


def test_every_number_is_registered_and_every_registered_quantity_reported(folder) -> None:
    summary = json.loads((folder / "summary.json").read_text())
    assert QUANTITIES.unexplained(summary) == []
    whole = {"materials.*.roller_effects", "traction", "checks"}  # null or empty where nothing is computed
    assert set(QUANTITIES.unreported(summary)) == whole


def test_the_same_study_gives_the_same_bytes(folder, tmp_path) -> None:
    again = PaperStudy(QUICK).run(processes=2)
    assert again is not None
    again.write(tmp_path)
    first, second = files(folder), files(tmp_path)
    assert first.keys() == second.keys()
    assert [name for name in first if first[name] != second[name]] == []


def test_ctrl_c_keeps_what_is_done(tmp_path) -> None:
    def press(fraction: float, _text: str) -> None:
        if fraction > 0.3:
            raise KeyboardInterrupt

    cut = PaperStudy(QUICK).run(progress=press)
    assert cut is not None
    assert cut.interrupted
    assert cut.results.modes
    cut.write(tmp_path)
    text = (tmp_path / "report.html").read_text()
    assert "Interrupted" in text
    assert "Not computed" in text


def test_no_results_at_all_make_a_report_too(tmp_path) -> None:
    study = PaperStudy(QUICK)
    nothing = study.collect({})
    assert nothing is not None
    Outcome(study, nothing, interrupted=True).write(tmp_path)
    assert (tmp_path / "report.html").is_file()
