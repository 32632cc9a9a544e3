"""`rollerrig paper --quick`: every section, every figure, documented keys, the same bytes twice; Ctrl-C keeps what is done."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

from rollerrig.studies.paper import QUICK, PaperResults, compute, write_paper
from rollerrig.studies.paper.write import PAPER_KEYS

SECTIONS = (
    "Figure 7: stability",
    "What the rig changes",
    "Which material fits the paper",
    "Figure 8: traction",
    "Checks",
    "Solver and contact",
    "Parameters",
    "What the model leaves out",
)


def files(folder: Path) -> dict[str, bytes]:
    return {str(path.relative_to(folder)): path.read_bytes() for path in sorted(folder.rglob("*")) if path.is_file()}


@pytest.fixture(scope="module")
def results() -> PaperResults:
    return compute(QUICK, processes=1)


@pytest.fixture(scope="module")
def folder(results, tmp_path_factory) -> Path:
    out = tmp_path_factory.mktemp("paper")
    write_paper(results, out)
    return out


def test_the_report_holds_every_section_and_every_figure(folder) -> None:
    text = (folder / "report.html").read_text()
    for heading in SECTIONS:
        assert f"<h2>{heading}</h2>" in text
    assert text.count("<figure>") == 11
    assert "Not computed" not in text
    words = re.sub(r'src="data:[^"]*"', "", text)
    assert not re.search(r"\bnan\b", words, re.IGNORECASE)


def test_traction_agrees_with_theory(folder) -> None:
    summary = json.loads((folder / "summary.json").read_text())
    failed = [check["name"] for check in summary["checks"] if not check["passed"]]
    assert failed == []
    assert summary["checks_passed"] == len(summary["checks"]) > 15
    assert all(check["reason"] for check in summary["checks"])


def test_summary_keys_are_documented(folder) -> None:
    summary = json.loads((folder / "summary.json").read_text())
    assert set(summary) - {"keys"} == {key.split(".")[0] for key in PAPER_KEYS}
    documented = {
        key.removeprefix("materials.*.").split(".")[0] for key in PAPER_KEYS if key.startswith("materials.*.")
    }
    for material in ("steel", "paper"):
        assert set(summary["materials"][material]) == documented


def test_the_same_study_gives_the_same_bytes(folder, tmp_path) -> None:
    write_paper(compute(QUICK, processes=2), tmp_path)
    first, second = files(folder), files(tmp_path)
    assert first.keys() == second.keys()
    assert [name for name in first if first[name] != second[name]] == []


def test_ctrl_c_keeps_what_is_done(tmp_path) -> None:
    def press(fraction: float, _text: str) -> None:
        if fraction > 0.3:
            raise KeyboardInterrupt

    results = compute(QUICK, processes=1, progress=press)
    assert results.interrupted
    assert results.modes
    write_paper(results, tmp_path)
    text = (tmp_path / "report.html").read_text()
    assert "Interrupted" in text
    assert "Not computed" in text
    for heading in SECTIONS:
        assert f"<h2>{heading}</h2>" in text


def test_no_results_at_all_make_a_report_too(tmp_path) -> None:
    write_paper(PaperResults(QUICK, interrupted=True), tmp_path)
    assert (tmp_path / "report.html").is_file()
