"""Which limit of the rig a run reached first, and when.

Dataset of a run -> [assess_limits] -> numbers, limits reached with their times, region of the operating envelope
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from rollerrig.analysis.rig_limits import FULL_SLIDING, RigLimits
from rollerrig.analysis.tracking import tracking, under_test, virtual_slip, wheel_radius
from rollerrig.config import Case
from rollerrig.results import COMPLETED

Mask = NDArray[np.bool_]
Record = dict[str, Any]

TRACKING_LIMIT = 0.01
"""Tracking error, RMS over train speed, up to which the rig reproduces the rail [-]."""

LEAST_DURATION = 0.03
"""A limit counts where it persists for at least this time; the corner of a ramp is shorter [s]."""

REGIONS: Mapping[str, str] = {
    "grip": "reproduced, wheels grip",
    "slide": "reproduced, wheels slide",
    "held": "reproduced, a brake holds a wheel",
    "drive_grip": "drive at its limit, wheels grip",
    "drive_slide": "drive at its limit, into the slide",
    "drive_recovery": "drive at its limit, out of the slide",
    "drive_power": "drive at its limit of power",
    "contact": "wheel slides on roller",
    "tracking": "no limit reached, tracking error above 1 %",
    "failed": "run failed",
}
"""Region of the operating envelope -> meaning."""

REPRODUCED = ("grip", "slide", "held")

NUMBERS = {
    "tracking_rms": ("1", "wheel less virtual wheel over train speed, RMS over time and axles"),
    "tracking_largest": ("1", "the same, largest"),
    "slip_largest": ("1", "largest slip of a virtual wheel"),
    "friction_used": ("1", "creep force over friction times normal force between wheel and roller, largest"),
    "real_sliding_mps": ("m/s", "wheel surface speed less that of the roller, largest"),
    "roller_torque_nm": ("N m", "largest torque of a roller drive"),
    "roller_power_w": ("W", "largest power of a roller drive"),
    "recovery_margin_nm": (
        "N m",
        "least torque on an axle that comes out of a slide, over what (V6) asks for; NaN: none does",
    ),
}
"""Number of a record -> unit and meaning."""


def assess_limits(run: xr.Dataset, case: Case, torque: float, grip_slip: float, rig: RigLimits | None = None) -> Record:
    """Numbers and limits of a run of the operating envelope.

    Args:
        run: of `simulate`.
        case: what was run.
        torque: on each axle, positive forward [N m].
        grip_slip: slip of a virtual wheel up to which it grips [-].
        rig: closed forms, for the margin of (V6); None: that is left out.

    Returns:
        `region` of REGIONS: the limit reached first, or the kind of run where there is none; `limits`: all that were reached,
        with their times [s]; the numbers of NUMBERS, None where not defined; `status` and `message` of the run.
    """
    slip = np.abs(virtual_slip(run).to_numpy())
    used = friction_used(run, case.contact.friction.mu_0)
    limits = {**_contact_limit(run, used), **_drive_limits(run, case, torque, slip > grip_slip)}
    rms, largest = tracking(run)
    slip_largest = float(np.nanmax(slip)) if np.isfinite(slip).any() else 0.0
    status, roller = str(run.attrs["status"]), np.abs(run["roller_torque"].to_numpy())
    kind = "held" if _held(run, case) else "slide" if slip_largest > grip_slip else "grip"
    return {
        "region": region(status, limits, rms, kind),
        "limits": dict(sorted(limits.items(), key=lambda item: item[1])),
        "tracking_rms": _finite(rms),
        "tracking_largest": _finite(largest),
        "slip_largest": slip_largest,
        "friction_used": float(used.max(initial=0.0)),
        "real_sliding_mps": float(np.abs(run["real_sliding"].to_numpy()).max(initial=0.0)),
        "roller_torque_nm": float(roller.max(initial=0.0)),
        "roller_power_w": float((roller * np.abs(run["roller_speed"].to_numpy())).max(initial=0.0)),
        "recovery_margin_nm": None if rig is None else _finite(_recovery_margin(run, torque, slip > grip_slip, rig)),
        "status": status,
        "message": "" if status in COMPLETED else str(run.attrs["status_message"]),
    }


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None


def failed(status: str, message: str) -> Record:
    """The record of a run that could not start."""
    return {"region": "failed", "limits": {}, **dict.fromkeys(NUMBERS), "status": status, "message": message}


def _held(run: xr.Dataset, case: Case) -> bool:
    """Whether a brake holds a wheel of the virtual train for LEAST_DURATION while that runs, (D15)."""
    control = case.rig_control
    assert control is not None
    rolling = wheel_radius(run) * np.abs(run["virtual_speed"].to_numpy())
    runs = run["train_speed"].to_numpy()[:, None] - rolling > control.locked_speed
    return persists_since(run["time"].to_numpy(), (rolling < control.locked_speed) & runs) is not None


def _recovery_margin(run: xr.Dataset, torque: float, sliding: Mask, rig: RigLimits) -> float:
    """Least torque over what (V6) asks for, on an axle whose virtual wheel slides and regains speed [N m]; NaN: none does."""
    time, speed = run["time"].to_numpy(), run["virtual_speed"].to_numpy()
    out = sliding & (-np.sign(torque) * np.gradient(speed, time, axis=0) > 0.0)
    acting = np.sign(torque) * (run["brake_torque"] + run["traction_torque"]).to_numpy()
    margin = acting - rig.recovery_at(np.abs(run["virtual_force"].to_numpy()))
    return float(margin[out].min()) if out.any() else math.nan


def region(status: str, limits: Mapping[str, float], tracking_rms: float, kind: str) -> str:
    """The region of a run: a key of REGIONS.

    Args:
        status: of the run.
        limits: those reached, and when [s].
        tracking_rms: error over train speed; NaN: not defined.
        kind: of the run where no limit is reached: one of REPRODUCED.
    """
    if status not in (*COMPLETED, "rollers_protected"):
        return "failed"
    if limits:
        return min(limits, key=lambda name: limits[name])
    if not tracking_rms < TRACKING_LIMIT:
        return "tracking"
    return kind


def persists_since(times: NDArray[np.float64], reached: Mask) -> float | None:
    """When a condition began that persisted for LEAST_DURATION or longer on any axle [s]; None: never.

    Args:
        times: shape (time,) [s].
        reached: shape (time, axle).
    """
    begins = []
    for column in reached.T:
        edges = np.flatnonzero(np.diff(np.concatenate(([False], column, [False])).astype(int)))
        begin, end = times[edges[::2]], times[edges[1::2] - 1]
        begins += begin[end - begin >= LEAST_DURATION * (1.0 - 1e-9)].tolist()
    return min(begins, default=None)


def friction_used(run: xr.Dataset, friction: float) -> NDArray[np.float64]:
    """Creep force over friction times normal force of both wheels of each axle under test, shape (time, axle)."""
    run = under_test(run)
    size = np.hypot(run["patch_creep_force_x"].to_numpy(), run["patch_creep_force_y"].to_numpy())
    per_axle = (run.sizes["time"], run.sizes["axle"], -1)
    force = np.nan_to_num(size).reshape(per_axle).sum(axis=2)
    normal = np.nan_to_num(run["patch_normal"].to_numpy()).reshape(per_axle).sum(axis=2)
    return np.asarray(force / np.maximum(friction * normal, 1.0))


def _contact_limit(run: xr.Dataset, used: NDArray[np.float64]) -> dict[str, float]:
    since = persists_since(run["time"].to_numpy(), used >= FULL_SLIDING)
    if since is None and run.attrs["status"] == "rollers_protected":
        since = float(run.attrs["stopped_at_s"])
    return {} if since is None else {"contact": since}


def _drive_limits(run: xr.Dataset, case: Case, torque: float, sliding: Mask) -> dict[str, float]:
    """Where the command is the largest torque of a roller drive, and what it is needed for."""
    control = case.rig_control
    assert control is not None
    command = run["roller_command"].to_numpy()
    largest = control.feedback.largest if control.is_ours else np.inf
    available = np.full(command.shape, largest)
    weaker = np.zeros(command.shape, dtype=bool)
    if control.motor.envelope is not None:
        speeds, torques = np.array(control.motor.envelope).T
        at_speed = np.interp(np.abs(run["roller_speed"].to_numpy()), speeds, torques)
        weaker = at_speed < min(largest, 0.999 * torques.max())
        available = np.minimum(available, at_speed)
    at_limit = np.abs(command) >= 0.999 * available
    into = command * np.sign(torque) > 0.0  # the drive helps the wheel in the direction of its torque
    masks = {
        "drive_power": at_limit & weaker,
        "drive_slide": at_limit & ~weaker & into,
        "drive_recovery": at_limit & ~weaker & ~into & sliding,
        "drive_grip": at_limit & ~weaker & ~into & ~sliding,
    }
    found = {name: persists_since(run["time"].to_numpy(), mask) for name, mask in masks.items()}
    return {name: since for name, since in found.items() if since is not None}
