"""Assessment of a quantity that is known between two ends: met, not met, or not decided; an interval, never its middle.

critical speed by disturbance, mean of an ensemble -> [Interval] -> [outcome] within limits -> tables, counts, numbers
value or interval, expected value, tolerance -> [Check] -> table of the report, numbers of summary.json

A limit is met where the whole interval is within it and not met where nothing of it is. What is no number is not decided.
"""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any, Literal

from rollerrig.analysis.critical_speed import CriticalSpeedByDisturbance
from rollerrig.common.formatting import number
from rollerrig.study.report import Table

Outcome = Literal["met", "not met", "not decided"]
NOT_DECIDED: Outcome = "not decided"
SHOWN: dict[str | None, str] = {"met": "✔ met", "not met": "✘ NOT met", NOT_DECIDED: "? not decided", None: "–"}


@dataclass(frozen=True)
class Interval:
    """Between which values a quantity lies.

    Attributes:
        low: lower end; -inf: nothing bounds it from below.
        high: upper end; inf: nothing bounds it from above.
    """

    low: float
    high: float

    @classmethod
    def of_bracket(cls, found: CriticalSpeedByDisturbance | None) -> "Interval":
        """The critical speed by disturbance [km/h]: from where the motion decays to where it persists; None: not computed."""
        if found is None:
            return cls(-math.inf, math.inf)
        decays, persists = 3.6 * found.decays, 3.6 * found.persists
        return cls(-math.inf if math.isnan(decays) else decays, math.inf if math.isnan(persists) else persists)

    @property
    def bounded(self) -> bool:
        """Whether both ends are known."""
        return math.isfinite(self.low) and math.isfinite(self.high)

    @property
    def known(self) -> bool:
        """Whether at least one end is known."""
        return math.isfinite(self.low) or math.isfinite(self.high)

    def text(self, unit: str, digits: int = 0) -> str:
        """As a report shows it: '164.4 … 166.7 km/h', 'above 160 km/h', 'at most 100 km/h', or a dash."""
        if not self.known:
            return "–"
        if not self.bounded:
            word, end = ("above", self.low) if math.isfinite(self.low) else ("at most", self.high)
            return f"{word} {end:z.{digits}f} {unit}"
        ends = [f"{end:z.{digits}f}" for end in (self.low, self.high)]
        return f"{' … '.join(dict.fromkeys(ends))} {unit}"

    def within(self, low: float, high: float) -> bool | None:
        """Whether the quantity lies in a range, ends included; None: not decided, since only a part of the interval does."""
        if low <= self.low and self.high <= high:
            return True
        return False if self.high < low or self.low > high else None

    def distance(self, value: float) -> "Interval":
        """How far the quantity is from a value."""
        ends = sorted((abs(self.low - value), abs(self.high - value)))
        return Interval(0.0 if self.low <= value <= self.high else ends[0], ends[1])

    def over(self, other: "Interval") -> "Interval":
        """Its ratio to another quantity, both positive."""
        if not (self.known and other.known):
            return Interval(-math.inf, math.inf)
        return Interval(self.low / other.high, self.high / other.low if other.low > 0.0 else math.inf)


def change_in_words(ratio: Interval) -> str:
    """A ratio as a change: '18.4 % lower', '20.4 to 22.4 % lower', 'between 1.0 % lower and 0.5 % higher'."""
    low, high = 100.0 * (ratio.low - 1.0), 100.0 * (ratio.high - 1.0)
    if low < 0.0 < high:
        return f"between {-low:.1f} % lower and {high:.1f} % higher"
    ends = sorted({f"{abs(end):.1f}" for end in (low, high)}, key=float)
    return f"{' to '.join(ends)} % {'lower' if high <= 0.0 else 'higher'}"


def outcome(value: Interval, low: float, high: float, *, excluded: bool = False) -> Outcome:
    """Whether a quantity is within its limits, both included; where `excluded`, only a disagreement says something."""
    within = value.within(low, high)
    if within is None or (within and excluded):
        return NOT_DECIDED
    return "met" if within else "not met"


def overall(outcomes: Iterable[Outcome]) -> Outcome | None:
    """Overall assessment of several: met where all are, not met where one is not, else not decided; None: there is none."""
    found = set(outcomes)
    if not found or "not met" in found:
        return "not met" if found else None
    return "met" if found == {"met"} else NOT_DECIDED


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
    def deviations(self) -> Interval:
        """Smallest and largest distance from the expected value; the same where the value is a number."""
        found = self.value if isinstance(self.value, Interval) else Interval(self.value, self.value)
        if self.kind == "at most":
            ends = [end - self.expected if not end < self.expected else 0.0 for end in (found.low, found.high)]
            found = Interval(*ends)
        else:
            found = found.distance(self.expected)
        if not self.relative:
            return found
        scale = 1.0 / abs(self.expected) if self.expected else math.inf
        return Interval(found.low * scale if found.low else 0.0, found.high * scale if found.high else 0.0)

    @property
    def deviation(self) -> float:
        """Largest distance from the expected value."""
        return self.deviations.high

    @property
    def outcome(self) -> str:
        """'passed' where the whole value is within the tolerance, 'failed' where nothing of it is, else 'not decided'."""
        found = outcome(self.deviations, -math.inf, self.tolerance)
        return {"met": "passed", "not met": "failed"}.get(found, found)

    @property
    def passed(self) -> bool:
        """Whether the whole value is within the tolerance."""
        return self.outcome == "passed"

    def as_dict(self) -> dict[str, Any]:
        """Dictionary for summary.json; an interval as a list of its ends, null where there is none."""
        value = [self.value.low, self.value.high] if isinstance(self.value, Interval) else self.value
        return {**vars(self), "value": value, "deviation": self.deviation, "outcome": self.outcome}

    @property
    def row(self) -> tuple[str, ...]:
        """As a line of `check_table`."""
        scale, unit = (100.0, "%") if self.relative else (1.0, self.unit)
        shown = (
            self.value.text(self.unit, 1) if isinstance(self.value, Interval) else f"{number(self.value)} {self.unit}"
        )
        bound = "at most " if self.kind == "at most" else ""
        target = f"{bound}{number(self.expected)} {self.unit}".strip()
        sizes = (f"{number(scale * size, 3)} {unit}".strip() for size in (self.deviation, self.tolerance))
        word = {"passed": "✔ pass", "failed": "✘ FAIL", NOT_DECIDED: SHOWN[NOT_DECIDED]}[self.outcome]
        return (word, self.name, shown.strip(), target, *sizes, self.reason)


def counts(checks: Sequence[Check]) -> dict[str, int]:
    """How many there are of each outcome, by keys of summary.json."""
    found = [check.outcome for check in checks]
    return {f"checks_{word.replace(' ', '_')}": found.count(word) for word in ("passed", "failed", NOT_DECIDED)}


def counts_text(checks: Sequence[Check]) -> str:
    """In words: '25 of 27 checks are decided: 25 passed, none failed.'."""
    passed, failed, undecided = counts(checks).values()
    text = f"{passed + failed} of {len(checks)} checks are decided: {passed} passed, {failed or 'none'} failed."
    return text + (" Not decided are those whose computed interval agrees in part only." if undecided else "")


def check_table(checks: Sequence[Check]) -> Table:
    """The checks as a table."""
    header = ("", "check", "computed", "expected", "deviation", "tolerance", "why this tolerance")
    return Table(header, [check.row for check in checks])
