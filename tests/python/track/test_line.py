"""Curvature and cant of a line against the closed forms of clothoid and Bloss transition."""

from __future__ import annotations

import numpy as np
import pytest

from rollerrig.track import Line, Segment, build_line

K, CANT, RAMP, ARC = 1 / 300, 0.12, 80.0, 150.0


def line(shape: str, smoothing: float = 6.0) -> Line:
    """Straight, transition, curve, transition, straight."""
    return build_line(
        [
            Segment("straight", 0.0, 50.0, (0.0, 0.0), (0.0, 0.0)),
            Segment("transition", 50.0, RAMP, (0.0, K), (0.0, CANT), shape),
            Segment("curve", 130.0, ARC, (K, K), (CANT, CANT)),
            Segment("transition", 280.0, RAMP, (K, 0.0), (CANT, 0.0), shape),
            Segment("straight", 360.0, 50.0, (0.0, 0.0), (0.0, 0.0)),
        ],
        smoothing,
        1.5,
    )


@pytest.mark.parametrize("shape", ["clothoid", "bloss"])
def test_the_line_turns_by_the_curve_and_half_of_each_transition(shape: str) -> None:
    """Exact for both shapes, and not changed by the rounding; round-off only."""
    assert float(line(shape).heading(410.0)) == pytest.approx(K * (ARC + RAMP), rel=1e-14)


def test_a_clothoid_grows_in_proportion_away_from_its_corners() -> None:
    s = np.linspace(53.0, 127.0, 20)
    found = line("clothoid")
    np.testing.assert_allclose(found.curvature.evaluate(s), K * (s - 50) / RAMP, rtol=1e-13)
    np.testing.assert_allclose(found.cant.evaluate(s), CANT * (s - 50) / RAMP, rtol=1e-13)


def test_a_clothoid_s_heading_is_s_squared_over_two_a_squared() -> None:
    """Half-way, the first corner's rounding has added K smoothing^2 / (24 RAMP) of heading."""
    exact = K * 40.0**2 / (2 * RAMP) + K * 6.0**2 / (24 * RAMP)
    assert float(line("clothoid").heading(90.0)) == pytest.approx(exact, rel=1e-13)


def test_a_corner_is_a_parabola() -> None:
    """At the corner itself the rounded ramp is slope times smoothing / 8; it leaves the sharp one at half the smoothing."""
    curvature = line("clothoid").curvature
    slope = K / RAMP
    np.testing.assert_allclose(
        curvature.evaluate([47.0, 50.0, 53.0]), [0.0, slope * 6 / 8, slope * 3], atol=1e-16, rtol=1e-12
    )
    np.testing.assert_allclose(curvature.evaluate([48.0, 51.0, 52.9], 2), slope / 6.0, rtol=1e-12)


def test_a_bloss_transition_is_the_cubic() -> None:
    s = np.linspace(50.0, 130.0, 17)
    t = (s - 50) / RAMP
    np.testing.assert_allclose(line("bloss").curvature.evaluate(s), K * (3 * t**2 - 2 * t**3), atol=1e-17)


@pytest.mark.parametrize("shape", ["clothoid", "bloss"])
def test_value_and_slope_are_continuous(shape: str) -> None:
    for function, size in ((line(shape).curvature, K), (line(shape).cant, CANT)):
        knots = function.rows[:, 0]
        for derivative, scale in ((0, size), (1, size / RAMP)):
            before, after = (function.evaluate(knots + side, derivative) for side in (-1e-9, 1e-9))
            np.testing.assert_allclose(before, after, atol=1e-8 * scale)  # a slope's change over 2 nm


def test_corners_closer_than_the_smoothing_still_join_smoothly() -> None:
    """Roundings that overlap add up: the slope has no jump left anywhere."""
    short = build_line(
        [
            Segment("straight", 0.0, 5.0, (0.0, 0.0), (0.0, 0.0)),
            Segment("transition", 5.0, 3.0, (0.0, K), (0.0, 0.0)),
            Segment("curve", 8.0, 5.0, (K, K), (0.0, 0.0)),
        ],
        6.0,
        1.5,
    )
    s = np.linspace(-1, 14, 15001)
    slope = short.curvature.evaluate(s, 1)
    assert np.abs(np.diff(slope)).max() < 2 * K / 3.0 * 1e-3 / 6.0  # at most both roundings' second derivative, 1 mm
    assert float(short.heading(13.0)) == pytest.approx(K * 6.5, rel=1e-13)


def test_a_line_is_constant_beyond_its_ends() -> None:
    arc = build_line([Segment("curve", 0.0, 10.0, (K, K), (CANT, CANT))], 6.0, 1.5)
    np.testing.assert_array_equal(arc.curvature.evaluate([-100.0, 0.0, 5.0, 10.0, 1e6]), K)
    assert float(arc.heading(-30.0)) == pytest.approx(-30 * K, rel=1e-14)
    assert float(arc.heading(1000.0)) == pytest.approx(1000 * K, rel=1e-14)


def test_a_distance_knows_its_segment() -> None:
    assert [line("bloss").segment_at(s) for s in (-5.0, 0.0, 49.9, 50.0, 200.0, 1e4)] == [0, 0, 0, 1, 2, 4]
