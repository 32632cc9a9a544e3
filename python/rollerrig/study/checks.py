"""A computed value beside what it should be: passed, failed, or not decided.

value or interval, expected value, tolerance -> [Check] -> verdict -> table of the report, numbers of summary.json

A quantity that is only known to lie in an interval passes where the whole interval agrees and fails where none of it does.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

from rollerrig.study.interval import NOT_DECIDED, Interval
from rollerrig.study.report import Table
from rollerrig.wording import number

Verdict = Literal["passed", "failed", "not decided"]
SHOWN: dict[str, str] = {"passed": "✔ pass", "failed": "✘ FAIL", NOT_DECIDED: "? not decided"}


@dataclass(frozen=True)
class Check:
    """A number that should have a value.

    Attributes:
        name: what is checked.
        value: what came out, or where it lies.
        expected: what it should be.
        tolerance: allowed deviation, in the unit of `deviation`.
        reason: why the tolerance is what it is.
        unit: of value and expected.
        relative: whether deviation and tolerance are relative.
        kind: 'equal', or 'at most': what is below the expected value does not deviate from it.
    """

    name: str
    value: float | Interval
    expected: float
    tolerance: float
    reason: str
    unit: str = ""
    relative: bool = False
    kind: Literal["equal", "at most"] = "equal"

    @property
    def deviations(self) -> tuple[float, float]:
        """Smallest and largest distance from the expected value; the same where the value is a number."""
        found = self.value if isinstance(self.value, Interval) else Interval(self.value, self.value)
        if self.kind == "at most":
            ends = (max(found.low - self.expected, 0.0), max(found.high - self.expected, 0.0))
        else:
            distance = found.distance(self.expected)
            ends = (distance.low, distance.high)
        if not self.relative:
            return ends
        scale = 1.0 / abs(self.expected) if self.expected else math.inf
        return ends[0] * scale, ends[1] * scale

    @property
    def deviation(self) -> float:
        """Largest distance from the expected value."""
        return self.deviations[1]

    @property
    def verdict(self) -> Verdict:
        """'passed' where the whole value is within the tolerance, 'failed' where nothing of it is."""
        least, largest = self.deviations
        if largest <= self.tolerance:
            return "passed"
        return "not decided" if least <= self.tolerance else "failed"  # a value that is no number fails

    @property
    def passed(self) -> bool:
        """Whether the whole value is within the tolerance."""
        return self.verdict == "passed"

    def as_dict(self) -> dict[str, Any]:
        """For summary.json; an interval as a list of its ends, null where there is none."""
        value = [self.value.low, self.value.high] if isinstance(self.value, Interval) else self.value
        return {**vars(self), "value": value, "deviation": self.deviation, "verdict": self.verdict}


def counts(checks: Sequence[Check]) -> dict[str, int]:
    """How many there are of each verdict, by keys of summary.json."""
    found = [check.verdict for check in checks]
    return {
        "checks_passed": found.count("passed"),
        "checks_failed": found.count("failed"),
        "checks_not_decided": found.count("not decided"),
    }


def counts_text(checks: Sequence[Check]) -> str:
    """In words: '25 of 27 checks are decided: 25 passed, none failed.'."""
    passed, failed, undecided = counts(checks).values()
    text = f"{passed + failed} of {len(checks)} checks are decided: {passed} passed, {failed or 'none'} failed."
    return text + (" Not decided are those whose computed interval agrees in part only." if undecided else "")


def check_table(checks: Sequence[Check]) -> Table:
    """The checks as a table."""
    rows = []
    for check in checks:
        scale, unit = (100.0, "%") if check.relative else (1.0, check.unit)
        value = check.value
        shown = value.text(check.unit, 1) if isinstance(value, Interval) else f"{number(value)} {check.unit}".strip()
        bound = "at most " if check.kind == "at most" else ""
        rows.append(
            (
                SHOWN[check.verdict],
                check.name,
                shown,
                f"{bound}{number(check.expected)} {check.unit}".strip(),
                f"{number(scale * check.deviation, 3)} {unit}".strip(),
                f"{number(scale * check.tolerance, 3)} {unit}".strip(),
                check.reason,
            )
        )
    return Table(("", "check", "computed", "expected", "deviation", "tolerance", "why this tolerance"), rows)
