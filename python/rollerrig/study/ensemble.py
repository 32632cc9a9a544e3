"""Repeatability: the same test begun at slightly different instants, and what its results scatter by.

Case -> [starts] -> cases begun later -> values -> [scatter] -> mean, standard error, range

Slide protection and wheel-slip control switch on small differences: a difference below the scatter of repeated tests means
nothing.
"""

from __future__ import annotations

from collections.abc import Sequence

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


def scatter(values: Sequence[float]) -> tuple[float, float, float]:
    """Mean of at least two tests, its standard error s / sqrt(n), s with n - 1, and largest less smallest over the mean [-]."""
    mean = float(np.mean(values))
    return mean, float(np.std(values, ddof=1) / np.sqrt(len(values))), (max(values) - min(values)) / mean
