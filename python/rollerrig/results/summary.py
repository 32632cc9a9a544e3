"""The numbers of a run, each under a documented key: what goes into summary.json."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

SUMMARY_KEYS = {
    "case": "name of the case",
    "status": "'ok', 'interrupted', or why the run stopped",
    "status_message": "the same as a sentence, with time, wheel and remedy",
    "stopped_at_s": "time that the integration reached [s]",
    "stopped_wheel": "wheel at which the run stopped, empty if none",
    "stopped_at_m": "distance at the last output time [m]",
    "stopped_segment": "segment of the track there, empty if it has none",
    "stopped_quotient": "largest |Y| / Q of the wheelset that stopped the run in the half second before [-]; null if none did",
    "stopped_quotient_wheel": "wheel that had it, empty if none",
    "samples": "number of output times",
    "speed_start_kmh": "running speed at the first output time [km/h]",
    "speed_end_kmh": "running speed at the last output time [km/h]",
    "energy_turned_over_j": "half the sum of the total variations of all energy accounts [J]",
    "energy_relative_residual": "largest energy residual over the energy turned over [-]",
    "warnings": "what to know before believing the run, one line each; empty if nothing",
    "bodies": "per body of the vehicle, the numbers below",
    "bodies.*.lateral_largest_mm": "largest lateral displacement, either side [mm]",
    "bodies.*.lateral_end_mm": "lateral displacement at the last output time [mm]",
    "bodies.*.lateral_last_tenth_mm": "largest lateral displacement in the last tenth of the output times [mm]",
    "bodies.*.yaw_largest_mrad": "largest yaw angle, either side [mrad]",
    "wheels": "per wheel, the numbers below",
    "wheels.*.vertical_force_start_n": "vertical contact force Q at the first output time [N]",
    "wheels.*.vertical_force_end_n": "vertical contact force Q at the last output time [N]",
    "wheels.*.vertical_force_least_n": "smallest vertical contact force Q [N]",
    "wheels.*.lateral_force_largest_n": "largest lateral contact force |Y| [N]",
    "wheels.*.derailment_quotient_largest": "largest |Y| / Q while Q > 0 [-]",
    "wheels.*.longitudinal_sliding_largest_mps": "largest longitudinal sliding speed [m/s]",
    "wheels.*.longitudinal_sliding_end_mps": "longitudinal sliding speed at the last output time [m/s]",
    "wheels.*.samples_with_several_patches": "output times at which the wheel touched in more than one patch",
    "solver": "counts of the integrator: steps, rejected steps, evaluations, smallest and largest step [s]",
    "contact": "counts of the contact model over all accepted steps and wheels",
    "rollerrig_version": "version of this program",
}
"""Key -> meaning and unit; `*` stands for the name of a body or wheel."""


def summarise(run: xr.Dataset) -> dict[str, Any]:
    """The numbers of a run under the keys of SUMMARY_KEYS; None where a number does not exist.

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
        "bodies": {body: _body(run.sel(body=body)) for body in json.loads(attributes["vehicle_bodies"])},
        "wheels": {str(wheel): _wheel(run.sel(wheel=wheel)) for wheel in run["wheel"].to_numpy()},
        "solver": json.loads(attributes["solver_statistics"]),
        "contact": json.loads(attributes["contact_counters"]),
        "rollerrig_version": attributes["rollerrig_version"],
    }


def _body(run: xr.Dataset) -> dict[str, float | None]:
    lateral = 1e3 * run["lateral"].to_numpy()
    tail = lateral[-max(1, len(lateral) // 10) :]
    return {
        "lateral_largest_mm": _largest(lateral),
        "lateral_end_mm": _number(lateral[-1:]),
        "lateral_last_tenth_mm": _largest(tail),
        "yaw_largest_mrad": _largest(1e3 * run["yaw"].to_numpy()),
    }


def _wheel(run: xr.Dataset) -> dict[str, float | int | None]:
    q, y = run["vertical_force"].to_numpy(), run["lateral_force"].to_numpy()
    loaded = q > 0
    sliding = run["longitudinal_sliding"].to_numpy()
    return {
        "vertical_force_start_n": _number(q[:1]),
        "vertical_force_end_n": _number(q[-1:]),
        "vertical_force_least_n": _least(q),
        "lateral_force_largest_n": _largest(y),
        "derailment_quotient_largest": _largest(y[loaded] / q[loaded]),
        "longitudinal_sliding_largest_mps": _largest(sliding),
        "longitudinal_sliding_end_mps": _number(sliding[-1:]),
        "samples_with_several_patches": int(np.count_nonzero(run["patch_count"].to_numpy() > 1)),
    }


Numbers = NDArray[np.float64]


def _largest(values: Numbers) -> float | None:
    finite = np.abs(values[np.isfinite(values)])
    return float(finite.max()) if finite.size else None


def _least(values: Numbers) -> float | None:
    finite = values[np.isfinite(values)]
    return float(finite.min()) if finite.size else None


def _number(value: Numbers) -> float | None:
    """The only element; an interrupted run may have none, an unloaded wheel has NaN."""
    return float(value[0]) if value.size and np.isfinite(value[0]) else None
