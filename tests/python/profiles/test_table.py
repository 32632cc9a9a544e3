"""The spline table: what it reproduces, how fast it converges, what it refuses."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rollerrig.profiles import ProfileError, ProfileTable, gauge_point, tabulate

coefficient = st.floats(-1.0, 1.0)


def table_of(height, low=-0.03, high=0.03, **arguments):
    return tabulate(height, low, high, name="test", kind="rail", source="test", **arguments)


@settings(max_examples=30, deadline=None)
@given(a=coefficient, b=coefficient, c=coefficient, d=coefficient, low=st.floats(-0.1, 0.0), width=st.floats(0.01, 0.1))
def test_a_cubic_is_reproduced_everywhere_with_all_its_derivatives(a, b, c, d, low, width):
    cubic = np.polynomial.Polynomial([a, b, 10 * c, 100 * d])  # values of at most a metre, as anything here
    table = table_of(cubic, low, low + width)
    y = np.linspace(low, low + width, 333)
    # Round-off: differences of values of order 1 over steps of 5e-5 m lose a factor step^-k in derivative k.
    for derivative, tolerance in enumerate((1e-14, 1e-10, 1e-5)):
        exact = cubic.deriv(derivative)(y) if derivative else cubic(y)
        assert np.max(np.abs(table.evaluate(y, derivative) - exact)) < 10 * tolerance


def test_value_slope_and_curvature_are_continuous_across_every_knot():
    table = table_of(lambda y: 1e-3 * np.sin(y / 2e-3))
    h, (c0, c1, c2, c3) = table.step, table.coefficients.T
    # Jumps relative to the largest value of each derivative: round-off of the differences that form them.
    for end, start, scale in (
        (c0 + h * (c1 + h * (c2 + h * c3)), c0, 1e-3),
        (c1 + h * (2 * c2 + h * 3 * c3), c1, 0.5),
        (2 * c2 + 6 * h * c3, 2 * c2, 250.0),
    ):
        assert np.max(np.abs(end[:-1] - start[1:])) < 1e-9 * scale


@pytest.mark.parametrize(("derivative", "order"), [(0, 4), (1, 3), (2, 2)])
def test_the_error_falls_with_the_order_of_a_cubic_spline(derivative, order):
    wave = 2e-3
    y = np.linspace(-0.025, 0.025, 20011)
    exact = (np.sin, np.cos, lambda x: -np.sin(x))[derivative](y / wave) / wave**derivative

    def error(step):
        return np.max(np.abs(table_of(lambda y: np.sin(y / wave), step=step).evaluate(y, derivative) - exact))

    # At a tenth and a twentieth of the wave's radian length the next order still counts by some percent.
    assert np.log2(error(2e-4) / error(1e-4)) == pytest.approx(order, abs=0.15)


def test_a_jump_of_curvature_overshoots_by_a_twelfth_at_one_knot_and_not_beyond():
    table = table_of(lambda y: np.where(y > 0, 0.5 * y**2, 0.0) * 10.0, -0.02, 0.02, step=1e-4)
    knots = table.start + table.step * np.arange(len(table.coefficients))
    curvature = table.evaluate(knots, 2)
    assert curvature.max() - 10.0 == pytest.approx(10 / 12, rel=1e-6)
    assert -curvature.min() == pytest.approx(10 / 12, rel=1e-6)
    away = np.abs(knots) > 1.5 * table.step
    assert np.max(np.abs(curvature - 10.0 * (knots > 0))[away]) < 1e-6


def test_the_table_is_frozen_and_laid_out_for_the_core():
    table = table_of(np.zeros_like)
    assert table.coefficients.dtype == np.float64
    assert table.coefficients.flags.c_contiguous
    with pytest.raises(ValueError, match="read-only"):
        table.coefficients[0, 0] = 1.0
    with pytest.raises(AttributeError):
        table.start = 0.0  # type: ignore[misc]


def test_evaluation_keeps_the_shape_and_reaches_both_ends():
    table = table_of(lambda y: y)
    assert table.evaluate(0.01).shape == ()
    assert table.evaluate(np.zeros((2, 3))).shape == (2, 3)
    assert table.evaluate(table.domain) == pytest.approx(table.domain, abs=1e-15)


def test_an_abscissa_outside_is_refused_with_the_domain():
    with pytest.raises(ProfileError, match=r"asked for 40 to 40 mm; allowed -30 to 30 mm"):
        table_of(np.zeros_like).evaluate(0.04)
    with pytest.raises(ProfileError, match="outside"):
        table_of(np.zeros_like).evaluate(np.nan)


def test_what_is_no_profile_is_refused():
    with pytest.raises(ProfileError, match="empty profile"):
        table_of(np.zeros_like, 0.01, 0.01)
    with pytest.raises(ProfileError, match="not a finite height at abscissa 0"):
        table_of(lambda y: np.where(np.abs(y) < 1e-9, np.nan, y))
    with pytest.raises(ProfileError, match="shape"):
        ProfileTable("x", "rail", 0.0, 1e-4, np.zeros((0, 4)), "", np.zeros((1, 2)))
    with pytest.raises(ProfileError, match="step"):
        ProfileTable("x", "rail", 0.0, 0.0, np.zeros((1, 4)), "", np.zeros((1, 2)))
    with pytest.raises(ProfileError, match="finite number in row 1"):
        ProfileTable("x", "rail", 0.0, 1e-4, np.array([[0.0] * 4, [0, 0, np.inf, 0]]), "", np.zeros((1, 2)))


def test_the_gauge_point_is_the_first_one_at_its_depth_on_the_inner_side():
    outline = np.array([[-0.03, -0.04], [-0.04, -0.014], [-0.036, -0.010], [0.0, 0.0], [0.036, -0.04]])
    table = ProfileTable("x", "rail", 0.0, 1e-4, np.zeros((1, 4)), "", outline)
    assert gauge_point(table, 0.014) == pytest.approx(-0.04)
    assert gauge_point(table, 0.012) == pytest.approx(-0.038)
    with pytest.raises(ProfileError, match=r"reaches 40 mm below.*needed 50 mm"):
        gauge_point(table, 0.05)
    with pytest.raises(ProfileError, match="positive"):
        gauge_point(table, -0.01)
