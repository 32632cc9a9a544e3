"""Straights, transitions and circular curves become curvature and cant over the distance.

    segments in their order, smoothing length -> [build_line] -> Line

A clothoid's curvature and cant grow in proportion to the distance; on a Bloss transition they follow 3 t^2 - 2 t^3,
t from 0 to 1. A clothoid meets its neighbours in corners, where the roll acceleration of the track would be
infinite: each corner is rounded by a parabola over the smoothing length, half of it on either side. The corners of
a transition are rounded by opposite amounts, so that the change of heading is that of the sharp clothoid.
Equations: docs/theory/layout.md.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from rollerrig.common.arrays import Array
from rollerrig.common.splines import cubic


@dataclass(frozen=True, eq=False)
class PiecewiseCubic:
    """A piecewise cubic over the distance.

    On the piece `k`, from s_k to s_(k+1), and with t = s - s_k,

        value(s) = c_k0 + c_k1 t + c_k2 t^2 + c_k3 t^3 ;

    the last row is a constant: it holds from there on, as the value at s_0 holds before.
    """

    rows: Array  # (n, 5), one row [s_k, c_k0, c_k1, c_k2, c_k3] per piece, s_k [m] ascending, read-only

    def __post_init__(self) -> None:
        """Freeze the rows in the layout that the compiled core reads."""
        rows = np.array(self.rows, dtype=np.float64, order="C").reshape(-1, 5)
        rows.flags.writeable = False
        object.__setattr__(self, "rows", rows)

    def evaluate(self, s: ArrayLike, derivative: int = 0) -> Array:
        """Value (0), slope (1) or a further derivative (2, 3) at distances s [m], any shape."""
        s = np.asarray(s, dtype=np.float64)
        first = self.rows[0, 0]
        k = np.clip(np.searchsorted(self.rows[:, 0], s, side="right") - 1, 0, None)
        value = cubic(self.rows[k, 1:], np.maximum(s, first) - self.rows[k, 0], derivative)
        return np.where(s < first, 0.0, value) if derivative else value

    def integral(self, s: ArrayLike) -> Array:
        """Integral from 0 to s [m], exact for the cubics; any shape."""
        s = np.asarray(s, dtype=np.float64)
        return self._primitive(s) - self._primitive(np.zeros(()))

    def _primitive(self, s: Array) -> Array:
        start, means = self.rows[:, 0], self.rows[:, 1:] / [1, 2, 3, 4]  # the integral of a piece is t times a cubic
        width = np.diff(start)
        before = np.concatenate(([0.0], np.cumsum(width * cubic(means[:-1], width))))
        k = np.clip(np.searchsorted(start, s, side="right") - 1, 0, None)
        t = s - start[k]
        inside = np.maximum(t, 0.0)
        return np.asarray(before[k] + inside * cubic(means[k], inside) + np.minimum(t, 0.0) * means[0, 0])


Shape = Literal["clothoid", "bloss"]


@dataclass(frozen=True)
class Segment:
    """A piece of the line."""

    kind: Literal["straight", "transition", "curve"]  # "straight", "transition" or "curve"
    start: float  # distance at which it begins [m]
    length: float  # its length [m]
    curvature: tuple[float, float]  # at its start and at its end, positive in a curve to the left [1/m]
    cant: tuple[float, float]  # at its start and at its end, positive where the right rail is the higher one [m]
    shape: Shape = "clothoid"  # how curvature and cant change on a transition

    @property
    def end(self) -> float:
        """Distance at which it ends [m]."""
        return self.start + self.length


@dataclass(frozen=True)
class Line:
    """Curvature and cant of a track over the distance."""

    segments: tuple[Segment, ...]  # in their order; the first continues before its start, the last beyond its end
    curvature: PiecewiseCubic  # positive in a curve to the left [1/m]
    cant: PiecewiseCubic  # height of the right rail over the left one [m]
    cant_base: float  # distance over which the cant is measured [m]

    @property
    def length(self) -> float:
        """Distance at which the last segment ends [m]."""
        return self.segments[-1].end

    def heading(self, s: ArrayLike) -> Array:
        """Angle through which the line has turned since s = 0, positive to the left [rad]."""
        return self.curvature.integral(s)

    def segment_at(self, s: float) -> int:
        """Number of the segment at a distance [m], counted from 0."""
        starts = [segment.start for segment in self.segments]
        return max(int(np.searchsorted(starts, s, side="right")) - 1, 0)


def build_line(segments: Sequence[Segment], smoothing: float, cant_base: float) -> Line:
    """The line of some segments that join.

    Args:
        segments: in their order, each beginning where the one before ends, with the same curvature and cant.
        smoothing: length over which a corner of curvature and cant is rounded [m].
        cant_base: distance over which the cant is measured [m].
    """
    chain = tuple(segments)
    return Line(
        chain,
        ramps(chain, [s.curvature for s in chain], smoothing),
        ramps(chain, [s.cant for s in chain], smoothing),
        cant_base,
    )


def ramps(segments: Sequence[Segment], ends: Sequence[tuple[float, float]], smoothing: float) -> PiecewiseCubic:
    """A function that goes from one value to another on each segment, its corners rounded; once continuously differentiable."""
    pieces = list(zip(segments, ends, strict=True))
    sharp = [_ramp(segment, *ends) for segment, ends in pieces]
    end, last = pieces[-1][0].end, pieces[-1][1][1]
    rows = PiecewiseCubic(np.array([*sharp, [end, last, 0.0, 0.0, 0.0]]))
    # slope at the end of one piece, and at the start of the next
    jumps = [
        (after[0], after[2] - _slope_at_end(before, segment.length))
        for before, after, (segment, _) in zip(sharp[:-1], sharp[1:], pieces[:-1], strict=True)
    ]
    corners = [(s, jump) for s, jump in jumps if jump != 0.0]
    half = smoothing / 2
    knots = sorted({*rows.rows[:, 0], *(s + side for s, _ in corners for side in (-half, half))})
    pieces_between = zip(knots, [*knots[1:], knots[-1] + 2.0], strict=True)  # any point beyond the last knot will do
    return PiecewiseCubic(np.array([_row_at(rows, corners, half, a, (a + b) / 2) for a, b in pieces_between]))


def _ramp(segment: Segment, start: float, end: float) -> list[float]:
    change, length = end - start, segment.length
    if segment.kind == "transition" and segment.shape == "bloss":
        return [segment.start, start, 0.0, 3 * change / length**2, -2 * change / length**3]
    return [segment.start, start, change / length, 0.0, 0.0]


def _slope_at_end(row: list[float], length: float) -> float:
    _, _, c1, c2, c3 = row
    return 0.0 if c3 else c1 + length * 2 * c2  # a Bloss transition ends level


def _row_at(
    sharp: PiecewiseCubic, corners: Sequence[tuple[float, float]], half: float, start: float, inside: float
) -> list[float]:
    """Coefficients about `start` of the sharp function and of the roundings that reach the point `inside`."""
    s_k, *c = sharp.rows[max(int(np.searchsorted(sharp.rows[:, 0], inside, side="right")) - 1, 0)]
    if inside < sharp.rows[0, 0]:
        s_k, c = start, [c[0], 0.0, 0.0, 0.0]
    t = start - s_k
    row = [c[0] + t * (c[1] + t * (c[2] + t * c[3])), c[1] + t * (2 * c[2] + t * 3 * c[3]), c[2] + 3 * t * c[3], c[3]]
    for corner, jump in corners:
        if abs(inside - corner) >= half:
            continue
        # jump (u + half)^2 / (4 half) in place of jump max(0, u), u = s - corner
        u = start - corner
        past = 1.0 if inside > corner else 0.0
        row[0] += jump * ((u + half) ** 2 / (4 * half) - past * u)
        row[1] += jump * ((u + half) / (2 * half) - past)
        row[2] += jump / (4 * half)
    return [start, *row]
