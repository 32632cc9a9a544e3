"""`rollerrig wsp --against`: two systems of wheel slide protection, test by test."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.stats import ttest_1samp

from reported import unexplained, unreported
from rollerrig import ConfigError, load_case
from rollerrig.config import Case, Programme
from rollerrig.config.load.resolve import resolve_programme
from rollerrig.config.read import Document
from rollerrig.study.ensemble import Estimate, estimate
from rollerrig.study.frame import Outcome
from rollerrig.study.protection_comparison import (
    POWER,
    Difference,
    ProtectionComparison,
    System,
    differences,
    pairs_needed,
)
from rollerrig.study.wsp import Results

LOW = {"name": "low_26", "kind": "uniform", "speed": "26 km/h", "rail": "low", "duration": "20 s"}


def programme(*stops: Mapping[str, Any]) -> Programme:
    tables = {"name": "short", "starts": 4, "stop": list(stops or [LOW])}
    found, problems = resolve_programme(Document(tables, "mine.toml", Path()))
    assert found is not None, problems
    return found


@pytest.fixture(scope="module")
def case() -> Case:
    """That counts as stationary early, to be short."""
    return load_case("adhesion_brake").with_changes({"motion.stop_speed": "5 m/s"})


@pytest.fixture(scope="module")
def other(case: Case) -> Case:
    """Vents later, so that its wheels slide deeper."""
    changed = case.with_changes({"slide_protection.vent_slip": 0.5, "slide_protection.vent_slip_speed": "3 m/s"})
    return changed.model_copy(update={"name": "later"})


@pytest.fixture(scope="module")
def outcome(case: Case, other: Case) -> Outcome[Mapping[System, Results]]:
    found = ProtectionComparison(case, other, programme(), quick=True).run()
    assert found is not None
    return found


@pytest.mark.slow
def test_what_differs_is_said_and_every_number_is_explained(outcome: Outcome[Any]) -> None:
    changes = outcome.numbers["changes"]
    assert list(changes) == ["slide_protection.vent_slip", "slide_protection.vent_slip_speed"]
    assert changes["slide_protection.vent_slip_speed"]["second"] == "3 m/s"
    quantities = ProtectionComparison.quantities
    assert unexplained(quantities, outcome.numbers) == []
    assert unreported(quantities, outcome.numbers) == []


@pytest.mark.slow
def test_differences_are_those_of_tests_in_pairs(outcome: Outcome[Mapping[System, Results]]) -> None:
    """Draw by draw, from the records themselves; a system that vents later slides deeper on the same draws."""
    for on in ("track", "rig"):
        one, two = (outcome.results[system]["low_26"].tests[on] for system in ("first", "second"))
        pairs = np.subtract(two.values("distance_m"), one.values("distance_m"))
        found = outcome.numbers["stops"]["low_26"][on]["distance"]
        assert found["difference"]["mean"] == pytest.approx(pairs.mean(), rel=1e-12)
        assert found["difference"]["mean"] == pytest.approx(found["second"] - found["first"], rel=1e-9)
        assert found["effect"] == pytest.approx(pairs.mean() / pairs.std(ddof=1), rel=1e-9)
        assert found["difference"]["low"] < found["difference"]["mean"] < found["difference"]["high"]
        assert two.tests[0].measures["largest_slip"] > one.tests[0].measures["largest_slip"]


@pytest.mark.slow
def test_files_of_both_systems_and_the_page(outcome: Outcome[Any], tmp_path: Path) -> None:
    written = {path.relative_to(tmp_path).as_posix() for path in outcome.write(tmp_path)}
    expected = {"tests_first_low_26_quick.csv", "tests_second_low_26_quick.csv", "figures/difference_distance.png"}
    assert expected <= written
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert "slide_protection.vent_slip" in page
    assert "tests that would decide" in page


@pytest.mark.slow
def test_nothing_is_better_by_a_bad_run(case: Case, other: Case, outcome: Outcome[Mapping[System, Results]]) -> None:
    """A test of either system that ended early leaves every criterion of its stop undecided, and is named."""
    results = dict(outcome.results)
    stop = results["second"]["low_26"]
    track = stop.tests["track"]
    broken = replace(track.tests[0], status="lost_contact", message="lost contact")
    tests = {**stop.tests, "track": replace(track, tests=(broken, *track.tests[1:]))}
    results["second"] = {"low_26": replace(stop, tests=tests)}
    for one in differences(results, "low_26", "track"):
        assert one.better == "not decided"
        assert any(
            why.startswith("second: 1 of 2 tests came to their end, one ended early: lost contact")
            for why in one.reasons
        )


def of(
    values: list[float], criterion: str = "distance", systematic: float = 0.0, why: tuple[str, ...] = ()
) -> Difference:
    found = replace(estimate(values), systematic=systematic)
    level = Estimate(100.0, 1.0, 7.0)
    deviation = found.standard_error * math.sqrt(len(values))
    return Difference(criterion, level, level, found, deviation, why)


def test_the_better_system_is_that_of_the_criterions_good_side() -> None:
    shorter = [-3.0, -2.0, -2.5, -3.5]
    assert of(shorter).better == "second"
    assert of(shorter, "k_wet").better == "first"
    assert of([3.0, 2.0, 2.5, 3.5]).better == "first"
    assert of([-3.0, 2.0, 0.5, 0.1]).better == "not decided"
    assert of([0.0, 0.0, 0.0]).better == "neither"
    assert of(shorter, systematic=3.0).better == "not decided"  # finer steps change as much
    assert of(shorter, why=("first: no test",)).better == "not decided"
    assert of([math.nan, 1.0, 2.0]).better == "not decided"
    assert of([1.0]).better == "not decided"


def test_number_of_tests_finds_the_effect_as_often_as_it_says() -> None:
    """Against 4000 drawn experiments, and the textbook's 34 pairs for an effect of one half."""
    assert pairs_needed(0.5) == 34
    for effect in (0.4, 1.0, 2.0):
        count = int(pairs_needed(effect))
        draws = np.random.default_rng(3).normal(effect, 1.0, size=(4000, count))
        share = float(np.mean(ttest_1samp(draws, 0.0, axis=1).pvalue < 0.05))
        assert POWER - 0.03 < share < POWER + 0.12  # whole tests: few of them overshoot
        assert float(np.mean(ttest_1samp(draws[:, : count - 1], 0.0, axis=1).pvalue < 0.05)) < POWER + 0.02
    assert math.isnan(pairs_needed(1e-3))
    assert math.isnan(of([-3.0, -2.0, -2.5, -3.5], systematic=3.0).tests_needed)


def test_what_cannot_be_compared_is_refused_in_a_line(case: Case) -> None:
    with pytest.raises(ConfigError, match=r"time.sampling_step: 5·10⁻⁴ s; allowed: 0.001 s"):
        ProtectionComparison(case, case.with_changes({"time.sampling_step": "0.5 ms"}), programme())
    with pytest.raises(ConfigError, match=r"the same case; needed: a system that differs"):
        ProtectionComparison(case, case, programme())
    with pytest.raises(ConfigError, match="slide_protection: missing"):
        ProtectionComparison(case, case.with_changes({"slide_protection": None}), programme())
    with pytest.raises(ConfigError, match=r"vehicle.cut: 'vehicle'; allowed: 'leading_bogie', as in adhesion_brake"):
        ProtectionComparison(load_case("adhesion_brake"), load_case("adhesion_coach"), programme())


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("ensemble.adhesion", 0.2),
        ("brake.demand", [[0.0, 0.0], [0.1, "3 bar"]]),
        ("train.mass", "20 t"),
        ("vehicle.body.bogie_frame.mass", "2.8 t"),
        ("motion.stop_speed", "4 m/s"),
        ("rig_control.sample_time", "2 ms"),
        ("adhesion.recovered.friction.mu_0", 0.2),
    ],
)
def test_systems_whose_tests_are_not_the_same_are_refused_with_the_key(
    case: Case, other: Case, key: str, value: Any
) -> None:
    with pytest.raises(ConfigError) as refused:
        ProtectionComparison(case, other.with_changes({key: value}), programme())
    assert [problem.key for problem in refused.value.problems] == [key]


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("motion.speed", "100 km/h"),
        ("time.duration", "30 s"),
        ("train.gradient", -0.01),
        ("brake.demand", [[0.0, 0.0], [0.2, "3.8 bar"]]),  # as large: the stop has no pressure of its own
        ("adhesion.blend", "3 m"),
    ],
)
def test_what_every_stop_sets_itself_may_differ(case: Case, other: Case, key: str, value: Any) -> None:
    study = ProtectionComparison(case, other.with_changes({key: value}), programme())
    assert [row[0] for row in study.changes] == ["slide_protection.vent_slip", "slide_protection.vent_slip_speed"]
    with pytest.raises(ConfigError, match="the same case; needed: a system that differs"):
        ProtectionComparison(case, case.with_changes({key: value}), programme())


def test_a_demand_may_differ_where_every_stop_has_its_own_pressure(case: Case, other: Case) -> None:
    weaker = other.with_changes({"brake.demand": [[0.0, 0.0], [0.1, "3 bar"]]})
    ProtectionComparison(case, weaker, programme({**LOW, "pressure": "3 bar"}))
    with pytest.raises(ConfigError, match=r"brake\.demand"):  # of one stop of two
        ProtectionComparison(case, weaker, programme({**LOW, "pressure": "3 bar"}, {**LOW, "name": "other"}))


def test_protections_differ_in_valves_sensors_and_faults_and_idle_valves_are_told(case: Case, other: Case) -> None:
    changes = {
        "brake.air": {"kind": "reservoir", "opening_time": "60 ms"},
        "brake.volume": "4 l",
        "sensors.vehicle": {"kind": "pulse_period", "teeth": 100},
        "fault": [{"axle": "wheelset_1", "kind": "never_vents"}],
    }
    found = ProtectionComparison(case, other.with_changes(changes), programme())
    numbers = {
        "case": "a",
        "against": "b",
        "stops": {},
        "sums": dict.fromkeys(("first", "second", "neither", "not_decided"), 0),
    }
    assert found.summary({}, numbers)[0].startswith("later: Dump valves never open in stepwise filling")
