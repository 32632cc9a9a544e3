"""The method of hunting runs against the slow one before it: random vehicles, speeds, friction, rollers and starts.

Up to 270 km/h and with flanges that are free at the start: above 280 they strike, the motion is irregular, and two runs of any
method grow apart by a thousand within 0.2 s.
"""

from __future__ import annotations

import random

import numpy as np
import pytest

import rollerrig as rr
from rollerrig.analysis.hunting import HuntingSettings, hunting_case, hunting_run

TIGHT = {
    "time.method": "rodas4",
    "time.step": None,
    "time.output_step": "5 ms",
    "time.relative_tolerance": 1e-7,
    "time.absolute_tolerance": 1e-10,
}


def largest_difference(choose: random.Random, duration: float) -> tuple[float, str]:
    """Of the lateral motion of all bodies over its largest value, and what was run; starts that leave the flange free."""
    name = choose.choice(["bogie_rollers_constant", "bogie_rollers_constant", "wheelset_rollers", "vehicle_rollers"])
    changes = {
        "contact.friction.mu_0": choose.choice([0.1, 0.3, 0.4, 0.5]),
        "support.roller_radius": choose.choice([0.3, 0.5, 0.725, 1.0, 1.5]),
    }
    speed, start = choose.uniform(60.0, 270.0), choose.choice([1e-3, 3e-3, 5e-3])
    settings = HuntingSettings(disturbance=start, duration=duration)
    case = hunting_case(rr.load_case(name).with_changes(changes), speed / 3.6, settings)
    assert case.time.method == "exponential_adams"
    runs = [rr.simulate(one) for one in (case, case.with_changes(TIGHT))]
    assert [run.attrs["status"] for run in runs] == ["ok", "ok"]
    found, exact = (run["lateral"].to_numpy() for run in runs)
    return float(np.abs(found - exact).max() / np.abs(exact).max()), f"{name} {speed:.1f} km/h {start} {changes}"


@pytest.mark.parametrize("seed", range(4))
def test_a_hunting_run_is_that_of_the_slow_method(seed: int) -> None:
    error, what = largest_difference(random.Random(seed), 0.3)
    assert error < 1e-3, what


@pytest.mark.long
def test_many_hunting_runs_are_those_of_the_slow_method() -> None:
    found = [largest_difference(random.Random(1000 + seed), 0.6) for seed in range(200)]
    errors = np.array([error for error, _ in found])
    assert errors.max() < 2e-3, max(found)
    assert np.median(errors) < 1e-4


def test_what_decays_ends_at_the_least_length() -> None:
    """Twelfths of 1.4 s do not add up to it in round-off."""
    run = hunting_run((rr.load_case("wheelset_rollers"), 100.0 / 3.6, HuntingSettings(duration=1.4)))
    assert run.decision == "decays"
    assert float(run.motion["time"][-1]) == pytest.approx(1.4, rel=1e-9)
