"""Readings of the wheels' forces between the output times, as part of a run's Dataset.

    rows of the core -> [reading_columns] -> Recording -> [add_readings] -> variables over `reading_time`

They are what forces are filtered from: rollerrig.recording says why.
"""

from __future__ import annotations

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from rollerrig import _core
from rollerrig.assembly import AssembledModel
from rollerrig.results.dataset import Draft, variable

OF_WHEELS = ("lateral_force", "vertical_force", "wear_number")
"""Columns of each wheel that are read between."""

PREFIX = "reading_"
DIMENSION = "reading_time"


def reading_columns(model: AssembledModel) -> list[int]:
    """Columns of a row: OF_WHEELS of one wheel after the other, then the distance."""
    fields = [name for name, _, _ in _core.wheel_fields]
    first = len(model.bodies) * len(_core.body_fields)
    of_wheels = [
        first + wheel * len(fields) + fields.index(name) for wheel in range(len(model.wheels)) for name in OF_WHEELS
    ]
    patches = len(model.wheels) * _core.patches_recorded * len(_core.patch_fields)
    of_run = first + len(model.wheels) * len(fields) + patches + len(model.elements) * len(_core.element_fields)
    return [*of_wheels, of_run + [name for name, _, _ in _core.run_fields].index("distance")]


def add_readings(draft: Draft, model: AssembledModel, times: NDArray[np.float64], values: NDArray[np.float64]) -> None:
    """Add the readings of a run; nothing where there are none.

    Args:
        draft: what `run_draft` returns; it is changed.
        model: the model that was run.
        times: of the readings [s], shape (reading_time,).
        values: columns of `reading_columns`, shape (reading_time, columns).
    """
    if not len(times):
        return

    def attributes(name: str) -> dict[str, str]:
        _, _, own = draft.variables[name]
        return {"units": own["units"], "long_name": f"{own['long_name']}; between the output times"}

    wheels = values[:, :-1].reshape(len(times), len(model.wheels), len(OF_WHEELS))
    for k, name in enumerate(OF_WHEELS):
        draft.variables[f"{PREFIX}{name}"] = ((DIMENSION, "wheel"), wheels[..., k], attributes(name))
    draft.variables[f"{PREFIX}distance"] = ((DIMENSION,), values[:, -1], attributes("distance"))
    draft.times[DIMENSION] = variable(DIMENSION, times, "s", "time of the readings between the outputs")


def readings_of(run: xr.Dataset) -> xr.Dataset | None:
    """The readings over `time`, without their prefix, as far as the run's output times reach; None: it has none."""
    if f"{PREFIX}distance" not in run or not run.sizes["time"]:
        return None
    names = {f"{PREFIX}{name}": name for name in (*OF_WHEELS, "distance")}
    first, last = float(run["time"][0]), float(run["time"][-1])
    kept = run[list(names)].drop_vars("time", errors="ignore").sel({DIMENSION: slice(first, last)})
    return kept.rename({**names, DIMENSION: "time"})
