"""Where the rows of a run go: all of them at the output times, and readings of the wheels' forces between.

    [core] -> Recording: rows at the output times, readings of a few quantities between

Wheel-rail forces hold vibrations of the wheels on their contacts at some hundred hertz. Taken every 5 or 10 ms they fold down
below 20 Hz, where no filter finds them any more; every millisecond they do not. Whole rows so often would fill the disk, so
that between output times only what is to be filtered at 20 Hz is kept.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from rollerrig.config import Case

Vector = NDArray[np.float64]

READING_STEP = 1e-3
"""Longest interval of the readings [s]: 50 in a period of 20 Hz."""

MOST_READINGS = 20
"""Per output time: a run of which so little is kept has no readings."""


def readings_per_sample(case: Case) -> int:
    """How many readings there are from one output time to the next; 1: none between.

    With actuators or controllers outputs are at multiples of the sampling step. On a scaled model all is as fast as its time.
    """
    output, scale = case.time.output_step, case.similitude.time if case.similitude else 1.0
    wanted = math.ceil(scale * output / READING_STEP * (1.0 - 1e-9))
    if wanted > MOST_READINGS:
        return 1
    if not case.sampled:
        return wanted
    steps = max(1, round(output / case.time.sampling_step))
    return next(count for count in range(1, steps + 1) if steps % count == 0 and count >= min(wanted, steps))


class Recording:
    """Room for the rows and readings of one run.

    Args:
        count: output times of the whole run.
        width: columns of a row.
        every: readings per output time.
        columns: of a reading.

    Attributes:
        times, rows: [s] and values at the output times; NaN and empty where the run has not come to.
        reading_times, readings: the same of the readings, none with `every` = 1.
    """

    def __init__(self, count: int, width: int, every: int, columns: int) -> None:
        self.every = every
        self.times, self.rows = np.full(count, np.nan), np.empty((count, width))
        between = (count - 1) * every + 1 if every > 1 else 0
        self.reading_times, self.readings = np.empty(between), np.empty((between, columns))

    @property
    def filled(self) -> int:
        """Rows that are there."""
        return int(np.count_nonzero(np.isfinite(self.times)))

    @staticmethod
    def size(count: int, width: int, every: int, columns: int) -> int:
        """Numbers that a recording holds."""
        return count * (width + 1) + (count * every * (columns + 1) if every > 1 else 0)
