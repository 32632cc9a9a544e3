"""The profile as the contact search sees it: a cubic spline on uniform knots.

    definition or measured points -> [ProfileTable] -> contact geometry

A profile is given for the LEFT wheel or rail, as a height over an abscissa that grows outward,
away from the track centre; the right side is its mirror image.

    wheel   abscissa S: 0 at the tape circle, negative towards the flange; value: radius increase
    rail    abscissa y: 0 at the highest point, negative towards the gauge side; value: height <= 0

Units   metres throughout.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from rollerrig.common.arrays import Array
from rollerrig.common.splines import cubic, pieces, quasi_interpolant


class ProfileError(ValueError):
    """A profile was asked for or read that has no usable shape.

    The message says where, what was found, what is allowed and, where one can guess, the likely fix.
    """


ProfileKind = Literal["wheel", "rail"]
HeightFunction = Callable[[Array], Array]

#: Knot spacing [m]. The 13 mm corner of a rail head asks for it: the slope of a cubic spline is off by
#: about h^3 f''''/125, which at 70 degrees on that corner is 1e-5 rad for 0.05 mm and 1e-4 for 0.1 mm.
DEFAULT_STEP = 0.05e-3

#: Steepest slope a table keeps [-], 79 degrees. Beyond it a height over an abscissa says little.
STEEPEST_SLOPE = 5.0


@dataclass(frozen=True, eq=False)
class ProfileTable:
    """A profile as a twice continuously differentiable cubic spline on uniform knots.

    On the interval `i`, with t = y - y_i and y_i = start + i step,

        value(y) = c_i0 + c_i1 t + c_i2 t^2 + c_i3 t^3
    """

    name: str  # what the profile is called, for messages and figures
    kind: ProfileKind  # "wheel" or "rail"; it decides what abscissa and value mean (see the module's text)
    start: float  # first knot [m]
    step: float  # distance between knots [m]
    coefficients: Array  # (n, 4), one row per interval [m, 1, 1/m, 1/m^2], read-only
    source: str  # where the shape comes from
    # (k, 2) points [m] along the whole shape, steep flanks included, where the spline stops at a slope of
    # STEEPEST_SLOPE. The gauge of a track is taken on such a flank
    outline: Array = field(repr=False)
    # (m, 2) points [m] from which the curve was smoothed, in the same axes; none of a curve by definition
    measured: Array = field(repr=False, default_factory=lambda: np.empty((0, 2)))

    def __post_init__(self) -> None:
        """Freeze the arrays in the layout the compiled core reads; refuse what is not a profile."""
        if self.kind not in ("wheel", "rail"):
            raise ProfileError(f"{self.name}: kind: {self.kind!r} is not one of wheel, rail")
        if not (np.isfinite(self.step) and self.step > 0 and np.isfinite(self.start)):
            raise ProfileError(f"{self.name}: step: {self.step} m; it must be positive and finite")
        for attribute, columns in (("coefficients", 4), ("outline", 2)):
            values = np.array(getattr(self, attribute), dtype=np.float64, order="C")
            if values.ndim != 2 or values.shape[1] != columns or len(values) == 0:
                raise ProfileError(f"{self.name}: {attribute}: shape {values.shape}; allowed (n, {columns}), n > 0")
            if not np.all(np.isfinite(values)):
                raise ProfileError(f"{self.name}: {attribute}: not a finite number in row {_first_bad(values)}")
            values.flags.writeable = False
            object.__setattr__(self, attribute, values)
        self.measured.flags.writeable = False

    def scaled(self, factor: float) -> "ProfileTable":
        """The same curve with all lengths times a factor: the profile of a model of a wheel or rail.

        Raises:
            ProfileError: the factor is not positive.
        """
        if not (np.isfinite(factor) and factor > 0):
            raise ProfileError(f"{self.name}: length_scale: {factor}; it must be positive")
        coefficients = self.coefficients * factor ** np.array([1.0, 0.0, -1.0, -2.0])
        start, step, outline = factor * self.start, factor * self.step, factor * self.outline
        return ProfileTable(
            f"{self.name}, scaled by {factor:g}", self.kind, start, step, coefficients, self.source, outline,
            factor * self.measured,
        )  # fmt: skip

    @property
    def domain(self) -> tuple[float, float]:
        """First and last abscissa [m]."""
        return self.start, self.start + len(self.coefficients) * self.step

    def evaluate(self, y: ArrayLike, derivative: int = 0) -> Array:
        """Value of the spline, or one of its derivatives.

        Args:
            y: abscissa [m], any shape, inside `domain`.
            derivative: 0 for the value [m], 1 slope [-], 2 second derivative [1/m], 3 [1/m^2].

        Returns:
            Array of the shape of `y`.

        Raises:
            ProfileError: if an abscissa lies outside the domain.
        """
        y = np.asarray(y, dtype=np.float64)
        low, high = self.domain
        if not np.all((y >= low - 1e-12) & (y <= high + 1e-12)):  # a picometre of round-off is no mistake
            raise ProfileError(
                f"{self.name}: abscissa outside the profile: asked for {np.min(y) * 1e3:.6g} to "
                f"{np.max(y) * 1e3:.6g} mm; allowed {low * 1e3:.6g} to {high * 1e3:.6g} mm"
            )
        row = np.clip(np.floor((y - self.start) / self.step).astype(np.intp), 0, len(self.coefficients) - 1)
        t = y - (self.start + row * self.step)
        return cubic(self.coefficients[row], t, derivative)

    def curvature(self, y: ArrayLike) -> Array:
        """Curvature -f''/(1 + f'^2)^1.5 of the curve as drawn, value upward [1/m].

        Positive where a rail head is convex, and where a wheel is: on the tip of its flange, where its radius is largest.
        """
        slope = self.evaluate(y, 1)
        return np.asarray(-self.evaluate(y, 2) / (1 + slope**2) ** 1.5)


def tabulate(
    height: HeightFunction,
    low: float,
    high: float,
    *,
    name: str,
    kind: ProfileKind,
    source: str,
    step: float = DEFAULT_STEP,
    outline: Array | None = None,
) -> ProfileTable:
    """Turn any height function into a spline table.

    The spline is not an interpolant but a local quasi-interpolant, of fourth order like interpolation. Where the
    definition's curvature jumps (arc against arc) it overshoots by a twelfth of the jump at the next knot and by
    nothing beyond, while an interpolant oscillates: an error of curvature is an error of Hertz stiffness.

    Args:
        height: value [m] over abscissa [m]; called once, with an array inside [low, high].
        low: first abscissa [m].
        high: last abscissa [m].
        name: see ProfileTable.
        kind: see ProfileTable.
        source: see ProfileTable.
        step: largest distance between knots [m]; it is shrunk so that a whole number fits.
        outline: see ProfileTable; by default the samples of the spline.

    Returns:
        The table, over [low, high].

    Raises:
        ProfileError: if the interval is empty or the height is not finite somewhere.
    """
    if not (np.isfinite(low) and np.isfinite(high) and high > low):
        raise ProfileError(f"{name}: empty profile: it spans {low * 1e3:.6g} to {high * 1e3:.6g} mm")
    intervals = max(8, int(np.ceil((high - low) / step - 1e-9)))
    y = np.linspace(low, high, intervals + 1)
    f = np.asarray(height(y), dtype=np.float64)
    if not np.all(np.isfinite(f)):
        raise ProfileError(f"{name}: not a finite height at abscissa {y[_first_bad(f)] * 1e3:.6g} mm")

    # Two samples beyond each end by the cubic through the last four: B-splines reach over the ends.
    for _ in range(2):
        before = 4 * f[0] - 6 * f[1] + 4 * f[2] - f[3]
        after = 4 * f[-1] - 6 * f[-2] + 4 * f[-3] - f[-4]
        f = np.concatenate(([before], f, [after]))
    w = quasi_interpolant(f[:-2], f[1:-1], f[2:])
    h = (high - low) / intervals
    coefficients = pieces(w[:-3], w[1:-2], w[2:-1], w[3:], h)
    if outline is None:
        outline = np.column_stack([y, f[2:-2]])
    return ProfileTable(name, kind, float(low), h, coefficients, source, outline)


@lru_cache(maxsize=64)
def gauge_point(table: ProfileTable, depth: float = 14e-3) -> float:
    """Abscissa of the point of a rail where its gauge is taken.

    A track of gauge G has its left rail's origin at y = G/2 + |gauge_point|.

    Args:
        table: a rail.
        depth: how far below the highest point [m]; EN 13848 takes 14 mm.

    Returns:
        Abscissa y [m] of the first point on the gauge side (y < 0) that lies `depth` below; negative.

    Raises:
        ProfileError: if the table is a wheel, or the rail does not reach down that far.
    """
    if table.kind != "rail":
        raise ProfileError(f"{table.name}: the gauge is taken on a rail; this is a wheel profile")
    if not depth > 0:
        raise ProfileError(f"{table.name}: gauge depth: {depth * 1e3:.6g} mm; it must be positive")
    y, z = table.outline.T
    # a file may end right at the gauge point: 10 um in 14 mm are made up by extrapolation
    reach = -depth + depth / 1400
    descending = np.flatnonzero((z[:-1] < reach) & (z[1:] >= -depth) & (y[1:] < 0))
    if len(descending) == 0:
        deepest = -np.min(z[y < 0], initial=0.0)
        raise ProfileError(
            f"{table.name}: no gauge point: the gauge side reaches {deepest * 1e3:.4g} mm below the highest point; "
            f"needed {depth * 1e3:.4g} mm; give a smaller gauge depth, or a profile that goes down further"
        )
    i = descending[-1]  # the one nearest to the head
    fraction = (-depth - z[i]) / (z[i + 1] - z[i])
    return float(y[i] + fraction * (y[i + 1] - y[i]))


def _first_bad(values: Array) -> int:
    return int(np.flatnonzero(~np.isfinite(values))[0] // (values.shape[1] if values.ndim == 2 else 1))


@lru_cache(maxsize=64)  # of a constant table
def flange_angle(wheel: ProfileTable) -> float:
    """Steepest slope of a wheel profile towards the flange, as an angle [rad]."""
    low, high = wheel.domain
    abscissa = low + wheel.step * np.arange(len(wheel.coefficients) + 1)
    return math.atan(float(np.max(-wheel.evaluate(np.minimum(abscissa, high), 1))))
