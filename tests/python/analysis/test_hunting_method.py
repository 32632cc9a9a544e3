"""The method of hunting runs against the slow one before it: random vehicles, speeds, friction, rollers and starts.

Up to 270 km/h and with flanges that are free at the start: above 280 they strike, the motion is irregular, and two runs of any
method grow apart by a thousand within 0.2 s.
"""

from __future__ import annotations

import random

import numpy as np
import pytest

import rollerrig as rr
from rollerrig.analysis.hunting import HuntingSettings, hunting_case

TIGHT = {
    "time.method": "rodas4",
    "time.step": None,
    "time.output_step": "5 ms",
    "time.relative_tolerance": 1e-7,
    "time.absolute_tolerance": 1e-10,
}


def largest_difference(choose: random.Random, duration: float, ellipses: bool) -> tuple[float, str]:
    """Of the lateral motion of all bodies over its largest value, and what was run; starts that leave the flange free."""
    name = choose.choice(["bogie_rollers_constant", "bogie_rollers_constant", "wheelset_rollers", "vehicle_rollers"])
    changes = {
        "contact.friction.mu_0": choose.choice([0.1, 0.3, 0.4, 0.5]),
        "support.roller_radius": choose.choice([0.3, 0.5, 0.725, 1.0, 1.5]),
    }
    if ellipses:
        merging = choose.choice([0.001, 0.01, 0.01, 0.1])
        changes |= {"contact.normal": {"kind": "hertz", "merging_criterion": merging}}
        changes |= {"contact.creep": choose.choice(["kalker_saturated", "table"])}
    speed, start = choose.uniform(60.0, 270.0), choose.choice([1e-3, 3e-3, 5e-3])
    settings = HuntingSettings(disturbance=start, duration=duration)
    case = hunting_case(rr.load_case(name).with_changes(changes), speed / 3.6, settings)
    assert case.time.method == "exponential_adams"
    runs = [rr.simulate(one) for one in (case, case.with_changes(TIGHT))]
    assert [run.attrs["status"] for run in runs] == ["ok", "ok"]
    found, exact = (run["lateral"].to_numpy() for run in runs)
    return float(np.abs(found - exact).max() / np.abs(exact).max()), f"{name} {speed:.1f} km/h {start} {changes}"


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize(("ellipses", "most"), [(False, 1e-3), (True, 5e-3)])
def test_a_hunting_run_is_that_of_the_slow_method(seed: int, ellipses: bool, most: float) -> None:
    error, what = largest_difference(random.Random(seed), 0.3, ellipses)
    assert error < most, what


@pytest.mark.long
@pytest.mark.parametrize(("ellipses", "most", "half"), [(False, 2e-3, 1e-4), (True, 1e-2, 5e-4)])
def test_many_hunting_runs_are_those_of_the_slow_method(ellipses: bool, most: float, half: float) -> None:
    found = [largest_difference(random.Random(1000 + seed), 0.6, ellipses) for seed in range(200)]
    errors = np.array([error for error, _ in found])
    assert errors.max() < most, max(found)
    assert np.median(errors) < half


def test_ellipses_that_vanish_at_full_force_keep_the_method_of_one_step() -> None:
    case = rr.load_case("bogie_rollers_constant").with_changes(
        {"contact.normal": {"kind": "hertz", "merging_criterion": 0.0}}
    )
    assert hunting_case(case, 50.0, HuntingSettings()).time.method == "rodas4"
