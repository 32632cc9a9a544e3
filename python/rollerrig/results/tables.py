"""Tables of a run: one row per output time, units in the column names."""

from __future__ import annotations

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from rollerrig.results.run_info import RunInfo

MOTION = ("longitudinal", "lateral", "vertical", "roll", "pitch", "yaw")
WHEEL = (
    "normal_force",
    "longitudinal_force",
    "longitudinal_creep_force",
    "lateral_force",
    "vertical_force",
    "longitudinal_sliding",
    "lateral_sliding",
    "contact_abscissa",
    "patch_count",
)
_UNIT_SUFFIX = {"m": "_m", "rad": "_rad", "m/s": "_mps", "N": "_n", "1": "", "s": "_s"}

Table = tuple[list[str], NDArray[np.float64]]
"""Column names and rows."""


def motion_table(run: xr.Dataset) -> Table:
    """Displacements and angles of the vehicle's bodies over time, and the running speed."""
    bodies = RunInfo.of(run).moving
    columns = {"time_s": run["time"], "speed_mps": run["speed"]}
    for body in bodies:
        for name in MOTION:
            columns[f"{body}.{name}{_suffix(run[name])}"] = run[name].sel(body=body)
    return _table(columns)


def wheel_table(run: xr.Dataset) -> Table:
    """Contact forces, sliding and position on the profile of each wheel over time."""
    columns = {"time_s": run["time"]}
    for wheel in run["wheel"].to_numpy():
        for name in WHEEL:
            columns[f"{wheel}.{name}{_suffix(run[name])}"] = run[name].sel(wheel=wheel)
    return _table(columns)


def _suffix(variable: xr.DataArray) -> str:
    return _UNIT_SUFFIX[str(variable.attrs["units"])]


def _table(columns: dict[str, xr.DataArray]) -> Table:
    return list(columns), np.column_stack([column.to_numpy() for column in columns.values()])
