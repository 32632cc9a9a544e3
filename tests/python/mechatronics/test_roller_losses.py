"""Losses of the rollers: a coast-down slows as its torques over the inertia say, and what they take is accounted for."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

import rollerrig as rr

COAST = {"vehicle.cut": "leading_wheelset", "axle_torque": [], "time.duration": "20 s", "time.output_step": "20 ms"}
LOSSES = {"constant": 30.0, "linear": 2.0, "quadratic": 0.05}  # [N m], [N m s/rad], [N m s^2/rad^2]


def coasting(**changes: object) -> xr.Dataset:
    return rr.simulate(rr.load_case("bogie_rollers_traction").with_changes({**COAST, **changes}))


def torque(rate: np.ndarray) -> np.ndarray:
    return LOSSES["constant"] + LOSSES["linear"] * rate + LOSSES["quadratic"] * rate**2


@pytest.mark.parametrize("coupling", ["axle", "independent"])
def test_a_coast_down_slows_by_the_losses_over_the_inertia(coupling: str) -> None:
    """Against the same rollers without losses, which only the contact brakes; the wheelset turns with them."""
    own = {f"support.losses.{key}": value for key, value in LOSSES.items()}
    with_losses, without = (coasting(**extra, **{"support.coupling": coupling}) for extra in (own, {}))
    case = rr.load_case("bogie_rollers_traction")
    radius = float(with_losses["rolling_radius"].isel(time=0).mean())
    wheelset = next(body for body in case.vehicle.data.body if body.name == "wheelset_1")
    ratio = case.support.data.roller_radius / radius
    inertia = case.support.data.roller_inertia[1] + wheelset.inertia[1] * ratio**2
    late = slice(2.0, 3.0)  # the primary suspension has come to rest
    speeds = [one["speed"].sel(time=late) / case.support.data.roller_radius for one in (with_losses, without)]
    slower = np.diff([float((one[-1] - one[0]) / (one["time"][-1] - one["time"][0])) for one in speeds])[0]
    assert slower == pytest.approx(float(torque(speeds[0].mean().to_numpy())) / inertia, rel=2e-3)


def test_what_the_losses_take_is_in_the_energy_audit() -> None:
    run = coasting(**{f"support.losses.{key}": value for key, value in LOSSES.items()})
    rate = np.abs(run["pitch_rate"].sel(body="roller_1").to_numpy())
    taken = np.trapezoid(torque(rate) * rate, run["time"])
    assert float(run["energy_dissipated_elements"][-1]) == pytest.approx(taken, rel=2e-4)
    assert run.attrs["energy_relative_residual"] < 1e-4


def test_rollers_come_to_rest_and_stay_there() -> None:
    run = coasting(**{"motion.speed": "5 km/h", "support.losses.constant": 200.0, "time.duration": "20 s"})
    rate = run["pitch_rate"].sel(body="roller_1")
    assert run.attrs["status"] in ("ok", "stopped")
    assert abs(float(rate[-1])) < 1e-2
