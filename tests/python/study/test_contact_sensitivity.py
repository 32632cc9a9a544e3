"""The nonlinear critical speed over the models of normal contact: the table, and the figures that the documentation quotes."""

from __future__ import annotations

import math
import tomllib
from pathlib import Path

import pytest

from rollerrig.analysis import CriticalSpeedByDisturbance
from rollerrig.analysis.hunting import hunting_run
from rollerrig.config import load_case
from rollerrig.study.contact_models import (
    contact_models,
    sensitivity_cases,
    sensitivity_numbers,
    sensitivity_table,
)
from rollerrig.study.runs.paper import FULL, MERGING_CRITERIA, contact_model_cases

FIGURES = Path(__file__).resolve().parents[3] / "docs" / "figures.toml"


def test_each_model_is_what_its_name_says() -> None:
    bogie = load_case("bogie_rollers_constant")
    cases = sensitivity_cases({"rig": bogie, "track": load_case("bogie_track")}, [0.0, 0.05])
    assert len(cases) == 8
    assert cases["contact model rig, hertz, 0.05"].contact.normal.merging_criterion == 0.05
    assert cases["contact model rig, strips"].contact.normal.kind == "strips"
    assert cases["contact model track, strips, table"].contact.creep.kind == "table"
    assert cases["contact model track, hertz, 0"].support.data.kind == "track"


def test_the_table_has_a_row_per_model_and_intervals() -> None:
    found = {
        "contact model rig, hertz, 0.01": CriticalSpeedByDisturbance(40.0, 41.0, 3e-3, []),
        "contact model track, hertz, 0.01": CriticalSpeedByDisturbance(50.0, math.nan, 3e-3, []),
        "contact model rig, strips, table": CriticalSpeedByDisturbance(math.nan, 60.0, 3e-3, []),
    }
    table = sensitivity_table(found)
    assert tuple(table.header) == ("normal", "merging criterion", "creep", "on rig", "on track")
    assert [list(row) for row in table.rows] == [
        ["hertz", "0.01", "kalker saturated", "144.0 … 147.6 km/h", "above 180.0 km/h"],
        ["strips", "–", "table", "at most 216.0 km/h", "not computed"],
    ]
    assert sensitivity_numbers(found)["rig"]["hertz, 0.01"] == {"decays_kmh": 144.0, "persists_kmh": 41.0 * 3.6}


def recorded() -> dict[str, tuple[float, float]]:
    """Label of a run -> both ends of the bracket [km/h] as the documentation quotes them."""
    found = {}
    for figure in tomllib.loads(FIGURES.read_text(encoding="utf-8"))["figure"]:
        places = [key.split("/") for key in figure["keys"] if key.startswith("critical_speed_by_contact_model/")]
        for (_, on, model, end), value in zip(places, figure["values"], strict=False):
            ends = found.setdefault(f"contact model {on}, {model}", {})
            ends[end] = value
    return {label: (ends["decays_kmh"], ends["persists_kmh"]) for label, ends in found.items()}


def test_the_documentation_quotes_every_model_on_both_supports() -> None:
    assert set(recorded()) == set(contact_model_cases(FULL))
    assert len(recorded()) == 2 * len(contact_models(MERGING_CRITERIA))


@pytest.mark.slow
@pytest.mark.parametrize("model", ["hertz, 0", "hertz, 0.05", "strips"])
@pytest.mark.parametrize("on", ["rig", "track"])
def test_what_the_documentation_quotes_is_what_runs_do(on: str, model: str) -> None:
    """At one end the motion decays and at the other it persists: a changed contact model moves the bracket and fails here."""
    label = f"contact model {on}, {model}"
    decays, persists = recorded()[label]
    assert 0.0 < persists - decays <= FULL.bracket_kmh
    case = contact_model_cases(FULL)[label]
    assert hunting_run((case, decays / 3.6, FULL.hunting)).decays
    assert hunting_run((case, persists / 3.6, FULL.hunting)).persists
