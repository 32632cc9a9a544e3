"""A quantity that is known between two ends: an interval is reported, never its middle.

critical speed by disturbance -> [Interval] -> text, verdicts: true, false, or not decided
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from rollerrig.analysis import CriticalSpeedByDisturbance

NOT_DECIDED = "not decided"


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
    def of_bracket(cls, found: CriticalSpeedByDisturbance) -> Interval:
        """The critical speed by disturbance [km/h]: from where the motion decays to where it persists."""
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

    def below(self, other: Interval) -> bool | None:
        """Whether the quantity is the smaller one; None: not decided, since the intervals overlap."""
        if self.high <= other.low:
            return True
        return False if self.low >= other.high else None

    def distance(self, value: float) -> Interval:
        """How far the quantity is from a value."""
        ends = sorted((abs(self.low - value), abs(self.high - value)))
        return Interval(0.0 if self.low <= value <= self.high else ends[0], ends[1])

    def over(self, other: Interval) -> Interval:
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


def in_words(verdict: bool | None) -> str:
    """'yes', 'no', or 'not decided'."""
    return {True: "yes", False: "no", None: NOT_DECIDED}[verdict]
