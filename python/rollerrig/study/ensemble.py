"""Repeatability: the same test begun at slightly different instants, and what its results scatter by.

Case -> [starts] -> cases begun later -> values -> [Scatter] -> mean, standard error, range

Slide protection and wheel-slip control switch on small differences: a difference below the scatter of repeated tests means
nothing.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rollerrig.config import Case

DELAYS = (0.01, 0.02, 0.03, 0.04)
"""How much later the repeated tests begin [s]."""


def starts(case: Case, delays: Sequence[float] = DELAYS) -> dict[float, Case]:
    """Delay [s] -> the same test with all demands of brake and traction that much later."""
    return {seconds: begun_later(case, seconds) for seconds in delays}


def begun_later(case: Case, seconds: float) -> Case:
    """The same test with all demands that much later."""
    changes = {}
    for key in ("brake", "traction"):
        table = getattr(case, key)
        if table is not None:
            rows = tuple((time + seconds if time > 0.0 else time, value) for time, value in table.demand)
            changes[key] = table.model_copy(update={"demand": rows})
    return case.model_copy(update=changes)


@dataclass(frozen=True)
class Scatter:
    """Of a quantity over repeated tests.

    Attributes:
        values: one per test; at least two.
    """

    values: tuple[float, ...]

    @property
    def mean(self) -> float:
        """Mean over the tests."""
        return float(np.mean(self.values))

    @property
    def standard_error(self) -> float:
        """Standard error of the mean: s / sqrt(n), s with n - 1 in its denominator."""
        return float(np.std(self.values, ddof=1) / np.sqrt(len(self.values)))

    @property
    def relative_range(self) -> float:
        """Largest less smallest, over the mean [-]."""
        return (max(self.values) - min(self.values)) / self.mean
