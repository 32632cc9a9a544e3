"""What drives the rollers, against closed forms."""

from __future__ import annotations

import pytest

import rollerrig as rr

TORQUE = 500.0  # per roller axle [N m]


@pytest.mark.parametrize("coupling", ["axle", "independent"])
def test_a_torque_per_axle_spins_up_rollers_and_wheels_together(coupling: str) -> None:
    """Almost no sliding: (J_roller + J_wheelset (R/r)^2) dW/dt = torque, whether one roller takes it or two halves."""
    case = rr.load_case("bogie_rollers_constant").with_changes(
        {
            "motion.speed": "60 km/h",
            "motion.drive": "torque",
            "motion.torque_table": [[0.0, TORQUE], [1.0, TORQUE]],
            "support.coupling": coupling,
            "disturbance": [],
            "time.duration": "1 s",
            "time.method": "rodas4",
            "time.step": None,
            "time.output_step": "0.1 s",
        }
    )
    run = rr.simulate(case)
    wheel_radius, roller_radius = float(run["rolling_radius"].mean()), 0.725
    inertia = 705.0 + 112.0 * (roller_radius / wheel_radius) ** 2
    expected = TORQUE / inertia * roller_radius
    gained = float(run["speed"][-1] - run["speed"][0])
    # the two patches of each wheel brake: their rolling resistance takes 0.012 rad/s^2 of 0.506
    assert gained == pytest.approx(expected, rel=0.04)
    assert gained < expected
