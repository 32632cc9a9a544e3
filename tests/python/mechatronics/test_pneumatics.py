"""A brake test with dump valves that take time and a reservoir that can run out."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

from rollerrig import ConfigError, load_case, simulate
from rollerrig.config import Case, case_from_toml

AMBIENT = 101325.0


def braked(duration: str = "8 s", **air: object) -> Case:
    changes = {"brake.air": {"kind": "reservoir", **air}, "time.duration": duration}
    return load_case("adhesion_brake").with_changes(changes)


@pytest.fixture(scope="module")
def run() -> xr.Dataset:
    return simulate(braked())


def test_air_is_conserved_over_a_run(run: xr.Dataset) -> None:
    """(A13): what the main pipe gave is in the volumes or went out; to round-off of the single precision of results."""
    in_reservoir = 0.1 * (run["reservoir_pressure"] - run["reservoir_pressure"][0]) / AMBIENT
    in_cylinders = 5e-3 * run["cylinder_pressure"].sum("axle") / AMBIENT
    balance = run["main_pipe_air"] - in_reservoir - in_cylinders - run["exhausted_air"].sum("axle")
    scale = float(run["air"].sum("axle")[-1])
    assert scale > 0.05, "some air was used"
    assert float(abs(balance).max()) < 1e-6 * scale


def test_valves_move_one_dead_time_after_their_command(run: xr.Dataset) -> None:
    """20 ms: two outputs of 10 ms."""
    wanted, moved = run["valve"].isel(axle=0) == 2, run["outlet_open"].isel(axle=0) == 1
    commanded = np.flatnonzero(np.diff(wanted.to_numpy().astype(int)) == 1)
    opened = np.flatnonzero(np.diff(moved.to_numpy().astype(int)) == 1)
    assert len(opened) >= 3
    for index in opened:
        assert index - commanded[commanded <= index][-1] in (1, 2)


def test_a_small_reservoir_that_is_not_fed_runs_out(run: xr.Dataset) -> None:
    small = simulate(braked(reservoir_volume="20 l", charging_conductance=0.0))
    assert float(small["main_pipe_air"][-1]) == 0.0
    assert (np.diff(small["reservoir_pressure"]) <= 1e-3).all()
    assert float(small["reservoir_pressure"][-1]) < 0.75 * float(run["reservoir_pressure"][-1])


@pytest.mark.parametrize(
    ("air", "message"),
    [
        ({"vent_conductance": -1e-7}, "brake.air.vent_conductance: -1e-07; allowed: a number in m^3/(s Pa) or a text"),
        ({"fill_conductance": 0.0}, "brake.air.fill_conductance: 0"),
        ({"reservoir_volume": 0.0}, "brake.air.reservoir_volume: 0"),
        (
            {"reservoir_pressure": 0.0},
            "brake.air.reservoir_pressure: 0 bar; a reservoir that is empty from the start brakes nothing",
        ),
        (
            {"main_pipe_pressure": 0.0},
            "brake.air.main_pipe_pressure: 0 bar; a reservoir that is empty from the start brakes nothing",
        ),
        (
            {"opening_time": "20.5 ms"},
            "brake.air.opening_time: 20.5 ms; allowed: a multiple of time.sampling_step, 1 ms; the nearest is 20 ms",
        ),
        ({"critical_ratio": 1.0}, "brake.air.critical_ratio: 1"),
        ({"fill_rate": 6.0}, "brake.air.fill_rate"),
    ],
)
def test_what_no_brake_has_is_refused_by_name(air: dict[str, object], message: str) -> None:
    with pytest.raises(ConfigError) as caught:
        braked(**air)
    assert message in str(caught.value)


def test_a_conductance_may_be_written_as_data_sheets_do() -> None:
    case = braked(fill_conductance="20 dm^3/(s bar)")
    assert case.brake is not None
    assert case.brake.air.kind == "reservoir"
    assert case.brake.air.fill_conductance == pytest.approx(2e-7, rel=1e-15)
    assert case_from_toml(case.to_toml()) == case
