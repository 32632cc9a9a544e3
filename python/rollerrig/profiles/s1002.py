"""Wheel profile S1002 from its published polynomials and arcs.

Source  ORE S1002, EN 13715. Numbers in millimetres, as published.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.polynomial import Polynomial

from .errors import ProfileError
from .table import DEFAULT_STEP, FloatArray, ProfileTable, tabulate

Segment = Callable[[FloatArray], FloatArray]

RUN_OUT = Polynomial([1.364323640, -0.066666667])
TREAD = Polynomial(
    [
        0.0,
        -3.358537058e-2,
        1.565681624e-3,
        -2.810427944e-5,
        5.844240864e-8,
        -1.562379023e-8,
        5.309217349e-15,
        -5.957839843e-12,
        2.646656573e-13,
    ]
)
FLANGE_ROOT_AS_PRINTED = Polynomial(
    [
        -4.320221063e3,
        -1.038384026e3,
        -1.065501873e2,
        -6.051367875,
        -2.054332446e-1,
        -4.169739389e-3,
        -4.687195829e-5,
        -2.252755540e-7,
    ]
)
FLANGE_FACE = Polynomial([-93.576667419, -2.747477419])


def _root_arc(s: FloatArray) -> FloatArray:
    return np.asarray(16.446 - np.sqrt(13.0**2 - (s + 26.210665) ** 2))


def _upper_face_arc(s: FloatArray) -> FloatArray:
    return np.asarray(8.834924130 + np.sqrt(20.0**2 - (s + 58.558326413) ** 2))


def _tip_arc(s: FloatArray) -> FloatArray:
    return np.asarray(16.0 + np.sqrt(12.0**2 - (s + 55.0) ** 2))


def _flange_root() -> Segment:
    """The polynomial between -35 and -26 mm, closed up with its neighbours.

    Its ten printed digits leave steps of 0.12 um at -35 and 0.04 um at -26 mm. Small, but a spline of 0.05 mm
    spacing would answer with curvature spikes of 50 1/m. A cubic through the four gaps (value and slope at both
    ends) closes them; it is nowhere larger than they are and changes the curvature by 0.03 1/m out of 190.
    """
    ends = np.array([-35.0, -26.0])
    arc_slope = (ends[0] + 26.210665) / np.sqrt(13.0**2 - (ends[0] + 26.210665) ** 2)
    value = np.array([_root_arc(ends)[0], TREAD(ends[1])])
    slope = np.array([arc_slope, TREAD.deriv()(ends[1])])
    gap, length = value - FLANGE_ROOT_AS_PRINTED(ends), ends[1] - ends[0]
    turn = length * (slope - FLANGE_ROOT_AS_PRINTED.deriv()(ends))

    def closing(s: FloatArray) -> FloatArray:
        u = (s - ends[0]) / length
        of_values = gap[0] * (1 + 2 * u) * (1 - u) ** 2 + gap[1] * (3 - 2 * u) * u**2
        return np.asarray(of_values + turn[0] * u * (1 - u) ** 2 - turn[1] * (1 - u) * u**2)

    return lambda s: np.asarray(FLANGE_ROOT_AS_PRINTED(s) + closing(s))


#: (from S [mm], radius increase [mm] over S [mm]); each segment ends where the one above it starts.
SEGMENTS: tuple[tuple[float, Segment], ...] = (
    (32.15796, RUN_OUT),
    (-26.0, TREAD),
    (-35.0, _flange_root()),
    (-38.426669071, _root_arc),
    (-39.764473993, FLANGE_FACE),
    (-49.662510381, _upper_face_arc),
    (-62.764705882, _tip_arc),
)


def s1002_height(s_mm: FloatArray) -> FloatArray:
    """Radius increase [mm] over the abscissa S [mm], -62.76 <= S <= 60."""
    s_mm = np.asarray(s_mm, dtype=np.float64)
    starts = [start for start, _ in SEGMENTS]
    which = [s_mm >= starts[0]] + [(s_mm >= a) & (s_mm < b) for a, b in zip(starts[1:], starts[:-1], strict=True)]
    height = np.full(s_mm.shape, np.nan)
    for inside, (_, segment) in zip(which, SEGMENTS, strict=True):
        height[inside] = segment(s_mm[inside])
    return height


def s1002(step: float = DEFAULT_STEP) -> ProfileTable:
    """Wheel profile S1002, flange tip to run-out: S from -60 to 60 mm.

    Args:
        step: knot spacing of the table [m].

    Returns:
        The table; 0 at the tape circle.
    """
    if not 0 < step <= 1e-3:
        raise ProfileError(f"s1002: step: {step} m; allowed above 0 and up to 0.001 m")
    return tabulate(
        lambda s: s1002_height(s * 1e3) * 1e-3,
        -60e-3,
        60e-3,
        name="s1002",
        kind="wheel",
        source="ORE S1002, EN 13715: published polynomials and arcs",
        step=step,
    )
