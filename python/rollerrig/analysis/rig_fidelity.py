"""How well a rig reproduces a test on degraded track: measures of one run, and of a rig's run against the track's.

runs of `simulate` with brake or traction -> [rig_fidelity] -> numbers; NaN or None where there are none

Equations: docs/theory/rig_control.md.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr

from rollerrig.analysis.tracking import LEAST_SPEED, distances, largest, rms, slip, stopped, tracking, wheel_radius
from rollerrig.config import Case


def axle_load(run: xr.Dataset) -> float:
    """Static load of an axle, from the wheels' forces at the start [N]."""
    return float(run["vertical_force"].isel(time=0).sum()) / run.sizes["axle"]


def run_numbers(run: xr.Dataset) -> dict[str, Any]:
    """Measures of a run on track or rig."""
    acting = abs(run["brake_torque"]) + abs(run["traction_torque"]) > 1.0
    used = (abs(run["creep_force"]) / axle_load(run)).where(acting)
    slips, last = slip(run), run.isel(time=-1)
    return {
        "status": run.attrs["status"],
        "status_message": run.attrs["status_message"],
        "stopped": stopped(run),
        "distance_m": float(last["train_distance"]),
        "duration_s": float(run.attrs["stopped_at_s"]),
        "speed_end_kmh": 3.6 * float(last["train_speed"]),
        "largest_slip": largest(slips),
        "mean_slip": float(abs(slips).mean()),
        "adhesion_used_mean": float(used.mean()),
        "adhesion_used_largest": float(used.max()),
        "dump_cycles": int(last["dump_cycles"].sum()),
        "air_litres": 1e3 * float(last["air"].sum()),
        "energy_relative_residual": run.attrs["energy_relative_residual"],
    }


def rig_numbers(run: xr.Dataset, case: Case) -> dict[str, float]:
    """Measures of a run on the rig alone."""
    assert case.rig_control is not None
    sliding = run["real_sliding"].to_numpy()
    limited = (abs(run["roller_command"].to_numpy()) >= 0.999 * case.rig_control.feedback.largest).any(axis=1)
    return {
        "real_sliding_largest_mps": float(np.abs(sliding).max()),
        "real_sliding_rms_mps": rms(sliding),
        "roller_torque_largest_nm": float(np.abs(run["roller_torque"]).max()),
        "drive_limited_s": float(limited.mean()) * float(run["time"][-1]),
    }


def fidelity(track: xr.Dataset, rig: xr.Dataset) -> dict[str, float | None]:
    """Rig against its virtual train, and against the track at the same times, as far as both ran."""
    count = min(track.sizes["time"], rig.sizes["time"])
    a, b = (run.isel(time=slice(0, count)) for run in (track, rig))
    speed = a["train_speed"].to_numpy()
    fast = speed > LEAST_SPEED
    relative = (wheel_radius(rig) * (b["axle_speed"].to_numpy() - a["axle_speed"].to_numpy()))[fast] / speed[fast, None]
    torque = sum(b[name].to_numpy() - a[name].to_numpy() for name in ("brake_torque", "traction_torque"))
    at_end = [float(run["train_distance"][-1]) for run in (a, b)]
    ends = [float(run["train_distance"][-1]) for run in (track, rig)]
    error, greatest = tracking(rig)
    return {
        "tracking_rms": error,
        "tracking_largest": greatest,
        "tracking_by_own_motion": by_own_motion(rig),
        "wheel_speed_rms": rms(relative),
        "wheel_speed_largest": float(np.abs(relative).max(initial=0.0)),
        "train_speed_largest_mps": float(np.abs(b["train_speed"].to_numpy() - speed).max()),
        "distance_relative": ends[1] / ends[0] - 1.0 if stopped(track) and stopped(rig) else None,
        "distance_at_end_relative": at_end[1] / at_end[0] - 1.0 if at_end[0] > 0 else None,
        "slip_difference_rms": rms(slip(b).to_numpy() - slip(a).to_numpy()),
        "torque_difference_rms_nm": rms(np.asarray(torque)),
    }


def by_own_motion(run: xr.Dataset) -> float | None:
    """Part of the variance of the tracking error in proportion to the wheelsets' own motion along the track, (D14) [-]."""
    moving = run["train_speed"].to_numpy() > LEAST_SPEED
    error = (run["axle_speed"] - run["virtual_speed"]).to_numpy()[moving].ravel()
    own = run["longitudinal_velocity"].sel(body=list(run["axle"].to_numpy())).to_numpy()[moving].ravel()
    if not (error.size and float(np.std(error)) > 0.0 and float(np.std(own)) > 0.0):
        return None
    return float(np.corrcoef(error, own)[0, 1] ** 2)


def variant_numbers(track: xr.Dataset, run: xr.Dataset) -> dict[str, Any]:
    """Measures of a variant of the rig, its distance relative to the track's."""
    on_track, own = distances([track, run])
    numbers = run_numbers(run)
    kept = {name: numbers[name] for name in ("dump_cycles", "mean_slip")}
    return {"tracking_rms": tracking(run)[0], "distance_relative": own / on_track - 1.0, **kept}


def error_budget(
    track: xr.Dataset, rig: xr.Dataset, variants: Mapping[str, xr.Dataset], steps: Sequence[str]
) -> dict[str, float] | None:
    """Parts of (distance of the rig over that of the track, less 1) by imperfection, the rest as 'model'; they add up to it.

    Args:
        track: run on track.
        rig: run on the rig as it is.
        variants: by name, runs of the rig with one imperfection after the other taken away.
        steps: their names in that order.

    Returns:
        Name of the imperfection -> part [-]; None where a variant is missing.
    """
    if any(name not in variants for name in steps):
        return None
    on_track, *found = distances([track, rig, *(variants[name] for name in steps)])
    pairs = zip((*steps, "model"), found, [*found[1:], on_track], strict=True)
    return {name: (before - after) / on_track for name, before, after in pairs}
