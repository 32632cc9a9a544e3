"""A scaled model's run, mapped back to full scale, against the run at full scale.

run at full scale -> [run_numbers];  run at full scale, run of the model mapped back -> [fidelity] -> differences at the same time
"""

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr

from rollerrig.analysis.critical_speed import scan_linear
from rollerrig.analysis.slide_statistics import largest, rms, slip, stopped, tracking, wheel_radius
from rollerrig.cases import at_speed
from rollerrig.config import Case
from rollerrig.results import RunInfo
from rollerrig.similitude import factors_of

SPEEDS = tuple(v / 3.6 for v in range(40, 521, 40))
"""Full-scale speeds among which the linear critical speed is looked for [m/s]."""

COMPARED = ("lateral", "axle_speed", "train_speed", "train_distance")  # variables that are compared at the same time


def linear_critical_speed_at_full_scale(case: Case) -> float:
    """Critical speed with speed-controlled rollers [m/s]; NaN if there is none within SPEEDS."""
    factor = factors_of(case).factor("m/s") if case.similitude is not None else 1.0
    steady = at_speed(case).with_changes({"axle_torque": []})
    return scan_linear(steady, [3.6 * v / factor for v in SPEEDS]).speed_kmh / 3.6 * factor


def run_numbers(run: xr.Dataset) -> dict[str, Any]:
    """Numbers of one run at full scale, NaN where not defined; of a run without a train the first five."""
    found: dict[str, Any] = {
        "status": run.attrs["status"],
        "status_message": run.attrs["status_message"],
        "duration_s": float(run.attrs["stopped_at_s"]),
        "wheel_load_n": float(run["normal_force"].isel(time=0).mean()),
        "lateral_largest_m": float(np.abs(wheelsets_lateral(run)).max()),
    }
    if "train_speed" not in run:
        return found
    last, follows = run.isel(time=-1), float(np.abs(run["virtual_speed"]).max()) > 0
    return found | {
        "stopped": stopped(run),
        "distance_m": float(last["train_distance"]),
        "speed_end_kmh": 3.6 * float(last["train_speed"]),
        "wheel_slip_largest": largest(slip(run)),
        "tracking_rms": tracking(run)[0] if follows else None,
        "real_sliding_largest_mps": float(np.abs(run["real_sliding"]).max()),
        "axle_torque_largest_nm": float(np.abs(axle_torque(run)).max()),
        "dump_cycles": int(last["dump_cycles"].sum()),
    }


def fidelity(full: xr.Dataset, mapped: xr.Dataset) -> dict[str, float]:
    """The model less full scale at the same times, as far as both ran; NaN where not defined."""
    other = at_times_of(full, mapped)
    same = full.isel(time=slice(0, other.sizes["time"]))
    found = {"lateral_rms_m": rms(wheelsets_lateral(other) - wheelsets_lateral(same))}
    if "train_speed" not in full:
        return found
    speed = same["train_speed"]
    difference = wheel_radius(full) * (other["axle_speed"] - same["axle_speed"]) / float(speed.max())
    ends = (mapped, full) if stopped(mapped) and stopped(full) else (other, same)
    distance, at_full_scale = (float(run["train_distance"][-1]) for run in ends)
    return found | {
        "wheel_speed_rms": rms(difference),
        "wheel_speed_largest": largest(difference),
        "train_speed_largest_mps": float(np.abs(other["train_speed"] - speed).max()),
        "distance_relative": distance / at_full_scale - 1.0 if at_full_scale > 0.0 else float("nan"),
    }


def at_times_of(full: xr.Dataset, other: xr.Dataset) -> xr.Dataset:
    """Another run at the times of the first, as far as both ran, interpolated."""
    end = float(other["time"][-1])
    times = full["time"].to_numpy()
    times = times[times <= end * (1 + 1e-12)]
    found = other[[name for name in COMPARED if name in other]].interp(time=np.minimum(times, end), assume_sorted=True)
    return found.assign_coords(time=times)  # else the last one, round-off apart, would find no partner


def wheelsets_lateral(run: xr.Dataset) -> xr.DataArray:
    """Lateral displacement of the wheelsets [m], over time and body."""
    names = [str(name) for name in run["body"].to_numpy() if str(name).startswith("wheelset")]
    return run["lateral"].sel(body=names)


def motor_limited(model: Case, mapped: xr.Dataset) -> float | None:
    """Part of the time in which the brake's or the demanded torque is beyond the motors of a model [-]; None: no limit.

    `mapped` is its run at full scale.
    """
    if model.traction is None or model.traction.motor.envelope is None or "brake_torque" not in mapped:
        return None
    factors = factors_of(model)
    speeds, torques = np.array(model.traction.motor.envelope).T
    limit = factors.factor("N m") * np.interp(np.abs(mapped["axle_speed"]) / factors.factor("rad/s"), speeds, torques)
    demanded = mapped["torque_factor"] * mapped["traction_demand"]
    if RunInfo.of(mapped).motors_reproduce_brakes:
        demanded = demanded + mapped["brake_torque"]
    return float((np.abs(demanded) > limit * (1 + 1e-9)).mean())


def axle_torque(run: xr.Dataset) -> xr.DataArray:
    """Torque of brake and motor on each axle, positive forward [N m]."""
    by_motors = RunInfo.of(run).motors_reproduce_brakes  # then the motor's torque holds the brake's
    return run["traction_torque"] if by_motors else run["brake_torque"] + run["traction_torque"]


def relative(values: Mapping[str, float], name: str) -> float:
    """A value over that at full scale, less 1; NaN where one is missing."""
    return values.get(name, np.nan) / values.get("full", np.nan) - 1.0
