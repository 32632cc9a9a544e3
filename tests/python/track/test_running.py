"""A whole vehicle in a curve, from a case to its results."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

from rollerrig import load_case, simulate
from rollerrig.assembly.model import assemble
from rollerrig.config import Case
from rollerrig.simulation.starting_state import equilibrium_dataset

RADIUS, CANT, SPEED = 1200.0, 0.06, 30.0


def curving(direction: str, segments: list[dict[str, object]] | None = None, duration: float = 4.0) -> Case:
    curve = {"kind": "curve", "length": 200.0, "radius": RADIUS, "cant": CANT, "direction": direction}
    return load_case("bogie_track").with_changes(
        {
            "vehicle.cut": "vehicle",
            "motion.speed_mps": SPEED,
            "disturbance": [],
            "support.segment": segments or [curve],
            "time.method": "rodas4",
            "time.step": None,
            "time.relative_tolerance": 1e-6,
            "time.absolute_tolerance": 1e-9,
            "time.duration": duration,
            "time.output_step": 0.02,
        }
    )


def through_a_transition(direction: str) -> xr.Dataset:
    curve = {"kind": "curve", "length": 100.0, "radius": RADIUS, "cant": CANT, "direction": direction}
    straight = {"kind": "straight", "length": 30.0}
    return simulate(curving(direction, [straight, {"kind": "transition", "length": 60.0}, curve]))


def test_in_a_steady_curve_the_wheels_carry_the_uncompensated_force() -> None:
    case = curving("left")
    model = assemble(case)
    run = equilibrium_dataset(model).isel(time=0)
    mass = sum(model.masses.values())
    angle = np.arcsin(CANT / 1.5)
    uncompensated = SPEED**2 / RADIUS * np.cos(angle) - 9.81 * np.sin(angle)
    # Bodies stand up the canted plane and off the middle: 2 m of 1200 m.
    assert float(run["lateral_force"].sum()) == pytest.approx(mass * uncompensated, rel=5e-3)
    assert float(run["lateral_specific_force"].sel(body="wheelset_1")) == pytest.approx(uncompensated, abs=0.02)
    assert float(run["curvature"]) == pytest.approx(1 / RADIUS)
    assert float(run["longitudinal"].sel(body="car_body")) == 0.0  # hauled along
    leading = float(run["lateral"].sel(body="wheelset_1"))
    assert -8e-3 < leading < -1e-3  # to the outside


@pytest.mark.slow
def test_a_right_curve_is_the_mirror_of_a_left_one_and_the_energy_audit_closes() -> None:
    left, right = through_a_transition("left"), through_a_transition("right")
    for run in (left, right):
        assert run.attrs["status"] == "ok"
        assert run.attrs["energy_relative_residual"] < 1e-6
    assert float(left["distance"][-1]) == pytest.approx(4.0 * SPEED)
    # Rounding grows where patches come and go and a step is halved or not, by the error of a step (1e-5: 7e-4).
    for name in ("lateral", "roll", "yaw"):
        size = float(np.abs(left[name]).max())
        assert float(np.abs(left[name] + right[name]).max()) < 1e-4 * size
