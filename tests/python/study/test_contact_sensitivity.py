"""The nonlinear critical speed over the models of normal contact: the table, and the figures that the documentation quotes."""

from __future__ import annotations

import math

from rollerrig.analysis import CriticalSpeedByDisturbance
from rollerrig.config import load_case
from rollerrig.study.contact_sensitivity import (
    sensitivity_cases,
    sensitivity_numbers,
    sensitivity_table,
)


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
        ["hertz", "0.01", "kalker_saturated", "144.0 … 147.6 km/h", "above 180.0 km/h"],
        ["strips", "–", "table", "at most 216.0 km/h", "not computed"],
    ]
    assert sensitivity_numbers(found)["rig"]["hertz, 0.01"] == {"decays_kmh": 144.0, "persists_kmh": 41.0 * 3.6}
