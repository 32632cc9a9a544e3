"""Where the paper's 100 km/h lie among what it leaves open: docs/studies/paper.md follows from the data, these from the plans."""

from __future__ import annotations

import pytest

import rollerrig as rr
from rollerrig.config.load.plan import load_plan
from rollerrig.contact_analysis.static_contact import contact
from validation.test_page import differences
from validation.write_paper_map import HEADING, NEXT, PAGE, PLANS, SPEED, data, on_rig_and_rails, onset, section


@pytest.mark.slow
def test_the_lines_are_what_the_data_give() -> None:
    written = PAGE.read_text(encoding="utf-8").partition(HEADING)[2].partition(NEXT)[0]
    assert differences(HEADING + written, section()) == []


def test_points_near_100_kmh_are_those_of_the_data() -> None:
    points = on_rig_and_rails()
    assert list(points["here"]) == pytest.approx(list(points[SPEED]), abs=0.2)  # as close as a crossing is looked for


@pytest.mark.parametrize("number", [0, 100, 200])
def test_samples_are_those_of_the_data(number: int) -> None:
    row = data(PLANS[0]).iloc[number]
    assert 3.6 * onset(row.to_dict()).speed == pytest.approx(row[SPEED], abs=0.2)


@pytest.mark.parametrize("plan", PLANS)
def test_the_data_are_of_the_plans_that_ship(plan: str) -> None:
    shipped, rows = load_plan(plan).plan, data(plan)
    assert {one.label for one in shipped.vary} == set(rows.dropna(axis=1).columns) - {SPEED, "plan"}
    counts = [len(one.values) if one.values else one.count for one in shipped.vary]
    cases = shipped.design.samples or counts[0] * counts[1] * counts[2] * counts[3]
    assert len(rows) == cases


def test_the_gauge_decides_the_equivalent_conicity() -> None:
    found = {
        gauge: float(rr.conicity("s1002", "uic60_benchmark_1_40", gauge=gauge)["conicity"][0, 0])
        for gauge in (1.435, 1.441)
    }
    assert found == pytest.approx({1.435: 0.6, 1.441: 0.02}, abs=0.02)


def test_a_tenth_of_a_millimetre_of_gauge_can_double_the_critical_speed() -> None:
    near = data(PLANS[1])
    of_gauge = near.sort_values("gauge").groupby(["roller_radius", "material", "creep_law"])[SPEED]
    assert of_gauge.apply(lambda speed: (speed / speed.shift()).max()).max() > 2.0


def test_low_critical_speeds_are_where_one_of_two_ellipses_appears_or_vanishes() -> None:
    def loads(gauge: float, normal: str) -> list[float]:
        changes = {"contact.normal": normal, "support.gauge": gauge}
        table = contact(rr.load_case("bogie_rollers_constant").with_changes(changes), [(0.0, 0.0)])
        return [float(n) for n in table["normal"][(table["side"] == "left").to_numpy()] if n > 1e3]

    assert [len(loads(gauge, "hertz")) for gauge in (1.4338, 1.4350, 1.4360)] == [1, 2, 1]
    assert [len(loads(gauge, "strips")) for gauge in (1.4338, 1.4340, 1.4355, 1.4360)] == [1, 1, 1, 1]
