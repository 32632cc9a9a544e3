"""Where the rows of a run go: all of them at the output times, and readings of the wheels' forces between.

    rows of the core at the reading step -> [Recording] -> rows at output times, a few columns of the others

Wheel-rail forces hold vibrations of the wheels on their contacts at some hundred hertz. Taken every 5 or 10 ms they fold down
below 20 Hz, where no filter finds them any more; every millisecond they do not. Whole rows so often would fill the disk, so
that between output times only what is to be filtered at 20 Hz is kept.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from rollerrig.config import Case

Vector = NDArray[np.float64]

READING_STEP = 1e-3
"""Longest interval of the readings [s]: 50 in a period of 20 Hz."""

MOST_READINGS = 20
"""Per output time: a run of which so little is kept has no readings."""

SLICE = 512
"""Rows kept before they are sorted."""


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
    """Rows and readings of one run.

    Args:
        count: output times of the whole run.
        width: columns of a row.
        every: readings per output time.
        columns: of a row, that make a reading.

    Attributes:
        times, rows: [s] and values at the output times; `filled` of them are there.
        reading_times, readings: the same of the readings; `read` of them.
        chunk_times, chunk: where the core writes next.
    """

    def __init__(self, count: int, width: int, every: int, columns: Sequence[int]) -> None:
        self.every, self.columns = every, list(columns)
        self.times, self.rows = np.full(count, np.nan), np.empty((count, width))
        self.filled = self.read = 0
        between = (count - 1) * every + 1 if every > 1 else 0
        self.reading_times, self.readings = np.empty(between), np.empty((between, len(self.columns)))
        self.chunk_times, self.chunk = (
            (np.full(SLICE, np.nan), np.empty((SLICE, width))) if every > 1 else (self.times, self.rows)
        )

    @staticmethod
    def size(count: int, width: int, every: int, columns: int) -> int:
        """Numbers that a recording holds."""
        return count * (width + 1) + (count * every * (columns + 1) + SLICE * (width + 1) if every > 1 else 0)

    def sort(self) -> int:
        """Take what the core has written since the last time; how many rows are left in the chunk."""
        written = int(np.count_nonzero(np.isfinite(self.chunk_times)))
        if self.every == 1:
            self.filled = written
            return written
        latest = self.reading_times[self.read - 1] if self.read else -math.inf
        taken = int(np.searchsorted(self.chunk_times[:written], latest, side="right"))  # before Ctrl-C cut this short
        end = min(written, taken + len(self.reading_times) - self.read)
        times, rows = self.chunk_times[taken:end], self.chunk[taken:end]
        here = slice(self.read, self.read + len(times))
        self.reading_times[here], self.readings[here] = times, rows[:, self.columns]
        whole = slice(-self.read % self.every, None, self.every)
        there = slice(self.filled, self.filled + len(times[whole]))
        self.times[there], self.rows[there] = times[whole], rows[whole]
        self.read, self.filled = here.stop, there.stop
        self.chunk_times[:] = np.nan
        return 0
