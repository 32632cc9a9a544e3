"""Readings of the wheels' forces between the output times, as part of a run's Dataset.

    readings of the core -> Recording -> [add_readings] -> variables over `reading_time`

They are what forces are filtered from: rollerrig.simulation.recording says why.
"""

from __future__ import annotations

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from rollerrig import _core
from rollerrig.assembly.model import AssembledModel
from rollerrig.results.dataset import Draft, variable

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
