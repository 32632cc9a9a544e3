"""A number that is sought in a range: place 0 to 1, straight or in the logarithm, and value."""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(frozen=True)
class FreeNumber:
    """A number that is sought."""

    name: str  # for results
    # least, most: its range
    least: float
    most: float
    logarithmic: bool = False  # whether its logarithm is sought
    # mean and standard deviation of what was known before, of its logarithm where that is sought; None: nothing
    prior: tuple[float, float] | None = None

    def along(self, value: float) -> float:
        """The value, or its logarithm where that is sought."""
        return math.log(value) if self.logarithmic else value

    @property
    def width(self) -> float:
        """Length of the range along it."""
        return self.along(self.most) - self.along(self.least)

    def value(self, place: float) -> float:
        """The value at a place in the range, 0 to 1; beyond it, too."""
        along = self.along(self.least) + place * self.width
        return math.exp(along) if self.logarithmic else along

    def place(self, value: float) -> float:
        """Where in the range a value is."""
        return (self.along(value) - self.along(self.least)) / self.width

    def slope(self, value: float) -> float:
        """Change of the value with its place in the range."""
        return self.width * (value if self.logarithmic else 1.0)
