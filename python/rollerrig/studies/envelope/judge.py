"""What limited a run, and when.

run of a point -> [judge] -> numbers, limits met with their times, region
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from rollerrig.bench import ROLLERS_PROTECTED
from rollerrig.config import Case
from rollerrig.studies.output import finite

Mask = NDArray[np.bool_]
Record = dict[str, Any]

LEAST_SPEED = 2.0
"""Below this a train is too slow for errors relative to its speed [m/s]."""

FINE = 0.01
"""Tracking error, RMS of train speed, up to which a rig reproduces."""

FULL = 0.98
"""Part of the friction between wheel and roller from which the wheel as good as slides."""

HELD = 0.03
"""A limit counts where it is met for so long [s]: the corner of a ramp is none."""

REGIONS: Mapping[str, str] = {
    "grip": "reproduced, wheels grip",
    "slide": "reproduced, wheels slide",
    "drive_grip": "drive at its limit, wheels grip",
    "drive_slide": "drive at its limit, into the slide",
    "drive_recovery": "drive at its limit, out of the slide",
    "drive_power": "drive at its limit of power",
    "contact": "wheel slides on roller",
    "slow": "no limit met, error above 1 %",
    "failed": "run failed",
}
"""Region of the map -> meaning."""

IMITATED = ("grip", "slide")


def judge(run: xr.Dataset, case: Case, torque: float, grips: float) -> Record:
    """Numbers and limits of a run of a point.

    Args:
        run: of `simulate`.
        case: of the point.
        torque: on each axle, positive forward [N m].
        grips: slip of a virtual wheel up to which it grips [-].

    Returns:
        `region` of REGIONS: the limit first met, or what is left where there was none; `limits`, all that were met with
        their times [s]; numbers without a unit in their names are ratios. None: not known.
    """
    slip, error = _slip_and_error(run, case)
    used = friction_used(run, case.contact.friction)
    limits = {**_contact_limit(run, used), **_drive_limits(run, case, torque, np.abs(slip) > grips)}
    rms = float(np.sqrt(np.nanmean(error**2))) if np.isfinite(error).any() else np.nan
    slid = float(np.nanmax(np.abs(slip))) if np.isfinite(slip).any() else 0.0
    status = str(run.attrs["status"])
    roller = np.abs(run["roller_torque"].to_numpy())
    return {
        "region": region(status, limits, rms, slid > grips),
        "limits": dict(sorted(limits.items(), key=lambda item: item[1])),
        "tracking_rms": finite(rms),
        "tracking_largest": finite(float(np.nanmax(np.abs(error)))) if np.isfinite(error).any() else None,
        "slip_largest": slid,
        "friction_used": float(used.max(initial=0.0)),
        "real_sliding_mps": float(np.abs(run["real_sliding"].to_numpy()).max(initial=0.0)),
        "roller_torque_nm": float(roller.max(initial=0.0)),
        "roller_power_w": float((roller * np.abs(run["roller_speed"].to_numpy())).max(initial=0.0)),
        "status": status,
        "message": "" if status == "ok" else str(run.attrs["status_message"]),
    }


def failed(status: str, message: str) -> Record:
    """The record of a run that never began."""
    numbers = ("tracking_rms", "tracking_largest", "slip_largest", "friction_used", "real_sliding_mps")
    absent = dict.fromkeys((*numbers, "roller_torque_nm", "roller_power_w"))
    return {"region": "failed", "limits": {}, **absent, "status": status, "message": message}


def region(status: str, limits: Mapping[str, float], tracking_rms: float, slides: bool) -> str:
    """The region of a run: a key of REGIONS.

    Args:
        status: of the run.
        limits: those met, and when [s].
        tracking_rms: error over train speed; NaN: not known.
        slides: whether a virtual wheel does.
    """
    if status not in ("ok", ROLLERS_PROTECTED):
        return "failed"
    if limits:
        return min(limits, key=lambda name: limits[name])
    if not tracking_rms < FINE:
        return "slow"
    return "slide" if slides else "grip"


def held_since(times: NDArray[np.float64], met: Mask) -> float | None:
    """When a condition began that then held for HELD or longer on any axle [s]; None: it did not.

    Args:
        times: shape (time,) [s].
        met: shape (time, axle).
    """
    first: float | None = None
    for column in met.T:
        edges = np.flatnonzero(np.diff(np.concatenate(([False], column, [False])).astype(int)))
        for begin, end in zip(edges[::2], edges[1::2], strict=True):
            if times[end - 1] - times[begin] >= HELD * (1.0 - 1e-9):
                first = float(times[begin]) if first is None else min(first, float(times[begin]))
                break
    return first


def _slip_and_error(run: xr.Dataset, case: Case) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Slip of the virtual wheels, and wheel less virtual wheel, both over train speed; NaN where the train is slow."""
    radius, speed = case.vehicle.data.wheel.radius, run["train_speed"].to_numpy()[:, None]
    speed = np.where(speed > LEAST_SPEED, speed, np.nan)
    virtual = radius * run["virtual_speed"].to_numpy()
    return virtual / speed - 1.0, (radius * run["axle_speed"].to_numpy() - virtual) / speed


def friction_used(run: xr.Dataset, friction: float) -> NDArray[np.float64]:
    """Creep force over friction times normal force of both wheels of each axle, shape (time, axle)."""
    size = np.hypot(run["patch_creep_force_x"].to_numpy(), run["patch_creep_force_y"].to_numpy())
    per_axle = (run.sizes["time"], run.sizes["axle"], -1)
    force = np.nan_to_num(size).reshape(per_axle).sum(axis=2)
    normal = np.nan_to_num(run["patch_normal"].to_numpy()).reshape(per_axle).sum(axis=2)
    return np.asarray(force / np.maximum(friction * normal, 1.0))


def _contact_limit(run: xr.Dataset, used: NDArray[np.float64]) -> dict[str, float]:
    times = run["time"].to_numpy()
    since = held_since(times, used >= FULL)
    if run.attrs["status"] == ROLLERS_PROTECTED:
        ended = float(run.attrs["stopped_at_s"])
        since = ended if since is None else since
    return {} if since is None else {"contact": since}


def _drive_limits(run: xr.Dataset, case: Case, torque: float, sliding: Mask) -> dict[str, float]:
    """Where the command is all that a roller's drive gives: what it was needed for."""
    control = case.rig_control
    assert control is not None
    command = run["roller_command"].to_numpy()
    most = np.inf if control.user is not None else control.feedback.largest
    can = np.full(command.shape, most)
    weaker = np.zeros(command.shape, dtype=bool)
    if control.motor.envelope is not None:
        speeds, torques = np.array(control.motor.envelope).T
        at_speed = np.interp(np.abs(run["roller_speed"].to_numpy()), speeds, torques)
        weaker = at_speed < min(most, 0.999 * torques.max())
        can = np.minimum(can, at_speed)
    at_limit = np.abs(command) >= 0.999 * can
    into = command * np.sign(torque) > 0.0  # the wheel is helped the way that its torque pushes it
    masks = {
        "drive_power": at_limit & weaker,
        "drive_slide": at_limit & ~weaker & into,
        "drive_recovery": at_limit & ~weaker & ~into & sliding,
        "drive_grip": at_limit & ~weaker & ~into & ~sliding,
    }
    found = {name: held_since(run["time"].to_numpy(), mask) for name, mask in masks.items()}
    return {name: since for name, since in found.items() if since is not None}
