"""Wheel speeds of a test against the train: slip, tracking error of the rig, definitions common to all studies.

run of `simulate` with a train -> [tracking] -> series over time and axle, RMS and largest values

Equations: docs/theory/rig_control.md. A ratio to the speed of a train slower than LEAST_SPEED is not defined: NaN.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import xarray as xr

from rollerrig.results.run_info import RunInfo

LEAST_SPEED = 2.0
"""Below this a train is too slow for errors relative to its speed [m/s]."""


def wheel_radius(run: xr.Dataset) -> float:
    """Nominal radius of the wheels [m], of the run's own case."""
    return RunInfo.of(run).wheel_radius


def under_test(run: xr.Dataset) -> xr.Dataset:
    """The run with those axles alone that are wheelsets of the vehicle, on rollers or on track; the train may have others."""
    bodies = set(run["body"].to_numpy().tolist())
    names = run["axle"].to_numpy().tolist()
    tested = [name for name in names if name in bodies]
    return run if len(tested) == len(names) else run.sel(axle=tested)


def slip(run: xr.Dataset) -> xr.DataArray:
    """(wheel speed - train speed) / train speed, over time and axle [-]."""
    return _relative(run, wheel_radius(run) * run["axle_speed"] - run["train_speed"])


def virtual_slip(run: xr.Dataset) -> xr.DataArray:
    """The same of the virtual wheels of a rig."""
    return _relative(run, wheel_radius(run) * run["virtual_speed"] - run["train_speed"])


def tracking_error(run: xr.Dataset) -> xr.DataArray:
    """(wheel speed - virtual wheel speed) / train speed, over time and axle under test [-]."""
    run = under_test(run)
    return _relative(run, wheel_radius(run) * (run["axle_speed"] - run["virtual_speed"]))


def tracking(run: xr.Dataset) -> tuple[float, float]:
    """RMS and largest magnitude of the tracking error [-]; NaN if the train is never fast enough."""
    return rms(tracking_error(run)), largest(tracking_error(run))


def following(run: xr.Dataset) -> dict[str, float]:
    """How the wheels of a rig follow their virtual train and slide on their rollers, by names of the registry."""
    error, greatest = tracking(run)
    return {"tracking_rms": error, "tracking_largest": greatest, **real_sliding(run)}


def real_sliding(run: xr.Dataset) -> dict[str, float]:
    """Sliding of the wheels on rollers or rails, by names of the registry."""
    sliding = run["real_sliding"].to_numpy()
    return {"real_sliding_largest_mps": largest(sliding), "real_sliding_rms_mps": rms(sliding)}


def rms(values: Any) -> float:
    """Root mean square of what is finite; NaN if nothing is."""
    finite = np.asarray(values)[np.isfinite(values)]
    return float(np.sqrt(np.mean(finite**2))) if finite.size else math.nan


def largest(values: Any) -> float:
    """Largest magnitude of what is finite; NaN if nothing is."""
    finite = np.asarray(values)[np.isfinite(values)]
    return float(np.abs(finite).max()) if finite.size else math.nan


def stopped(run: xr.Dataset) -> bool:
    """Whether the train came to a stop."""
    return bool(run.attrs["status"] == "stopped")


def _relative(run: xr.Dataset, speed: xr.DataArray) -> xr.DataArray:
    train = run["train_speed"]
    return (speed / train).where(train > LEAST_SPEED)
