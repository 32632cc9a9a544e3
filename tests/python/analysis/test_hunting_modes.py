"""Which modes are hunting: those in which wheelsets roll where they point, speed by speed."""

from __future__ import annotations

import math

import numpy as np
import pytest

from rollerrig.analysis.mode_table import stability
from rollerrig.analysis.modes import frequency_of_hunting, hunts
from rollerrig.config import load_case
from rollerrig.study.runs.paper import MATERIALS, VEHICLE, case_of

KEYS = [("body", "lateral"), ("wheelset_1", "lateral"), ("wheelset_1", "yaw")]
SPEED, OMEGA = 20.0, 2 * math.pi


def one(body: complex, yaw: complex, value: complex = 1j * OMEGA) -> bool:
    """Whether a wheelset that sways by 1 m hunts, with this displacement of the body [m] and this yaw [rad]."""
    parts = np.array([body, 1.0, yaw])[None, :, None]
    return bool(hunts(KEYS, np.array([SPEED]), np.array([[value]]), parts, ["wheelset_1"])[0, 0])


def test_a_wheelset_hunts_where_it_rolls_as_it_points() -> None:
    rolling = 1j * OMEGA / SPEED  # V psi = dy/dt
    assert one(0.5, rolling)
    assert not one(0.5, -rolling)  # against it
    assert not one(0.5, 0.0)  # sideways
    assert not one(2.0, rolling)  # the body sways, and drags it along
    assert not one(0.5, 0.5 / SPEED, -0.5 + 0j)  # no oscillation


def test_what_cannot_yaw_does_not_hunt() -> None:
    values, parts = np.array([[1j]]), np.ones((1, 1, 1), dtype=complex)
    assert not hunts(KEYS[:1], np.array([SPEED]), values, parts, ["wheelset_1"]).any()


def test_the_least_damped_one_is_taken_at_each_speed() -> None:
    values = np.array([[-1 + 6j, -2 + 7j, -0.1 + 1j], [-2.1 + 8j, -2.2 + 9j, -0.1 + 1j], [-3 + 8j, -2 + 9j, -0.1 + 1j]])
    where = np.array([[True, True, True], [True, True, True], [False, False, True]])
    frequency, damping = frequency_of_hunting(["hunting", "hunting 2", "car body yaw"], values, where)
    assert 2 * math.pi * frequency[:2] == pytest.approx([6.0, 9.0])
    assert damping[:2] == pytest.approx([1 / abs(-1 + 6j), 2.2 / abs(-2.2 + 9j)])
    assert math.isnan(frequency[2])
    assert math.isnan(damping[2])


@pytest.mark.parametrize("material", MATERIALS)
def test_below_60_kmh_the_vehicle_hunts_in_waves_of_one_length(material: str) -> None:
    """Slow hunting is kinematic: its frequency rises with speed from nothing. A car-body mode at 1.15 Hz does not."""
    modes = stability(case_of(VEHICLE, material), [20.0, 30.0, 40.0, 50.0, 60.0, 80.0])
    wavelength = (modes["speed"] / 3.6 / modes["hunting_frequency"]).to_numpy()
    # within 5 %: where it meets the sways of the car body, they pull a little
    assert wavelength == pytest.approx(np.full(6, wavelength[-1]), rel=0.05)


def test_a_lone_wheelset_on_springs_does_not_hunt() -> None:
    """Its suspension is stiff: it slides sideways, overdamped or nearly so, and follows no wave."""
    modes = stability(load_case("wheelset_rollers"), [60.0, 180.0, 300.0])
    assert modes.attrs["hunting_mode"] == ""
    assert np.isnan(modes["hunting_frequency"]).all()
    names = [str(name) for name in modes["mode"].to_numpy()]
    assert "wheelset lateral" in names
    assert not [name for name in names if name.startswith(("wheelsets", "hunting"))]


def test_a_free_conical_wheelset_hunts() -> None:
    modes = stability(load_case("contact_benchmark_rollers"), [10.0, 60.0])
    assert modes.attrs["hunting_mode"] == "hunting"
    assert not np.isnan(modes["hunting_frequency"]).any()
