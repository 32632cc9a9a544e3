"""A wheel on flexible track against closed forms: receptance over the frequency, and the rail that rolls about its foot."""

from __future__ import annotations

import numpy as np
import pytest

import rollerrig as rr
from rollerrig.analysis.modes import Lineariser
from rollerrig.assembly.model import assemble
from rollerrig.config import Case
from rollerrig.simulation.starting_state import equilibrium_dataset

PAD = {"stiffness": 1.2e8, "damping": 6e4}
BALLAST = {"stiffness": 7e7, "damping": 8e4}
RAIL_MASS, SLEEPER_MASS = 60.0, 150.0


def wheelset_on(foundation: dict[str, object]) -> Case:
    """A lone wheelset with cylindrical wheels: it touches the rails on their tops, and the normals are vertical."""
    return rr.load_case("contact_benchmark_track").with_changes(
        {
            "vehicle.wheel.profile": {"kind": "cylinder"},
            "contact.normal": "hertz",
            "contact.normal_damping": 0.0,  # it acts on approach only, which no linear model knows
            "support.foundation": foundation,
        }
    )


@pytest.mark.parametrize("layers", [1, 2])
def test_receptance_of_a_wheel_on_its_track(layers: int) -> None:
    """x/F = 1 / (-m w^2 + k_H K / (k_H + K)), K the dynamic stiffness of rail, pad, sleeper and ballast, k_H = 3 N / (2 p)."""
    foundation: dict[str, object] = {"rail_mass": RAIL_MASS, "vertical": PAD}
    if layers == 2:
        foundation["sleeper"] = {"mass": SLEEPER_MASS, "vertical": BALLAST}
    case = wheelset_on(foundation)
    rest = equilibrium_dataset(assemble(case)).isel(time=0, wheel=0)
    hertz = 1.5 * float(rest["patch_normal"].max()) / float(rest["patch_approach"].max())
    linear = Lineariser(case).at(case.motion.speed)
    row = linear.rate_rows["wheelset_1", "vertical"]
    mass = linear.inertia["wheelset_1", "vertical"]

    omega = 2 * np.pi * np.geomspace(2.0, 1000.0, 60)
    force = np.zeros(len(linear.matrix))
    force[row] = 2.0 / mass  # one unit on each wheel
    found = [np.linalg.solve(1j * w * np.eye(len(force)) - linear.matrix, force)[row] / (1j * w) for w in omega]
    pad = PAD["stiffness"] + 1j * omega * PAD["damping"]
    if layers == 2:
        below = BALLAST["stiffness"] + 1j * omega * BALLAST["damping"] - SLEEPER_MASS * omega**2
        pad = pad * below / (pad + below)
    track = pad - RAIL_MASS * omega**2
    exact = 1.0 / (-0.5 * mass * omega**2 + hertz * track / (hertz + track))
    np.testing.assert_allclose(found, exact, rtol=1e-6)


CURVE = {
    "support.segment": [{"kind": "curve", "length": 400.0, "radius": 600.0, "cant": 0.1}],
    "motion.speed_mps": 22.0,
    "contact.normal": "hertz",
}


def test_a_rail_rolls_about_its_foot_under_the_forces_at_its_head() -> None:
    """(k_phi - h Q) phi = h Y - y Q and k_y y_foot = -Y on the outer and inner rail, contact at y on the head.

    To first order in the roll angle, 5 mrad, and of contacts near the top of the rail: a gauge corner lies lower than h.
    """
    case = rr.load_case("vehicle_curve").with_changes(CURVE)
    foundation = case.support.data.foundation
    rest = equilibrium_dataset(assemble(case)).isel(time=0)
    for axle, side, outward in (("1", "left", 1.0), ("2", "left", 1.0), ("2", "right", -1.0)):
        wheel, rail = rest.sel(wheel=f"wheelset_{axle}_{side}"), rest.sel(body=f"rail_{axle}_{side}")
        y, q = float(wheel["lateral_force"]), float(wheel["vertical_force"])
        place = outward * float(wheel["patch_rail_abscissa"][0])
        roll = float(rail["roll"])
        foot = float(rail["lateral"]) + foundation.centre_height * roll
        stiffness = foundation.roll.stiffness - foundation.rail_height * q  # the head is h roll beside the foot
        assert stiffness * roll == pytest.approx(foundation.rail_height * y - place * q, rel=5e-3)
        assert foundation.lateral.stiffness * foot == pytest.approx(-y, rel=0.06)  # the normal is tilted by the roll


@pytest.mark.parametrize("sleeper", [None, {"lateral": BALLAST, "vertical": BALLAST}])
def test_energy_balance_through_a_transition_on_flexible_track(sleeper: object) -> None:
    case = rr.load_case("vehicle_curve").with_changes(
        {"support.foundation.sleeper": sleeper, "contact.normal": "hertz", "time.duration": "5 s"}
    )
    run = rr.simulate(case)
    assert run.attrs["status"] == "ok"
    assert abs(run["roll"].sel(body="rail_1_right")).max() > 1e-4
    assert run.attrs["energy_relative_residual"] < 1e-6


def test_a_rail_that_cannot_roll_nor_shift_is_the_rigid_one() -> None:
    """Ten times stiffer in all three directions, what remains of the difference to rigid rails is a tenth."""
    angles = []
    for factor in (None, 1.0, 10.0):
        stiff = {"stiffness": 1e9 * (factor or 1.0)}
        foundation = {"lateral": stiff, "vertical": stiff, "roll": {"stiffness": 1e7 * (factor or 1.0)}}
        case = rr.load_case("vehicle_curve").with_changes({**CURVE, "support.foundation": factor and foundation})
        angles.append(float(equilibrium_dataset(assemble(case))["yaw"].sel(body="wheelset_1")[0]))
    rigid, soft, hard = angles
    assert abs(hard - rigid) < 0.15 * abs(soft - rigid)
    assert abs(soft - rigid) > 1e-9
