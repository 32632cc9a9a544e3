"""The nonlinear critical speed over the models of normal contact, as the table of the documentation has it."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from rollerrig.analysis.hunting import hunting_run
from rollerrig.config import Case
from rollerrig.study.runs.paper import FULL, RIG, case_of

PAGE = Path(__file__).resolve().parents[3] / "docs" / "theory" / "contact_forces.md"
SUPPORTS = {"rig": RIG, "track": "bogie on track"}


def quoted() -> dict[tuple[str, str, str], dict[str, tuple[float, float]]]:
    """Normal law, merging criterion and creep law of a row -> support -> where the motion decays and persists [km/h]."""
    number = r"([\d.]+)"
    row = re.compile(rf"\| `(\w+)` \| ([\d.–]+) \| `(\w+)` \| {number} … {number} \| {number} … {number} \|")
    found = {}
    for normal, criterion, creep, *ends in row.findall(PAGE.read_text(encoding="utf-8")):
        a, b, c, d = map(float, ends)
        found[normal, criterion, creep] = {"rig": (a, b), "track": (c, d)}
    return found


def with_model(on: str, normal: str, criterion: str, creep: str) -> Case:
    law: dict[str, object] = {"kind": normal}
    if normal == "hertz":
        law["merging_criterion"] = float(criterion)
    return case_of(SUPPORTS[on], "steel").with_changes({"contact.normal": law, "contact.creep": creep})


def test_the_documentation_quotes_every_model_on_both_supports() -> None:
    ellipses = [
        ("hertz", criterion, "kalker_saturated") for criterion in ("0", "0.005", "0.01", "0.015", "0.02", "0.05")
    ]
    assert list(quoted()) == [*ellipses, ("strips", "–", "kalker_saturated"), ("strips", "–", "table")]


@pytest.mark.slow
@pytest.mark.parametrize("model", [("hertz", "0", "kalker_saturated"), ("hertz", "0.05", "kalker_saturated"),
                                   ("strips", "–", "kalker_saturated")])  # fmt: skip
@pytest.mark.parametrize("on", ["rig", "track"])
def test_what_the_documentation_quotes_is_what_runs_do(on: str, model: tuple[str, str, str]) -> None:
    """At one end the motion decays and at the other it persists: a changed contact model moves the bracket and fails here."""
    decays, persists = quoted()[model][on]
    assert 0.0 < persists - decays <= FULL.bracket_kmh
    case = with_model(on, *model)
    assert hunting_run((case, decays / 3.6, FULL.hunting)).decays
    assert hunting_run((case, persists / 3.6, FULL.hunting)).persists
