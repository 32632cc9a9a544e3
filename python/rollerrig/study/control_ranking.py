"""Which limits a controller exceeds along an axis, and where, and the curves in the order of their worst result.

Results along a family's axis -> [failures] -> parts in which tracking or ripple is beyond its limit -> [ranking]
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from rollerrig.results import COMPLETED
from rollerrig.study.control_variants import Family

TRACKING_LIMIT = 0.01
"""Tracking RMS over train speed from which on a variant fails: the project's aim for the shipped cases [-]."""

RIPPLE_LIMIT = 500.0
"""Ripple of a roller's torque [N m] from which on a variant fails: a tenth of what low adhesion asks for, R T_v.

The one criterion of a torque that does not settle; every verdict names it, see RIPPLE_CRITERION.
"""

RIPPLE_CRITERION = f"persistent torque ripple above {RIPPLE_LIMIT:g} N m RMS"
TRACKING_CRITERION = f"tracking error above {100 * TRACKING_LIMIT:g} % RMS"


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
class Failure:
    """A part of a curve in which every value tried fails of one cause.

    Attributes:
        cause: as of Result.
        begin, end: of the part, ascending; where a value without a failure is next to it, interpolated to where tracking or
            ripple passes its limit. NaN: it goes on to the end of the values tried.
        largest: tracking RMS [-] or ripple [N m], the largest there; NaN where the tests ended early.
        largest_at: value that has it, or whose test ended first.
    """

    cause: str
    begin: float
    end: float
    largest: float
    largest_at: float

    @property
    def throughout(self) -> bool:
        """Whether it goes on to both ends of the values tried."""
        return math.isnan(self.begin) and math.isnan(self.end)


@dataclass(frozen=True)
class Rank:
    """One curve in the order of how badly it fares.

    Attributes:
        family: of FAMILIES.
        points: its results along the axis.
        worst: the result of most severity.
        failures: the parts of the axis in which it fails.
    """

    family: Family
    points: list[Result]
    worst: Result
    failures: list[Failure]

    @property
    def curve(self) -> str:
        """Its label."""
        return self.worst.curve


MEASURED = {"tracking": ("tracking_rms", TRACKING_LIMIT), "ripple": ("ripple_nm", RIPPLE_LIMIT)}
"""Cause -> the number that decides it, and its limit."""


def failures(family: Family, points: Sequence[Result]) -> list[Failure]:
    """All parts of a curve that fail: a curve may pass again beyond one.

    Args:
        family: of the curve.
        points: of one curve, in the order of the axis.
    """
    found, last = [], len(points) - 1
    for cause, group in itertools.groupby(range(len(points)), key=lambda k: points[k].cause):
        if not cause:
            continue
        places = list(group)
        worst = points[max(places, key=lambda k: points[k].severity)]
        largest = float(worst.numbers[MEASURED[cause][0]]) if cause in MEASURED else math.nan
        low, high = places[0], places[-1]
        begin = _border(family, points[low], points[low - 1]) if low > 0 else math.nan
        end = _border(family, points[high], points[high + 1]) if high < last else math.nan
        found.append(Failure(cause, begin, end, largest, worst.value))
    return found


def _along(family: Family, value: float) -> float:
    return math.log(value) if family.scale == "log" else value


def _border(family: Family, bad: Result, other: Result) -> float:
    """Where the failure begins, in the logarithm of the error; the value itself where the neighbour fails too, or tests end."""
    if other.cause or bad.cause not in MEASURED:
        return bad.value
    key, limit = MEASURED[bad.cause]
    low, high = (math.log(r.numbers[key]) for r in (other, bad))
    a, b = _along(family, other.value), _along(family, bad.value)
    value = a + (math.log(limit) - low) / (high - low) * (b - a)
    return math.exp(value) if family.scale == "log" else value


def ranking(families: Sequence[Family], results: Sequence[Result]) -> list[Rank]:
    """All curves, the most severe result within the range tried first."""
    ranks = []
    for family in families:
        mine = [r for r in results if r.family == family.name]
        for curve in dict.fromkeys(r.curve for r in mine):
            points = sorted((r for r in mine if r.curve == curve), key=lambda r: r.value)
            worst = max(points, key=lambda r: r.severity)
            ranks.append(Rank(family, points, worst, failures(family, points)))
    return sorted(ranks, key=lambda rank: rank.worst.severity, reverse=True)
