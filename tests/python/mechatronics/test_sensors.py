"""Estimators and force sensors of a rig: they find the force that acts, and a rig lives with what they add."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

from rollerrig import load_case, simulate
from rollerrig.assembly.actuators import assemble_with_actuators
from rollerrig.config import Case, Rig
from rollerrig.simulation.mechatronics import estimator_response

SENSORS = {
    "sensors.roller_torque": {"bandwidth": "200 Hz", "noise": 20.0, "resolution": 5.0},
    "sensors.axle_load": {"bandwidth": "50 Hz", "noise": 300.0, "resolution": 100.0},
}


def brake_case(**changes: object) -> Case:
    return load_case("adhesion_brake").with_changes({"time.duration": "3.5 s", **changes})


def tracking(run: xr.Dataset) -> float:
    error = 0.46 * (run["axle_speed"] - run["virtual_speed"]) / run["train_speed"]
    return float(np.sqrt((error**2).mean()))


@pytest.mark.parametrize("kind", ["filtered_derivative", "observer", "kalman"])
def test_estimates_find_the_force_of_the_contact(kind: str) -> None:
    case = brake_case(**{"rig_control.estimator.kind": kind})
    run = simulate(case)
    rig = case.support.data
    assert isinstance(rig, Rig)
    late = run.sel(time=slice(1.5, None))
    # What turned the roller: its momentum, less its drive's. (D1)
    span = float(late["time"][-1] - late["time"][0])
    spun = rig.roller_inertia[1] * (late["roller_speed"][-1] - late["roller_speed"][0])
    acted = (spun / span - late["roller_torque"].integrate("time") / span) / rig.roller_radius
    found = late["estimated_force"].integrate("time") / span
    # The force falls by 4 kN within these 2 s, of which the estimates see what was 8 to 12 ms ago: 25 N.
    np.testing.assert_allclose(found, acted, rtol=0.01)
    assert float(np.abs(acted).min()) > 2000.0
    assert tracking(run) < 0.01


def test_the_observer_answers_later_than_it_is_named() -> None:
    """Of second order with damping 0.8: 0.871 of its natural frequency, 2 zeta / omega late."""
    model = assemble_with_actuators(brake_case())
    found = estimator_response(model)
    bandwidth, delay = found["force"]
    assert bandwidth == pytest.approx(0.871 * 20.0, rel=0.01)
    assert delay == pytest.approx(1.6 / (2 * np.pi * 20.0) - 0.5e-3, rel=0.01)  # half a sample early: T is held ahead


def test_force_sensors_lag_scatter_and_repeat() -> None:
    case = brake_case(**SENSORS, **{"time.output_step": "1 ms"})
    run, again = simulate(case), simulate(case)
    torque, load = run["measured_roller_torque"], run["measured_load"]
    assert torque.to_numpy().tobytes() == again["measured_roller_torque"].to_numpy().tobytes()
    assert np.abs(torque / 5.0 - np.round(torque / 5.0)).max() < 1e-9
    blind = simulate(case.with_changes({"rig_control.estimator.torque": "commanded"}))  # the noise does not come back
    scatter = (blind["measured_roller_torque"] - blind["roller_torque"]).sel(time=slice(0.01, 0.5))
    assert float(scatter.std()) == pytest.approx(20.0, rel=0.1)  # 980 readings before the brake is applied: 4 errors
    weight = run["vertical_force"].isel(time=0).sum() / 2
    assert float((load.isel(time=0) - weight).max()) < 1200.0  # four standard deviations
    other = simulate(case.with_changes({"sensors.seed": 5}))
    assert not np.array_equal(torque, other["measured_roller_torque"])
    assert tracking(run) < 0.01


def test_the_controller_lives_with_what_it_is_given() -> None:
    """Commanded for measured torque and measured for computed loads: the law still holds the wheels."""
    plain = simulate(brake_case())
    for changes in ({"rig_control.estimator.torque": "commanded"}, {"rig_control.loads": "measured"}):
        run = simulate(brake_case(**changes))
        assert tracking(run) < 0.01
        assert not np.array_equal(run["virtual_speed"], plain["virtual_speed"])


def test_a_sensor_ends_at_its_range() -> None:
    run = simulate(brake_case(**{"sensors.roller_torque": {"range": 500.0}}))
    assert float(np.abs(run["measured_roller_torque"]).max()) == 500.0
    assert float(np.abs(run["roller_torque"]).max()) > 1000.0
