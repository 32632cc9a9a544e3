"""`rollerrig paper --quick`: every figure, registered numbers, the same bytes twice; Ctrl-C keeps what is done."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

from reported import unexplained, unreported
from rollerrig.study.frame import Outcome
from rollerrig.study.paper import CAPTIONS, PaperStudy, Results
from rollerrig.study.runs.paper import EXACT, FULL, QUICK, RIG, case_of, rig_case


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


def words_of(text: str) -> str:
    """A page without its pictures, its program and the files of its cases; what charts say is kept."""
    return re.sub(r"<(script|pre)>.*?</\1>", "", re.sub(r'src="data:[^"]*"', "", text), flags=re.DOTALL)


@pytest.mark.slow
def test_every_figure_is_drawn_and_shown(folder) -> None:
    drawn = {path.stem for path in (folder / "figures").glob("*.svg")}
    assert drawn == set(CAPTIONS)
    text = (folder / "report.html").read_text()
    assert text.count("<figure") == len(CAPTIONS)
    assert "Not computed" not in text
    words = words_of(text)
    assert not re.search(r"\bnan\b", words, re.IGNORECASE)


@pytest.mark.slow
def test_both_contacts_stand_side_by_side(outcome, folder) -> None:
    """Every critical speed with the paper's own contact and with the exact one, and the paper's 100 km/h beside each."""
    own, exact = outcome.numbers["materials"], outcome.numbers["exact_contact"]["materials"]
    assert own.keys() == exact.keys()
    for material in own:
        assert own[material]["linear"].keys() == exact[material]["linear"].keys()
        assert {"by_disturbance", "vehicle_on_track"} <= own[material].keys() & exact[material].keys()
    assert rig_case("steel").contact.normal.kind == "hertz"
    assert (
        case_of(RIG, "steel", EXACT).contact
        == rig_case("steel").with_changes({"contact.normal": "strips", "contact.creep": "table"}).contact
    )
    words = words_of((folder / "report.html").read_text())
    for text, count in ((outcome.summary, 2), (words, 2)):
        assert (
            len(re.findall(r"hunts above 100 km/h; here with .*? own contact, .*? with the exact one", text)) == count
        )
    assert outcome.numbers["traction"].keys() == outcome.numbers["exact_contact"]["traction"].keys()


@pytest.mark.slow
def test_traction_agrees_with_theory(outcome) -> None:
    summary = outcome.numbers
    assert [check["name"] for check in summary["checks"] if check["outcome"] == "failed"] == []
    assert summary["checks_passed"] > 15
    assert all(check["reason"] for check in summary["checks"])


@pytest.mark.slow
def test_a_quick_study_says_so_on_every_page(outcome, folder) -> None:
    """Terminal, report with its tables and figures, drawn figures, names of data files, summary.json."""
    assert outcome.summary.startswith("QUICK: few and short runs")
    text = words_of((folder / "report.html").read_text())
    assert text.count('<p class="mark"><strong>QUICK</strong>') == 1
    captions = re.findall(r"<(?:fig)?caption>(?:<span>)?(.*?)</", text, re.DOTALL)
    assert len(captions) == len(re.findall("<table[ >]", text)) + text.count("<figure") > 15
    assert all(caption.startswith("QUICK. ") for caption in captions)
    drawings = sorted((folder / "figures").glob("*.svg"))
    assert drawings
    assert [path.name for path in drawings if path.read_text().count('id="watermark"') != 1] == []
    assert all(path.stem.endswith("_quick") for path in (folder / "data").iterdir())
    assert json.loads((folder / "summary.json").read_text())["quick"] is True
    assert FULL.mark is None


@pytest.mark.slow
def test_what_is_only_bracketed_is_an_interval_and_never_its_middle(outcome, folder) -> None:
    """The runs at 100 and 200 km/h (100 and 160 km/h) say no more than that the onset is between them."""
    found = outcome.results.by_disturbance("steel"), outcome.results.by_disturbance("paper")
    assert [(one.low, one.high) for one in found] == [(pytest.approx(100), pytest.approx(200)),
                                                      (pytest.approx(100), pytest.approx(160))]  # fmt: skip
    text = words_of((folder / "report.html").read_text())
    assert "100.0 … 200.0 km/h" in outcome.summary
    assert "100.0 … 160.0 km/h" in text
    assert not re.search(r"\b1[35]0(\.0+)? km/h", outcome.summary + text)  # the middles
    assert not re.search(r"(critical|disturbance)[^<]*\b1[35]0\b", str(outcome.numbers["materials"]))


@pytest.mark.slow
def test_only_a_whole_interval_decides(outcome, folder) -> None:
    """A vehicle that still decays at the highest speed may begin to hunt anywhere above."""
    text = words_of((folder / "report.html").read_text())
    (undecided,) = [check for check in outcome.numbers["checks"] if check["outcome"] == "not decided"]
    assert undecided["name"].endswith("the paper's material, vehicle on track")
    assert undecided["value"][1] is None
    counts = [outcome.numbers[f"checks_{name}"] for name in ("passed", "failed", "not_decided")]
    assert counts == [25, 0, 1]
    assert "25 of 26 checks are decided: 25 passed, none failed." in outcome.summary
    assert "25 of 26 checks are decided" in text
    assert text.count('<td class="open">? not decided</td>') == 1


@pytest.mark.slow
def test_a_wrong_run_fails_its_checks(outcome) -> None:
    """A force, an energy and a symmetry that are wrong are found."""
    from rollerrig.study.runs.paper import traction_case, traction_checks

    run, theory = outcome.results.traction, outcome.results.theory
    left = run["wheel"] == "wheelset_1_left"
    force = run["longitudinal_creep_force"]
    wrong = run.assign(longitudinal_creep_force=force.where(~left, 1.01 * force))
    wrong = wrong.assign_attrs(energy_relative_residual=1e-3)
    fitted = theory.assign(longitudinal_creep_force=1.1 * theory["longitudinal_creep_force"])
    failed = {check.name for check in traction_checks(wrong, fitted, traction_case()) if not check.passed}
    assert failed == {
        "left = right, longitudinal creep force",
        "longitudinal creep force at the end, front: what accelerates wheelset and roller",
        "longitudinal creep force at the end, rear: what accelerates wheelset and roller",
        "traction: energy, work in = kinetic + potential + dissipated",
    }


@pytest.mark.slow
def test_every_number_is_registered_and_every_registered_quantity_reported(folder) -> None:
    summary = json.loads((folder / "summary.json").read_text())
    assert unexplained(PaperStudy.quantities, summary) == []
    whole = {
        "materials.*.roller_effects",
        "traction",
        "exact_contact.traction",
        "checks",
    }  # null or empty where nothing is computed
    assert set(unreported(PaperStudy.quantities, summary)) == whole


@pytest.mark.long
def test_the_same_study_gives_the_same_bytes(folder, tmp_path) -> None:
    again = PaperStudy(QUICK).run(processes=2)
    assert again is not None
    again.write(tmp_path)
    first, second = files(folder), files(tmp_path)
    assert first.keys() == second.keys()
    assert [name for name in first if first[name] != second[name] and name != "timing.json"] == []


@pytest.mark.slow
def test_ctrl_c_keeps_what_is_done(tmp_path) -> None:
    def press(fraction: float, _text: str) -> None:
        if fraction > 0.02:
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


@pytest.mark.slow
def test_the_report_names_the_paper_and_compares_with_it_first(outcome, folder) -> None:
    text = (folder / "report.html").read_text()
    first = text.partition("<section")[2].partition("</section>")[0]
    assert "Malvezzi, Meli and Pugi (2010)" in text.partition("</h1>")[0]
    header = "<th>paper</th><th>here</th><th>why they differ</th>"
    for words in ("The paper and this computation", header, "100 km/h", "figure 7a",
                  "figure 8a", "no parameter was tuned", "figure 8b", "follows the torque", "54.5 and 54.5 kN at first",
                  "a parabola leaves 1.4 % of the largest", "critical speed, rig against rails, steel",
                  "left wheels in the traction test", "none of their points can be read"):  # fmt: skip
        assert words in first
    steel = outcome.results.linear_kmh("steel")
    assert f"{steel:.1f} km/h for small motions" in first
