"""A rig's run against the track's at the same times, where the phase of a limit cycle counts: for inspection, not for assessment.

runs of `simulate` with brake or traction -> [rig_fidelity] -> numbers; NaN or None where there are none

What two starts of the same test on track differ by, point by point, is phase alone; `slide_statistics` has what is compared.
Equations: docs/theory/rig_control.md.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from rollerrig.analysis.tracking import LEAST_SPEED, rms, slip, under_test, wheel_radius


def point_by_point(track: xr.Dataset, other: xr.Dataset) -> dict[str, Any]:
    """Another run, of the rig or of a second start, against the track's at the same times, as far as both ran.

    Of the axles under test.
    """
    count = min(track.sizes["time"], other.sizes["time"])
    a, b = (under_test(run).isel(time=slice(0, count)) for run in (track, other))
    speed = a["train_speed"].to_numpy()
    fast = speed > LEAST_SPEED
    difference = wheel_radius(other) * (b["axle_speed"].to_numpy() - a["axle_speed"].to_numpy())
    relative = difference[fast] / speed[fast, None]
    torque = sum(b[name].to_numpy() - a[name].to_numpy() for name in ("brake_torque", "traction_torque"))
    return {
        "wheel_speed_rms": rms(relative),
        "wheel_speed_largest": float(np.abs(relative).max(initial=0.0)),
        "train_speed_largest_mps": float(np.abs(b["train_speed"].to_numpy() - speed).max()),
        "slip_difference_rms": rms(slip(b).to_numpy() - slip(a).to_numpy()),
        "torque_difference_rms_nm": rms(np.asarray(torque)),
    }


def by_own_motion(run: xr.Dataset) -> float | None:
    """Part of the variance of the tracking error in proportion to the wheelsets' own motion along the track, (D14) [-]."""
    run = under_test(run)
    moving = run["train_speed"].to_numpy() > LEAST_SPEED
    error = (run["axle_speed"] - run["virtual_speed"]).to_numpy()[moving].ravel()
    own = run["longitudinal_velocity"].sel(body=list(run["axle"].to_numpy())).to_numpy()[moving].ravel()
    if not (error.size and float(np.std(error)) > 0.0 and float(np.std(own)) > 0.0):
        return None
    return float(np.corrcoef(error, own)[0, 1] ** 2)
