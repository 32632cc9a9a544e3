"""What the contact model changes: one table for every normal contact and creep law."""

from __future__ import annotations

import math

import pytest

from rollerrig.analysis import LimitCycleSettings, linear_critical_speed
from rollerrig.config import load_case
from rollerrig.studies.contact_effects import COUNTERPART, HEADER, contact_effects, effect_rows, effects_section


def test_rows_are_those_of_the_cases_with_each_contact() -> None:
    case = load_case("bogie_track")
    settings = LimitCycleSettings(
        longest=2.0
    )  # not settled by then: the table's form is looked at, not the limit cycle
    speeds = [200.0, 300.0]
    found = contact_effects(
        {"track": case}, speeds, 200.0, normals=["hertz", "strips"], creeps=["kalker_saturated"], settings=settings
    )
    assert [(e.support, e.normal) for e in found] == [("track", "hertz"), ("track", "strips")]
    strips = linear_critical_speed(case.with_changes({"contact.normal": "strips"}), [v / 3.6 for v in speeds])
    assert strips is not None
    assert found[1].critical_kmh == pytest.approx(3.6 * strips.speed, abs=0.1)
    # Hertz' two ellipses of the middle hold the bogie longer than the one patch there is: 310 km/h, outside the range.
    assert math.isnan(found[0].critical_kmh)
    assert found[1].critical_kmh == pytest.approx(250.0, abs=3.0)
    rows = effect_rows(found)
    assert rows[0] == list(HEADER)
    assert all(len(row) == len(HEADER) for row in rows)
    section = effects_section(found, settings.disturbance)
    assert section.title == "What the contact model changes"


def test_each_kind_of_support_has_a_counterpart() -> None:
    for kind, (other, support) in COUNTERPART.items():
        case = load_case("bogie_track").with_changes({"support.use": support})
        assert case.support.data.kind == other != kind
