"""Critical speeds: brackets of runs, and one Dataset with a name for each definition."""

from __future__ import annotations

import math

import numpy as np
import pytest
import xarray as xr

from rollerrig.analysis.critical_speed import bracket, critical_speed
from rollerrig.analysis.hunting import HuntingRun
from rollerrig.analysis.signals import FinalMotion


def run(speed: float, persists: bool) -> HuntingRun:
    motion = xr.Dataset(attrs={"status": "ok"})
    return HuntingRun(
        speed, "frame", motion, FinalMotion(1e-3, 5.0, 0.0) if persists else FinalMotion(0.0, math.nan, math.nan)
    )


def test_the_bracket_is_the_lowest_onset_whatever_the_order_of_the_runs() -> None:
    found = bracket([run(50.0, True), run(20.0, False), run(40.0, False), run(45.0, True)], 3e-3)
    assert (found.decays, found.persists) == (40.0, 45.0)
    assert found.speed == 42.5


def test_further_runs_divide_the_bracket_in_thirds_until_it_is_narrow() -> None:
    found = bracket([run(40.0, False), run(46.0, True)], 3e-3)
    assert np.allclose(found.further_speeds(5.0), [42.0, 44.0])
    assert found.further_speeds(6.0) == []


@pytest.mark.parametrize("persists", [True, False])
def test_without_an_onset_in_the_range_there_is_no_critical_speed(persists: bool) -> None:
    found = bracket([run(40.0, persists), run(46.0, persists)], 3e-3)
    assert math.isnan(found.speed)
    assert found.further_speeds(0.1) == []


def test_each_definition_has_its_own_name_and_unit() -> None:
    found = critical_speed("wheelset_rollers", methods=["linear", "disturbance"], speeds_kmh=[60.0, 90.0])
    assert set(found.data_vars) == {"linear_critical_speed", "critical_speed_by_disturbance"}
    assert all(math.isnan(value) for value in found.to_array().to_numpy())  # a lone wheelset on springs does not hunt
    assert {value.attrs["units"] for value in found.data_vars.values()} == {"km/h"}


def test_an_unknown_definition_is_refused() -> None:
    with pytest.raises(ValueError, match="nonlinear; allowed: linear, disturbance, continuation"):
        critical_speed("wheelset_rollers", methods=["nonlinear"])
