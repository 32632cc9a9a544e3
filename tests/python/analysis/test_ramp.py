"""The ramp: speeds, perturbations, and what is left of them."""

from __future__ import annotations

import json
import random

import numpy as np
import pytest
import xarray as xr

from rollerrig.analysis import ramp as module
from rollerrig.analysis.hunting import HuntingSettings
from rollerrig.analysis.ramp import RampSettings, end_of_hunting, ramp_run
from rollerrig.config import load_case

RAMP = RampSettings(100 / 3.6, 120 / 3.6, acceleration=20 / 3.6, perturbation_every=10 / 3.6)


@pytest.fixture(scope="module")
def ramp():
    return ramp_run((load_case("bogie_rollers_constant"), RAMP, HuntingSettings(output_step=5e-3)), lambda _f, _t: None)


def test_speed_goes_up_and_down_again(ramp) -> None:
    time = ramp["time"].to_numpy()
    expected = np.interp(time, [0.0, 1.0, 2.0], [100 / 3.6, 120 / 3.6, 100 / 3.6])
    assert ramp["speed"].to_numpy() == pytest.approx(expected, rel=1e-9)
    assert np.all(np.diff(time) > 0)
    assert ramp.attrs["status"] == "ok"


def test_the_nudge_moves_all_bodies_sideways(ramp) -> None:
    (at,) = json.loads(ramp.attrs["perturbation_times_s"])
    assert at == pytest.approx(0.5)
    after = ramp["lateral"].sel(time=slice(at, at + 0.021))
    moved = (after.isel(time=-1) - after.isel(time=0)).to_numpy()
    # 0.05 m/s over 20 ms, less what the creep forces take
    assert np.all((moved > 0.2e-3) & (moved <= 1.05e-3))


def test_energy_balances_over_all_segments(ramp) -> None:
    assert ramp.attrs["energy_relative_residual"] < 1e-5  # at a tolerance of 1e-4 per step


TIGHT = HuntingSettings(relative_tolerance=1e-6, absolute_tolerance=1e-9)


def largest_difference(seed: int, monkeypatch: pytest.MonkeyPatch) -> float:
    """Of the amplitudes of all bodies in any half second, over the largest: a ramp with ellipses, by its method and by `rodas4`.

    Up to the speeds at which the flanges strike: beyond, runs of any method and tolerance differ by some percent.
    """
    choose = random.Random(seed)
    material, fastest = choose.choice([("steel", 240.0), ("paper", 180.0)])
    changes = {
        "contact.friction.mu_0": choose.choice([0.2, 0.3, 0.4]),
        "contact.normal": {"kind": "hertz", "merging_criterion": choose.choice([0.001, 0.01, 0.1])},
        "contact.creep": choose.choice(["kalker_saturated", "table"]),
        "contact.material": material,
    }
    high = choose.uniform(100.0, fastest) / 3.6
    settings = RampSettings(high - 20.0 / 3.6, high, 20.0 / 3.6, perturbation_every=10.0 / 3.6)
    case = load_case("bogie_rollers_constant").with_changes(changes)
    runs = [ramp_run((case, settings, HuntingSettings()), lambda _f, _t: None)]
    with monkeypatch.context() as slow:
        slow.setattr(module, "_method", lambda _case: {})
        runs.append(ramp_run((case, settings, TIGHT), lambda _f, _t: None))
    assert [run.attrs["status"] for run in runs] == ["ok", "ok"]
    calls = [json.loads(run.attrs["solver_statistics"])["jacobian_calls"] for run in runs]
    assert 10 * calls[0] < calls[1]  # of two methods
    assert runs[0].attrs["energy_relative_residual"] < 1e-5
    lateral = [np.abs(run["lateral"].transpose("time", "body").to_numpy()) for run in runs]
    count = min(map(len, lateral)) // 100
    fast, exact = (one[: 100 * count].reshape(count, 100, -1).max(axis=1) for one in lateral)
    return float(np.abs(fast - exact).max() / exact.max())


def test_a_ramp_with_ellipses_is_that_of_the_slow_method(monkeypatch: pytest.MonkeyPatch) -> None:
    assert max(largest_difference(seed, monkeypatch) for seed in (0, 1)) < 5e-3


@pytest.mark.long
def test_many_ramps_with_ellipses_are_those_of_the_slow_method(monkeypatch: pytest.MonkeyPatch) -> None:
    found = [largest_difference(seed, monkeypatch) for seed in range(100, 180)]
    assert max(found) < 1e-2, 100 + np.argsort(found)[-3:]
    assert np.median(found) < 5e-4


def test_the_end_of_hunting_is_where_it_was_last_seen() -> None:
    speed = np.concatenate([np.linspace(50, 80, 301), np.linspace(80, 50, 301)[1:]])
    down = np.arange(len(speed)) > 300
    lateral = np.where((speed > 65) | (~down & (speed > 75)), 1e-3, 1e-6)
    data = xr.Dataset(
        {"speed": ("time", speed), "lateral": (("time", "body"), lateral[:, None])}, {"body": ["front_frame"]}
    )
    assert end_of_hunting(data, "front_frame") == pytest.approx(65.0, abs=0.11)
    assert np.isnan(end_of_hunting(data.isel(time=slice(0, 350)), "front_frame"))  # still going on
