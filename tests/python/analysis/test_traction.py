"""Closed forms of the traction study against themselves and against a run."""

from __future__ import annotations

import numpy as np
import pytest

from rollerrig.analysis.signals import fit
from rollerrig.analysis.traction import balance, bogie_of, torque_over_time, with_theory
from rollerrig.config import load_case
from rollerrig.simulation.run import simulate

AXLE_LOAD = 109_000.0


@pytest.fixture(scope="module")
def case():
    return load_case("bogie_rollers_traction")


def test_without_torque_nothing_happens(case) -> None:
    forces = balance(case, np.zeros(3), AXLE_LOAD)
    assert np.all(forces.creep_force == 0.0)
    for front, rear in (forces.longitudinal, forces.shift):
        assert np.all(front == 0.0)
        assert np.all(rear == 0.0)
    assert np.all(forces.vertical[0] == AXLE_LOAD)


def test_the_torque_is_shared_between_wheelset_and_roller_by_inertia(case) -> None:
    _, (wheelset, _), rig = bogie_of(case)
    radius = case.vehicle.data.wheel.radius
    force = balance(case, np.array([4000.0]), AXLE_LOAD).creep_force[0]
    acceleration = force * rig.roller_radius**2 / rig.roller_inertia[1]  # of the rolling surface
    assert 4000.0 - force * radius == pytest.approx(wheelset.inertia[1] * acceleration / radius, rel=1e-12)


def test_the_load_moves_from_the_front_to_the_rear(case) -> None:
    forces = balance(case, np.array([4000.0]), AXLE_LOAD)
    front, rear = forces.vertical
    assert front[0] + rear[0] == pytest.approx(2 * AXLE_LOAD)
    # first estimate: traction at the height of the rod over the wheelbase
    assert rear[0] - AXLE_LOAD == pytest.approx(2 * 6400 * 0.6 / 2.56, rel=0.35)


def test_a_short_run_agrees_with_the_closed_forms(case) -> None:
    short = case.with_changes(
        {
            "axle_torque": [
                {"wheelset": w, "reacts_on": "front_frame", "table": [[0.0, 0.0], [0.5, 1000.0], [1.5, 1000.0]]}
                for w in ("wheelset_1", "wheelset_2")
            ],
            "time.duration": 1.5,
        }
    )
    study = with_theory(simulate(short), short).isel(time=-1)
    tolerances = {
        "longitudinal_creep_force": 0.005,
        "longitudinal_force": 0.005,
        "vertical_force": 1e-4,
        "sliding": 0.05,
    }
    for quantity, tolerance in tolerances.items():
        expected = study[f"{quantity}_theory"].to_numpy()
        assert study[quantity].to_numpy() == pytest.approx(expected, rel=tolerance), quantity


def test_torques_that_differ_are_refused(case) -> None:
    with pytest.raises(ValueError, match="same torque"):
        torque_over_time(case.with_changes({"axle_torque.0.table": [[0.0, 1.0], [1.0, 2.0]]}), np.zeros(2))


def test_a_fit_finds_its_coefficients() -> None:
    x = np.linspace(0, 1, 50)
    found = fit(2 * x + 3 * x**2, x, x**2)
    assert found.coefficients == pytest.approx((2.0, 3.0))
    assert found.largest < 1e-12
