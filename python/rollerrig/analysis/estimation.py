"""Least squares with intervals: which values of a few numbers fit what was measured, and which of them the data determine.

    residuals over free numbers -> [estimate] -> values, intervals of 95 %, correlations, what is not determined

Each number is sought over its range as u from 0 to 1, straight or logarithmic; a prior is one more residual.

    residuals r_i over their standard deviations, J = dr/du      covariance of u = s² (JᵀJ)⁻¹
    s = 1 where deviations were given and fit what is left, else the r.m.s. of that, √(Σ r² / (n - p))
    J = U S Vᵀ                                                    the combination V_k has the standard deviation s/S_k

Residuals that follow each other, with a correlation ρ from one to the next, count as fewer, n (1 - ρ)/(1 + ρ), as those of the
mean of an autoregressive series: so many degrees of freedom are left, and their rows of J are divided by the root of that share.
What the fit took from ρ is given back: ρ = (r + p/n)/(1 - (p + 2)/n) of the correlation r that is found.

A number that may be anywhere in its range has 1/√12 of the range as its standard deviation: a combination that the data do not
know better than that is not determined.
Source: G. A. F. Seber, C. J. Wild, Nonlinear Regression (1989), ch. 2, 5 and 6; the bias of r: M. G. Kendall, Biometrika 41
(1954) 403, for a mean, here for p numbers.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Literal

import numpy as np

from rollerrig.common.arrays import Array
from rollerrig.common.formatting import number
from rollerrig.common.free_number import FreeNumber
from rollerrig.common.linear_algebra import one_blas_thread

Loss = Literal["linear", "soft_l1", "huber", "cauchy"]
Function = Callable[[Array], Array]

CONFIDENCE = 0.95
UNKNOWN = 1.0 / math.sqrt(12.0)  # standard deviation of what may be anywhere in a range, over that range
PART = 0.3  # numbers with less of a combination are not named with it
CHANCE = 1e-3  # probability below which given standard deviations do not fit what is left
CLEAR = 2.0  # standard deviations of a correlation by chance, 1/√n, from which residuals follow each other
EDGE = 1e-3  # an estimate so near to an end of its range, over the range, is decided by it


@dataclass(frozen=True)
class Estimate:
    """What least squares found."""

    free: tuple[FreeNumber, ...]  # the numbers that were sought
    places: Array  # where in its range each is found, shape (free,)
    covariance: Array  # of the places, shape (free, free)
    singular_values: Array  # of the data over the places, falling, in units of one standard deviation
    combinations: Array  # right singular vectors, shape (free, free), a row each
    deviation: float  # s, r.m.s. of what is left in standard deviations, after degrees of freedom
    degrees_of_freedom: int  # residuals less free numbers
    cost: float  # half the sum of squares, of a robust loss its sum
    known: bool  # whether standard deviations of the data were given
    scale: float  # s
    # degrees of freedom of the intervals, fewer where residuals follow each other; infinite where s is 1
    freedom: float

    @cached_property
    def values(self) -> dict[str, float]:
        """Name -> value."""
        return {one.name: one.value(float(u)) for one, u in zip(self.free, self.places, strict=True)}

    @cached_property
    def errors(self) -> dict[str, float]:
        """Name -> standard error, in the unit of the number."""
        slopes = [one.slope(self.values[one.name]) for one in self.free]
        return dict(zip(self.values, (np.sqrt(np.diag(self.covariance)) * slopes).tolist(), strict=True))

    @cached_property
    def intervals(self) -> dict[str, tuple[float, float]]:
        """Name -> ends of the interval of 95 %, not beyond the range."""
        from scipy.stats import t

        half = float(t.ppf(0.5 * (1.0 + CONFIDENCE), self.freedom)) * np.sqrt(np.diag(self.covariance))
        ends = np.clip([self.places - half, self.places + half], 0.0, 1.0).T.tolist()
        return {one.name: (one.value(low), one.value(high)) for one, (low, high) in zip(self.free, ends, strict=True)}

    @cached_property
    def correlations(self) -> Array:
        """Shape (free, free)."""
        size = np.sqrt(np.diag(self.covariance))
        return np.asarray(self.covariance / np.outer(size, size))

    @property
    def at_an_end(self) -> list[str]:
        """Numbers that are found at an end of their range."""
        return [one.name for one, u in zip(self.free, self.places, strict=True) if not EDGE < u < 1.0 - EDGE]

    @property
    def undetermined(self) -> list[str]:
        """Combinations that the data do not know better than their ranges, in words."""
        found, scale = [], self.scale
        for size, row in zip(self.singular_values.tolist(), self.combinations, strict=True):
            parts = sorted((-abs(part), one.name) for one, part in zip(self.free, row, strict=True) if abs(part) > PART)
            if size * UNKNOWN <= scale:
                spread = (
                    f"standard deviation {number(scale / size, 2)} of the range" if size else "nothing depends on it"
                )
                found.append(f"{' with '.join(name for _, name in parts)}: {spread}, singular value {number(size, 2)}")
        return found


def correlation(series: Array) -> float:
    """Correlation of each residual with the one before; NaN of less than three or of none."""
    if len(series) < 3 or not np.ptp(series) > 0.0:
        return math.nan
    return float(np.corrcoef(series[1:], series[:-1])[0, 1])


def widening(series: Array, fitted: int) -> float:
    """Factor on standard errors for what so many fitted numbers left, where it follows each other by more than chance."""
    found, count = correlation(series), len(series)
    if not found > CLEAR / math.sqrt(count):
        return 1.0
    follows = min((found + fitted / count) / max(1.0 - (fitted + 2.0) / count, 0.1), 1.0 - 2.0 / count)
    return math.sqrt((1.0 + follows) / (1.0 - follows))


@one_blas_thread()
def estimate(
    free: Sequence[FreeNumber],
    residuals: Function,
    start: Sequence[float] | Array,
    *,
    jacobian: Function | None = None,
    loss: Loss = "linear",
    known: bool = True,
    widenings: Function = np.ones_like,
) -> Estimate:
    """The values that make the sum of squares of the residuals least.

    Args:
        free: the numbers that are sought.
        residuals: values, shape (free,) -> deviations over their standard deviations, shape (n,).
        start: values to begin from.
        jacobian: values -> derivatives of the residuals by the values, shape (n, free); None: by differences.
        loss: what a residual counts; other than linear, few wrong points do not pull.
        known: whether the standard deviations are those of the data; else, or where that cannot be, what is left says how large
            they are.
        widenings: residuals that are left -> factor of each on its standard deviation, because they follow each other.

    Raises:
        ValueError: fewer residuals than free numbers.
    """
    from scipy.optimize import least_squares
    from scipy.stats import chi2

    prior = [(k, *one.prior) for k, one in enumerate(free) if one.prior is not None]
    of_prior = np.array([[free[k].width / spread * (k == j) for j in range(len(free))] for k, _, spread in prior])

    def values(places: Array) -> Array:
        return np.array([one.value(float(u)) for one, u in zip(free, places, strict=True)])

    def function(places: Array) -> Array:
        known_before = [(free[k].along(free[k].value(places[k])) - mean) / spread for k, mean, spread in prior]
        return np.concatenate([residuals(values(places)), known_before])

    def slopes(places: Array) -> Array:
        assert jacobian is not None
        at = values(places)
        own = jacobian(at) * [one.slope(float(v)) for one, v in zip(free, at, strict=True)]
        return np.vstack([own, of_prior]) if prior else own

    first = np.clip([one.place(float(v)) for one, v in zip(free, start, strict=True)], EDGE, 1.0 - EDGE)
    derivatives: Any = "3-point" if jacobian is None else slopes
    best = least_squares(function, first, derivatives, (0.0, 1.0), loss=loss, x_scale="jac", xtol=1e-7, ftol=1e-9)
    at_end = np.asarray(best.jac)
    rows, left = len(best.fun) - len(prior), len(best.fun) - len(free)
    if left < 0:
        raise ValueError(f"{rows} points cannot determine {len(free)} numbers")
    factors = widenings(best.fun[:rows])
    at_end[:rows] /= factors[:, None]
    count = float(np.sum(factors**-2.0)) + len(prior)
    deviation = math.sqrt(2.0 * float(best.cost) / left) if left else math.nan
    fits = known and not left * deviation**2 > chi2.isf(CHANCE, max(left, 1))
    freedom = math.inf if fits else max(count - len(free), 1.0)
    scale = 1.0 if fits else deviation * math.sqrt(left / len(best.fun) * count / freedom)
    sizes, rotation = _combinations(at_end)
    spread = scale / np.maximum(sizes, 1e-6)  # what nothing determines: to a million ranges
    covariance = (rotation.T * spread**2) @ rotation
    of_data = _combinations(at_end[:rows])
    return Estimate(tuple(free), best.x, covariance, *of_data, deviation, left, float(best.cost), known, scale, freedom)


def _combinations(jacobian: Array) -> tuple[Array, Array]:
    """Singular values, falling, zeros too, and right singular vectors of a matrix of any shape."""
    _, sizes, rows = np.linalg.svd(np.linalg.qr(jacobian, mode="r"), full_matrices=True)
    return np.concatenate([sizes, np.zeros(len(rows) - len(sizes))]), np.asarray(rows)
