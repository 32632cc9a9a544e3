"""The numbers of a run, as they go into summary.json; meanings and units are registered in study/run.py."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from rollerrig.results.contact_loss import ContactLoss, contact_losses
from rollerrig.results.readings import readings_of
from rollerrig.results.resolution import resolved
from rollerrig.results.run_info import RunInfo

Numbers = NDArray[np.float64]


def summarise(run: xr.Dataset) -> dict[str, Any]:
    """The numbers of a run by name; None where a number does not exist.

    Args:
        run: results of `simulate`.
    """
    attributes = run.attrs
    speed = 3.6 * run["speed"].to_numpy()
    return {
        **{key: attributes[key] for key in ("case", "status", "status_message", "stopped_at_s", "stopped_wheel")},
        **{key: attributes[key] for key in ("stopped_at_m", "stopped_segment", "stopped_quotient_wheel")},
        "stopped_quotient": _number(np.array([attributes["stopped_quotient"]])),
        "samples": run.sizes["time"],
        "speed_start_kmh": _number(speed[:1]),
        "speed_end_kmh": _number(speed[-1:]),
        "energy_turned_over_j": attributes["energy_turned_over_j"],
        "energy_relative_residual": attributes["energy_relative_residual"],
        "warnings": attributes["warnings"],
        "bodies": {body: _body(run.sel(body=body)) for body in RunInfo.of(run).moving},
        "wheels": _wheels(run),
        "solver": json.loads(attributes["solver_statistics"]),
        "contact": json.loads(attributes["contact_counters"]),
        "rollerrig_version": attributes["rollerrig_version"],
    }


def _body(run: xr.Dataset) -> dict[str, float | None]:
    lateral = 1e3 * _resolved(run["lateral"])
    tail = lateral[-max(1, len(lateral) // 10) :]
    return {
        "lateral_largest_mm": _largest(lateral),
        "lateral_end_mm": _number(lateral[-1:]),
        "lateral_last_tenth_mm": _largest(tail),
        "yaw_largest_mrad": _largest(1e3 * _resolved(run["yaw"])),
    }


def _wheels(run: xr.Dataset) -> dict[str, dict[str, float | int | None]]:
    """Forces as they were computed, at every reading; what is assessed goes through filters first."""
    readings = readings_of(run)
    dense = run if readings is None else readings
    lost = {loss.wheel: loss for loss in contact_losses(run)}
    return {
        wheel: _wheel(run.sel(wheel=wheel), dense.sel(wheel=wheel), lost.get(wheel))
        for wheel in map(str, run["wheel"].to_numpy())
    }


def _wheel(run: xr.Dataset, dense: xr.Dataset, loss: ContactLoss | None) -> dict[str, float | int | None]:
    q, y = dense["vertical_force"].to_numpy(), _resolved(dense["lateral_force"])
    loaded = q > 0
    sliding = _resolved(run["longitudinal_sliding"])
    return {
        "vertical_force_start_n": _number(q[:1]),
        "vertical_force_end_n": _number(q[-1:]),
        "vertical_force_least_raw_n": _least(q),
        "lateral_force_largest_raw_n": _largest(y),
        "derailment_quotient_largest_raw": _largest(y[loaded] / q[loaded]),
        "longitudinal_sliding_largest_mps": _largest(sliding),
        "longitudinal_sliding_end_mps": _number(sliding[-1:]),
        "samples_with_several_patches": int(np.count_nonzero(run["patch_count"].to_numpy() > 1)),
        "without_contact_s": loss.total_s if loss else 0.0,
        "without_contact_longest_s": loss.longest_s if loss else 0.0,
    }


def _resolved(signal: xr.DataArray) -> Numbers:
    return resolved(signal, str(signal.attrs["units"]))


def _largest(values: Numbers) -> float | None:
    finite = np.abs(values[np.isfinite(values)])
    return float(finite.max()) if finite.size else None


def _least(values: Numbers) -> float | None:
    finite = values[np.isfinite(values)]
    return float(finite.min()) if finite.size else None


def _number(value: Numbers) -> float | None:
    """The only element; an interrupted run may have none, an unloaded wheel has NaN."""
    return float(value[0]) if value.size and np.isfinite(value[0]) else None
