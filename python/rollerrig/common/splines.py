"""Uniform cubic B-splines: weights of a local quasi-interpolant, and the pieces of a spline.

    samples -> [quasi_interpolant] -> weights -> [pieces] -> coefficients per interval -> profiles, irregularities

Source: C. de Boor, G. Fix, Spline approximation by quasi-interpolants, J. Approximation Theory 8 (1973).
"""

import numpy as np

from rollerrig.common.arrays import Array


def quasi_interpolant(before: Array, here: Array, after: Array) -> Array:
    """Weights f - h^2 f''/6 at the knots, with a difference for f''; exact for cubics, of fourth order.

    Args:
        before: samples at the previous knots, any shape.
        here: at the knots, same shape.
        after: at the next knots, same shape.
    """
    return np.asarray((-before + 8 * here - after) / 6)


def cubic(coefficients: Array, t: Array, derivative: int = 0) -> Array:
    """c_0 + c_1 t + c_2 t^2 + c_3 t^3, or its derivative 1, 2 or 3, of coefficients of shape (..., 4), t of shape (...)."""
    c0, c1, c2, c3 = np.moveaxis(coefficients, -1, 0)
    match derivative:
        case 0:
            return np.asarray(c0 + t * (c1 + t * (c2 + t * c3)))
        case 1:
            return np.asarray(c1 + t * (2 * c2 + t * 3 * c3))
        case 2:
            return np.asarray(2 * c2 + t * 6 * c3)
        case 3:
            return np.asarray(6 * c3)
    raise ValueError(f"derivative: {derivative} is not one of 0, 1, 2, 3")


def pieces(before: Array, here: Array, after: Array, next_after: Array, step: float) -> Array:
    """Coefficients c of value = c_0 + c_1 t + c_2 t^2 + c_3 t^3 on each interval, t from its first knot.

    Args:
        before: weight of the B-spline centred at the knot before each interval, shape (n,).
        here: at its first knot.
        after: at its last knot.
        next_after: at the knot after that.
        step: distance between knots.

    Returns:
        Shape (n, 4), contiguous.
    """
    rows = (
        (before + 4 * here + after) / 6,
        (after - before) / (2 * step),
        (before - 2 * here + after) / (2 * step**2),
        (next_after - 3 * after + 3 * here - before) / (6 * step**3),
    )
    return np.ascontiguousarray(np.column_stack(rows))
