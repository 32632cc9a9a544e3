"""Which limit a controller exceeds first along an axis, and the curves in the order of their worst result.

Results along a family's axis -> [thresholds] -> value at which tracking or ripple passes its limit -> [ranking]
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from rollerrig.results import COMPLETED
from rollerrig.study.control_variants import Family

TRACKING_LIMIT = 0.01
"""Tracking RMS over train speed from which on a variant fails: the project's aim for the shipped cases [-]."""

RIPPLE_LIMIT = 500.0
"""Ripple of a roller's torque [N m] from which on a variant fails: a tenth of what low adhesion asks for, R T_v."""


@dataclass(frozen=True)
class Result:
    """What came out of a run.

    Attributes:
        family, curve: where it belongs.
        value: on the family's axis; NaN for a reference.
        numbers: of the run.
    """

    family: str
    curve: str
    value: float
    numbers: dict[str, Any]

    @property
    def completed(self) -> bool:
        """Whether the test came to its end."""
        return bool(self.numbers["status"] in COMPLETED)

    @property
    def cause(self) -> str:
        """Why it fails: the status of a run that ended early, 'tracking', 'ripple', or ''."""
        if not self.completed:
            return str(self.numbers["status"])
        if not self.numbers["tracking_rms"] < TRACKING_LIMIT:
            return "tracking"
        return "ripple" if self.numbers["ripple_nm"] > RIPPLE_LIMIT else ""

    @property
    def severity(self) -> tuple[float, float]:
        """Order of results: an ended test before any error, the earlier the worse; then the larger error over its limit.

        A ripple within its limit does not count: it scatters with the switching of valves.
        """
        if not self.completed:
            return math.inf, -float(self.numbers["ended_s"])
        ripple, tracking = self.numbers["ripple_nm"] / RIPPLE_LIMIT, self.numbers["tracking_rms"] / TRACKING_LIMIT
        return max(tracking, ripple if ripple > 1.0 else 0.0), 0.0


@dataclass(frozen=True)
class Threshold:
    """Where a curve first fails on one side of the case's own value.

    Attributes:
        value: at which tracking or ripple passes its limit, interpolated, or at which the test first ended early.
        last_good: last value without a failure; NaN: none.
        cause: as of Result.
    """

    value: float
    last_good: float
    cause: str


@dataclass(frozen=True)
class Rank:
    """One curve in the order of how badly it fares.

    Attributes:
        family: of FAMILIES.
        points: its results along the axis.
        worst: the result of most severity.
        thresholds: where it fails, 0 to 2 places.
    """

    family: Family
    points: list[Result]
    worst: Result
    thresholds: list[Threshold]

    @property
    def curve(self) -> str:
        """Its label."""
        return self.worst.curve


def thresholds(family: Family, points: Sequence[Result], base: float | None) -> list[Threshold]:
    """Where a curve first fails, going out from the base value to either side.

    Args:
        family: of the curve.
        points: of one curve, in the order of the axis.
        base: value of the case; None: outwards from the best point.
    """
    if not points:
        return []
    if base is None:
        start = min(range(len(points)), key=lambda k: points[k].severity)
    else:
        start = int(np.argmin([abs(_along(family, p.value) - _along(family, base)) for p in points]))
    if points[start].cause:
        return [Threshold(points[start].value, math.nan, points[start].cause)]
    found = []
    for side in (-1, 1):
        k = start
        while 0 <= k + side < len(points) and not points[k + side].cause:
            k += side
        if 0 <= k + side < len(points):
            found.append(_crossing(family, points[k], points[k + side]))
    return found


def _along(family: Family, value: float) -> float:
    return math.log(value) if family.scale == "log" else value


def _crossing(family: Family, good: Result, bad: Result) -> Threshold:
    """Interpolated in the logarithm of the error; of a test that ended early, the first value tried."""
    limits = {"tracking": ("tracking_rms", TRACKING_LIMIT), "ripple": ("ripple_nm", RIPPLE_LIMIT)}
    if bad.cause not in limits:
        return Threshold(bad.value, good.value, bad.cause)
    key, limit = limits[bad.cause]
    low, high = (math.log(r.numbers[key]) for r in (good, bad))
    a, b = _along(family, good.value), _along(family, bad.value)
    value = a + (math.log(limit) - low) / (high - low) * (b - a)
    return Threshold(math.exp(value) if family.scale == "log" else value, good.value, bad.cause)


def ranking(case: Any, families: Sequence[Family], results: Sequence[Result]) -> list[Rank]:
    """All curves, the most severe result within the range tried first."""
    ranks = []
    for family in families:
        mine = [r for r in results if r.family == family.name]
        base = family.base(case) if family.base is not None else None
        for curve in dict.fromkeys(r.curve for r in mine):
            points = sorted((r for r in mine if r.curve == curve), key=lambda r: r.value)
            worst = max(points, key=lambda r: r.severity)
            ranks.append(Rank(family, points, worst, thresholds(family, points, base)))
    return sorted(ranks, key=lambda rank: rank.worst.severity, reverse=True)
