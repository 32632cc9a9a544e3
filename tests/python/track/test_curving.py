"""Quasi-static curving against textbook numbers."""

from __future__ import annotations

import math

import pytest

from rollerrig.track import equilibrium_speed, highest_speed, limit_of_lateral_force, plane_acceleration


def test_no_acceleration_is_left_at_the_equilibrium_speed() -> None:
    speed = equilibrium_speed(1 / 600, 0.12, 1.5, 9.81)
    assert plane_acceleration(speed, 1 / 600, 0.12, 1.5, 9.81) == pytest.approx(0.0, abs=1e-15)
    assert 3.6 * speed == pytest.approx(
        math.sqrt(600 * 0.12 * 9.81 * 3.6**2 / 1.5), rel=2e-3
    )  # 11.8 V^2 / R; sin for tan
    assert equilibrium_speed(-1 / 600, -0.12, 1.5, 9.81) == speed
    assert math.isnan(equilibrium_speed(1 / 600, -0.12, 1.5, 9.81))
    assert math.isnan(equilibrium_speed(0.0, 0.12, 1.5, 9.81))


def test_150_mm_of_cant_deficiency_leave_a_tenth_of_g() -> None:
    speed = equilibrium_speed(1 / 600, 0.27, 1.5, 9.81)
    assert plane_acceleration(speed, 1 / 600, 0.12, 1.5, 9.81) == pytest.approx(
        9.81 * 0.15 / 1.5, rel=0.03
    )  # the rule is for small angles


def test_the_highest_speed_reaches_the_limit() -> None:
    for curvature, cant in ((1 / 300, 0.15), (-1 / 300, -0.15), (1 / 300, -0.05)):
        speed = highest_speed(curvature, cant, 1.5, 0.4, 9.81)
        angle = math.atan(speed**2 * abs(curvature) / 9.81) - math.copysign(1, curvature) * math.asin(cant / 1.5)
        assert math.tan(angle) == pytest.approx(0.4, rel=1e-12)


def test_a_high_vehicle_overturns_and_a_low_one_climbs() -> None:
    flange = math.radians(70)
    limit, what = limit_of_lateral_force(1.6, 1.5, flange, 0.3)
    assert (limit, what) == (pytest.approx(1.5 / 3.2), "overturning")
    limit, what = limit_of_lateral_force(0.46, 1.5, flange, 0.3)
    assert what == "flange climb"
    nadal = (math.tan(flange) - 0.3) / (1 + 0.3 * math.tan(flange))
    assert 2 * limit / (1 + 2 * 0.46 * limit / 1.5) == pytest.approx(nadal, rel=1e-12)
