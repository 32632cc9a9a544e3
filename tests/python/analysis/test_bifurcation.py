"""Limit cycles as periodic solutions: against runs, against differences, at the ends of what is known."""

from __future__ import annotations

import json

import numpy as np
import pytest
import xarray as xr

import rollerrig as rr
from rollerrig import _core
from rollerrig.analysis import bifurcation as module
from rollerrig.analysis.hunting import HuntingSettings, hunting_run
from rollerrig.analysis.mode_table import first_onset, modes_over_speed, zero_crossings
from rollerrig.simulation.run import integrator_settings

CASE, SPEEDS_KMH = "cooperrider_bogie", [220.0, 240.0, 260.0]
"""Hunting begins at 247.3 km/h, with unstable limit cycles; the flange is at 9.1 mm."""


@pytest.fixture(scope="module")
def branch() -> xr.Dataset:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(module, "LONGEST_STEP", 2e-3)
        return rr.bifurcation(CASE, SPEEDS_KMH, largest=10.5e-3)


@pytest.fixture(scope="module")
def shooting() -> module._Shooting:
    modes = modes_over_speed(rr.load_case(CASE), [v / 3.6 for v in SPEEDS_KMH])
    onset = first_onset(zero_crossings(modes))
    assert onset is not None
    return module._Shooting(modes.lineariser, onset.speed, onset.frequency)


@pytest.fixture(scope="module")
def cycle(shooting: module._Shooting) -> module.Cycle:
    small, _ = shooting.cycle(1e-3, shooting.rest)
    assert small is not None
    found, _ = shooting.cycle(2e-3, small)
    assert found is not None
    return found


@pytest.mark.slow
def test_the_branch_begins_at_the_linear_critical_speed(branch: xr.Dataset) -> None:
    first = branch.isel(cycle=0)
    assert float(first["amplitude"]) == pytest.approx(1e-4)
    assert float(first["speed"]) == pytest.approx(branch.attrs["linear_critical_speed_kmh"], rel=2e-4)
    assert float(first["multiplier"]) == pytest.approx(1.0, abs=1e-3)
    assert branch.attrs["ended"].startswith("at the largest amplitude")


def test_a_limit_cycle_comes_back_in_a_run_by_another_method(shooting: module._Shooting, cycle: module.Cycle) -> None:
    simulation = shooting._start(cycle.state, cycle.period, cycle.speed)
    start = simulation.state
    settings = integrator_settings(simulation, shooting._model)
    settings |= {"method": "rodas4", "step": 0.0, "relative_tolerance": 1e-9, "final_time": cycle.period}
    simulation.start(_core.Options(**settings, output_step=cycle.period), t0=0.0, x0=start)
    simulation.advance(cycle.period, np.empty(4), np.empty((4, simulation.width)), 0)
    missed = np.abs(shooting._weight * (simulation.state[shooting._kept] - cycle.state)).max()
    assert missed < 2e-4 * cycle.amplitude


def test_the_multipliers_are_what_becomes_of_a_deviation(shooting: module._Shooting, cycle: module.Cycle) -> None:
    run = shooting._period(cycle.state, cycle.period, cycle.speed)
    assert run is not None
    deviation = np.zeros(len(cycle.state))
    random = np.random.default_rng(3).normal(size=len(shooting._free))
    deviation[shooting._free] = 1e-8 * random / shooting._weight[shooting._free]
    ends = [shooting._period(cycle.state + sign * deviation, cycle.period, cycle.speed) for sign in (1.0, -1.0)]
    assert all(ends)
    by_difference = 0.5 * (ends[0].end - ends[1].end)
    by_tangents = run.monodromy @ deviation
    size = np.abs(shooting._weight * by_difference).max()
    assert np.abs(shooting._weight * (by_tangents - by_difference)).max() < 1e-3 * size
    assert abs(cycle.multipliers[0]) > 1.0
    assert not cycle.stable
    # a shift along the cycle stays what it is: M f = f
    shifted = run.monodromy @ run.slope
    assert shooting._weight * shifted == pytest.approx(shooting._weight * run.slope, abs=1e-3 * np.abs(run.slope).max())


@pytest.mark.slow
def test_speed_over_amplitude_is_that_of_differences(branch: xr.Dataset) -> None:
    part = branch.where(branch["amplitude"] < 7e-3, drop=True)
    between = np.diff(part["speed"]) / np.diff(1e3 * part["amplitude"])
    mean = 0.5 * (part["speed_slope"].to_numpy()[1:] + part["speed_slope"].to_numpy()[:-1])
    assert between == pytest.approx(mean, rel=0.06)


@pytest.mark.slow
def test_stable_limit_cycles_are_where_runs_end(branch: xr.Dataset) -> None:
    last = branch.isel(cycle=-1)
    assert bool(last["stable"])
    speed = float(last["speed"]) / 3.6
    run = hunting_run((rr.load_case(CASE), speed, HuntingSettings(disturbance=8e-3, duration=20.0)))
    assert run.persists
    leading = run.motion["lateral"].sel(body="wheelset_1")
    assert float(leading.isel(time=slice(-400, None)).max()) == pytest.approx(float(last["amplitude"]), rel=2e-3)


@pytest.mark.slow
def test_below_the_fold_every_motion_decays_and_above_it_a_large_one_persists(branch: xr.Dataset) -> None:
    (fold,) = json.loads(branch.attrs["folds"])
    assert fold["speed_kmh"] == pytest.approx(240.90, abs=0.02)
    assert branch.attrs["nonlinear_critical_speed_kmh"] == fold["speed_kmh"]
    settings = HuntingSettings(disturbance=9e-3, duration=10.0)
    assert hunting_run((rr.load_case(CASE), (fold["speed_kmh"] - 1.0) / 3.6, settings)).decays
    assert hunting_run((rr.load_case(CASE), (fold["speed_kmh"] + 6.0) / 3.6, settings)).persists
    stable = branch["stable"].to_numpy() == 1
    assert (stable == (branch["speed_slope"].to_numpy() > 0.0)).all()


def cycle_of(amplitude: float, speed: float, multiplier: float) -> module.Cycle:
    """One of an invented branch."""
    return module.Cycle(amplitude, speed, 0.2, np.zeros(1), np.array([multiplier + 0j]), np.zeros(3), 0.0)


@pytest.mark.parametrize(
    ("speeds", "multipliers", "lowest"),
    [
        ([59.0, 57.0, 58.0], [1.1, 1.0, 0.9], 57.0),  # subcritical: from the fold on, which is itself on the border
        ([61.0, 62.0, 63.0], [0.9, 0.8, 0.7], 60.0),  # supercritical: from the linear critical speed on
        ([61.0, 62.0, 58.0, 59.0], [0.9, 1.0, 1.0, 0.9], 58.0),  # and back below it
        ([59.0, 55.0, 56.0, 57.0], [1.1, 1.2, 1.1, 0.9], 57.0),  # that fold has no stable cycle
        ([59.0, 58.0], [1.1, 1.2], np.nan),
        ([], [], np.nan),
    ],
)
def test_the_nonlinear_critical_speed_is_the_lowest_of_a_stable_cycle(
    speeds: list[float], multipliers: list[float], lowest: float
) -> None:
    cycles = [cycle_of(1e-3 * k, *one) for k, one in enumerate(zip(speeds, multipliers, strict=True), 1)]
    assert module._nonlinear_critical_speed(cycles, 60.0) == pytest.approx(lowest, nan_ok=True)


def test_a_range_without_a_linear_critical_speed_is_refused() -> None:
    with pytest.raises(ValueError, match="no linear critical speed"):
        rr.bifurcation(CASE, [100.0, 120.0])


@pytest.mark.slow
def test_the_picture_has_stable_and_unstable_parts(branch: xr.Dataset) -> None:
    (axes,) = rr.plot.bifurcation_diagram(branch).axes
    labels = [one.get_label() for one in axes.get_lines()]
    assert "stable" in labels
    assert "unstable" in labels
