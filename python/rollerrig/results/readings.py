"""Readings of the wheels' forces between the output times: where they go during a run, and in its Dataset.

    [core] -> Recording: rows at the output times, readings of a few quantities between

Wheel-rail forces hold vibrations of the wheels on their contacts at some hundred hertz. Taken every 5 or 10 ms they fold down
below 20 Hz, where no filter finds them any more; every millisecond they do not. Whole rows so often would fill the disk, so
that between output times only what is to be filtered at 20 Hz is kept.

    readings of the core -> Recording -> [add_readings] -> variables over `reading_time`

They are what forces are filtered from: rollerrig.results.readings says why.
"""

from __future__ import annotations

import math

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from rollerrig import _core
from rollerrig.assembly.model import AssembledModel
from rollerrig.config import Case
from rollerrig.results.dataset import Draft, variable

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


PREFIX = "reading_"
DIMENSION = "reading_time"


def add_readings(draft: Draft, model: AssembledModel, times: NDArray[np.float64], values: NDArray[np.float64]) -> None:
    """Add the readings of a run; nothing where there are none.

    Args:
        draft: what `run_draft` returns; it is changed.
        model: the model that was run.
        times: of the readings [s], shape (reading_time,).
        values: `_core.reading_fields` of one wheel after the other, then the distance; shape (reading_time, columns).
    """
    if not len(times):
        return

    def attributes(name: str) -> dict[str, str]:
        _, _, own = draft.variables[name]
        return {"units": own["units"], "long_name": f"{own['long_name']}; between the output times"}

    fields = _core.reading_fields
    wheels = values[:, :-1].reshape(len(times), len(model.wheels), len(fields))
    for k, name in enumerate(fields):
        draft.variables[f"{PREFIX}{name}"] = ((DIMENSION, "wheel"), wheels[..., k], attributes(name))
    draft.variables[f"{PREFIX}distance"] = ((DIMENSION,), values[:, -1], attributes("distance"))
    draft.times[DIMENSION] = variable(DIMENSION, times, "s", "time of the readings between the outputs")


def readings_of(run: xr.Dataset) -> xr.Dataset | None:
    """The readings over `time`, without their prefix, as far as the run's output times reach; None: it has none."""
    if f"{PREFIX}distance" not in run or not run.sizes["time"]:
        return None
    names = {f"{PREFIX}{name}": name for name in (*_core.reading_fields, "distance")}
    first, last = float(run["time"][0]), float(run["time"][-1])
    kept = run[list(names)].drop_vars("time", errors="ignore").sel({DIMENSION: slice(first, last)})
    return kept.rename({**names, DIMENSION: "time"})
