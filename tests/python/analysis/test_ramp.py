"""The ramp: speeds, perturbations, and what is left of them."""

from __future__ import annotations

import json

import numpy as np
import pytest
import xarray as xr

from rollerrig.analysis import HuntingSettings, RampSettings, end_of_hunting, ramp_run
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


def test_the_end_of_hunting_is_where_it_was_last_seen() -> None:
    speed = np.concatenate([np.linspace(50, 80, 301), np.linspace(80, 50, 301)[1:]])
    down = np.arange(len(speed)) > 300
    lateral = np.where((speed > 65) | (~down & (speed > 75)), 1e-3, 1e-6)
    data = xr.Dataset(
        {"speed": ("time", speed), "lateral": (("time", "body"), lateral[:, None])}, {"body": ["front_frame"]}
    )
    assert end_of_hunting(data, "front_frame") == pytest.approx(65.0, abs=0.11)
    assert np.isnan(end_of_hunting(data.isel(time=slice(0, 350)), "front_frame"))  # still going on
