"""What is left of the sideways motion of a run, on motions made by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest
import xarray as xr

import rollerrig as rr
from rollerrig.analysis.hunting import lateral_rest, not_decided


@pytest.fixture(scope="module")
def short() -> xr.Dataset:
    return rr.simulate(rr.load_case("wheelset_rollers").with_changes({"time.duration": "0.6 s"}))


def moved(short: xr.Dataset, amplitude: float, rate: float, frequency: float = 20.0) -> xr.Dataset:
    """The run with another sideways motion of its wheelset [m, 1/s, Hz]."""
    run, t = short.copy(deep=True), short["time"].to_numpy()
    run["lateral"].loc[{"body": "wheelset_1"}] = amplitude * np.exp(rate * t) * np.sin(2 * np.pi * frequency * t)
    return run


@pytest.mark.parametrize(("rate", "persists"), [(0.0, True), (0.3, True), (-1.0, False)])
def test_a_motion_persists_where_it_does_not_decay(short: xr.Dataset, rate: float, persists: bool) -> None:
    rest = lateral_rest(moved(short, 2e-3, rate))
    assert rest is not None
    assert (rest.body, rest.decision) == ("wheelset_1", "persists" if persists else "decays")
    assert rest.final.frequency == pytest.approx(20.0, rel=0.01)
    assert rest.final.rate == pytest.approx(rate, abs=0.05)


def test_what_has_decayed_is_calm(short: xr.Dataset) -> None:
    rest = lateral_rest(moved(short, 2e-3, -60.0))
    assert rest is not None
    assert rest.decision == "decays"
    assert rest.final.amplitude == 0.0
    assert 1e-3 < rest.largest < 2e-3


def test_nothing_is_said_where_it_cannot_be(short: xr.Dataset) -> None:
    assert lateral_rest(moved(short, 1e-6, 0.0)) is None  # was never disturbed
    assert lateral_rest(moved(short, 2e-3, 0.0, 0.5)) is None  # too short to tell
    assert lateral_rest(moved(short, 2e-3, 0.0).assign_attrs(status="wheel_lift")) is None
    braked = moved(short, 2e-3, 0.0)
    braked["speed"] = braked["speed"] * xr.DataArray(np.linspace(1.0, 0.9, braked.sizes["time"]), dims="time")
    assert lateral_rest(braked) is None
    creeping = moved(short, 2e-3, -60.0)
    creeping["distance"] = 0.1 * creeping["distance"]
    assert lateral_rest(creeping) is None  # not a turn of its wheels
    rough = moved(short, 2e-3, 0.0)
    rough["rail_lateral"] = rough["lateral"]
    assert lateral_rest(rough) is None


def test_a_run_too_short_for_waves_says_so_in_place_of_numbers() -> None:
    begin = "after 0.6 s it was not decided whether the motion persists"
    assert not_decided(0.6, 0.0, math.nan) == f"{begin}: too few waves to tell"
    assert not_decided(0.6, 2e-3, -0.1) == f"{begin}: an amplitude of 2 mm that changes by -10 %/s"
