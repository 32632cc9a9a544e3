"""Wheels that their brakes lock on the rig, without slide protection: the drives give the rail's force and do not ring."""

import math

import numpy as np
import pytest
import xarray as xr

from rollerrig import simulate
from rollerrig.analysis.control_loop import creep_slope, loop_of
from rollerrig.analysis.loop_stability import ABOVE, growth, rolling_plant
from rollerrig.analysis.slide_statistics import torque_ripple
from rollerrig.assembly.actuators import friction_brake
from rollerrig.config import Case, load_case

LOCKED = slice(8.0, 14.0)
"""Both wheels stand by then, and the train still runs [s]."""


def unprotected(estimator: str, **changes: object) -> Case:
    dotted = {"rig_control.estimator.kind": estimator, **changes}
    return load_case("adhesion_brake").with_changes(
        {"slide_protection": None, "time.duration": "14 s", "contact.normal": "hertz", **dotted}
    )


def locked_part(case: Case) -> xr.Dataset:
    part = simulate(case).sel(time=LOCKED)
    radius = case.vehicle.data.wheel.radius
    assert (abs(part["axle_speed"]) * radius < 0.1).all(), "the wheels are meant to stand"
    assert (part["train_speed"] > 10.0).all()
    return part


AS_ESTIMATED = {"rig_control.axle_torque.kind": "estimated", "rig_control.drive_command.kind": "direct"}

STANDS = 1e-4
"""Speed at which a brake's torque over speed is taken, within its regularisation [rad/s]."""


def held_growth(case: Case) -> tuple[float, float]:
    """Rate [1/s] and frequency [Hz] of the sampled loop of one axle whose wheel is held, its torque as estimated, no feedback."""
    at_rest = creep_slope(case) * case.motion.speed / case.contact.creepage_regularisation_speed
    loop = loop_of(case.with_changes(AS_ESTIMATED), at_rest, sliding=True)
    if loop is None or case.brake is None:
        return math.nan, math.nan
    holds = -friction_brake(case.brake).torque(max(row[1] for row in case.brake.demand), STANDS) / STANDS
    return growth(loop.scaled(0.0), rolling_plant(loop, holds), above=ABOVE)


def test_the_loop_of_a_held_wheel_grows_with_some_estimators_and_has_none_with_exact_torque() -> None:
    rates = {kind: held_growth(unprotected(kind))[0] for kind in ("observer", "kalman", "filtered_derivative")}
    assert rates["kalman"] > 1.0
    assert rates["filtered_derivative"] < rates["observer"] < rates["kalman"]
    exact = load_case("adhesion_brake").with_changes({"rig_control.estimator": {"kind": "exact"}})
    assert math.isnan(held_growth(exact)[0])


@pytest.mark.parametrize(
    ("estimator", "compensation"),
    [
        *((estimator, AS_ESTIMATED) for estimator in ("observer", "kalman", "filtered_derivative", "exact")),
        ("observer", {}),
        ("kalman", {}),
        ("observer", {"rig_control.drive_command.kind": "torque_loop"}),
    ],
)
def test_drives_of_locked_wheels_give_the_force_of_the_rail_and_do_not_ring(
    estimator: str, compensation: dict[str, object]
) -> None:
    case = unprotected(estimator, **compensation)
    part = locked_part(case)
    assert torque_ripple(part["time"].to_numpy(), part["roller_torque"].to_numpy()).rms < 100.0
    roller = case.support.data.roller_radius
    np.testing.assert_allclose(-part["roller_torque"] / roller, part["virtual_force"], rtol=0.005)
    np.testing.assert_allclose(part["contact_force"], part["virtual_force"], rtol=0.05)  # with gravity on the crown


@pytest.mark.slow
def test_reaction_of_the_brake_closes_a_loop_that_rings() -> None:
    """The cause: with the locked wheel's torque taken for one that turns the virtual wheel, the linear loop is unstable, and the
    run rings at its frequency."""
    case = unprotected("kalman", **{"rig_control.locked_speed": "1e-6 m/s", **AS_ESTIMATED})
    rate, frequency = held_growth(case)
    assert rate > 1.0
    loop = loop_of(case, creep_slope(case), sliding=True)
    assert loop is not None
    assert growth(loop, rolling_plant(loop))[0] < 0.0, "the turning wheel is stable"
    part = simulate(case).sel(time=LOCKED)
    ripple = torque_ripple(part["time"].to_numpy(), part["roller_torque"].to_numpy())
    assert ripple.rms > 5000.0
    # the limit cycle, with the torque at its limit and the brake beginning to slide, is slower than the small oscillation
    assert 0.75 * frequency < ripple.frequency < frequency
