"""Accelerations that passengers and bogies feel, at points of the bodies, and their weights.

    run -> [accelerations] -> at the centre of each body and over what carries it -> [ride] -> filtered, weighted

A point ρ of a rigid body with the centre's acceleration a_C, angular velocity ω and acceleration α is accelerated by

    a = a_C + α × ρ + ω × (ω × ρ)                                                  (R4)

and an accelerometer fixed to the body feels R^T (a + g e_z), of which the g at rest is taken off. Here ω, α come from the
rates of yaw, roll and pitch, R = R_z(ψ) R_x(φ) R_y(θ) of docs/conventions.md:

    ω = ψ' e_z + φ' e_1 + θ' e_2,   e_1 = R_z e_x,   e_2 = R_z R_x e_y
    α = ψ'' e_z + φ'' e_1 + θ'' e_2 + ψ' e_z × φ' e_1 + (ψ' e_z + φ' e_1) × θ' e_2

What the centre feels is recorded, in curves with the uncompensated part. There yaw counts from the direction of the track,
which turns itself at the rate κ V: ψ' and ψ'' are those of both. The turning of cant is left out, a thousandth of g.

Source: EN 14363:2016 for the points and bands; EN 12299:2009, annex C, and ISO 2631 for the weights.
"""

from __future__ import annotations

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from rollerrig.analysis.filters import band_pass, low_pass, sampling_rate
from rollerrig.results.run_info import RunInfo

Rows = NDArray[np.float64]

DIRECTIONS = ("lateral", "vertical")

RIDE_BAND = (0.4, 10.0)
"""Band pass of accelerations in the car body [Hz]."""

FRAME_CUTOFF = 10.0
"""Low pass of accelerations of a bogie frame [Hz]."""


def accelerations(run: xr.Dataset, *, floor_height: float | None = None) -> xr.Dataset:
    """Accelerations at the centre of every free body above the wheelsets, and over each body that carries it.

    A car body rests on frames, a frame by wheelsets: joined by elements that carry load, and higher.

    Args:
        run: results of `simulate` or `load_run`.
        floor_height: height above the rails of the points over what carries the car body [m]; None: where its springs
            act on it. On a frame the points lie as high as its centre.

    Returns:
        acceleration [m/s^2] over time, point and direction (lateral, vertical), unfiltered, as an accelerometer fixed to
        the body feels it: lateral with gravity's part in a roll, vertical less g at rest. The body of each point is the
        coordinate `of_body`, and `on_wheelsets` says whether wheelsets carry it. No points if all bodies above the
        wheelsets are fixed.
    """
    info = RunInfo.of(run)
    names, bodies, framed, rows = [], [], [], []
    for body in info.sprung:
        x, _, z = body.position
        on_wheelsets = any(info.body(below.body).role == "wheelset" for below in body.lower_bodies)
        motion = with_turning_track(run.sel(body=body.name), run, x)
        points = {f"{body.name}, centre": (0.0, 0.0, 0.0)}
        for below in body.lower_bodies:
            level = below.height if floor_height is None else floor_height
            arm = (info.body(below.body).position[0] - x, 0.0, 0.0 if on_wheelsets else level - z)
            points[f"{body.name} over {below.body}"] = arm
        for name, arm in points.items():
            names.append(name)
            bodies.append(body.name)
            framed.append(on_wheelsets)
            rows.append(_at_point(motion, np.array(arm), info.gravity))
    values = np.stack(rows, axis=1) if rows else np.zeros((run.sizes["time"], 0, len(DIRECTIONS)))
    coordinates = {
        "time": run["time"],
        "point": np.array(names, dtype=str),
        "direction": list(DIRECTIONS),
        "of_body": ("point", np.array(bodies, dtype=str)),
        "on_wheelsets": ("point", np.array(framed, dtype=bool)),
    }
    attributes = {"units": "m/s^2", "long_name": "acceleration"}
    return xr.Dataset(
        {"acceleration": (("time", "point", "direction"), values, attributes)},
        coordinates,
        {"title": run.attrs["title"], "case": run.attrs["case"]},
    )


def with_turning_track(motion: xr.Dataset, run: xr.Dataset, ahead: float) -> xr.Dataset:
    """The motion of a body with the yaw rate and acceleration of the track's direction under it added.

    Args:
        motion: the run at one body.
        run: the run; its curvature is that at the vehicle's reference point.
        ahead: how far the body is ahead of that point [m].
    """
    distance, time = run["distance"].to_numpy(), run["time"].to_numpy()
    if len(time) < 2 or not run["curvature"].any():
        return motion
    rate = run["speed"].to_numpy() * np.interp(distance + ahead, distance, run["curvature"].to_numpy())
    turning = {"yaw_rate": rate, "yaw_acceleration": np.gradient(rate, time)}
    return motion.assign(
        {name: (motion[name].dims, motion[name].to_numpy() + values) for name, values in turning.items()}
    )


def _at_point(motion: xr.Dataset, arm: Rows, gravity: float) -> Rows:
    """Specific force, lateral and vertical, less that of gravity, at a point fixed to a body (R4), shape (time, 2) [m/s^2]."""
    roll, pitch, yaw = (motion[name].to_numpy() for name in ("roll", "pitch", "yaw"))
    zero, one = np.zeros_like(roll), np.ones_like(roll)
    e_z = np.stack([zero, zero, one], axis=1)
    e_1 = np.stack([np.cos(yaw), np.sin(yaw), zero], axis=1)
    e_2 = np.stack([-np.sin(yaw) * np.cos(roll), np.cos(yaw) * np.cos(roll), np.sin(roll)], axis=1)
    forward = np.cos(pitch)[:, None] * e_1 - np.sin(pitch)[:, None] * np.cross(e_1, e_2)
    upward = np.cross(forward, e_2)  # the body's axes are forward, e_2, upward
    rho = arm[0] * forward + arm[1] * e_2 + arm[2] * upward

    def about(name: str, axis: Rows) -> Rows:
        return np.asarray(motion[name].to_numpy()[:, None] * axis)

    yawing, rolling = about("yaw_rate", e_z), about("roll_rate", e_1)
    pitching = about("pitch_rate", e_2)
    turn = yawing + rolling + pitching
    spin_up = about("yaw_acceleration", e_z) + about("roll_acceleration", e_1) + about("pitch_acceleration", e_2)
    spin_up += np.cross(yawing, rolling) + np.cross(yawing + rolling, pitching)
    relative = np.cross(spin_up, rho) + np.cross(turn, np.cross(turn, rho))
    at_centre = np.stack([motion[f"{direction}_specific_force"] for direction in DIRECTIONS], axis=1)
    body_axes = np.stack([e_2, upward], axis=1)  # (time, direction, 3)
    return np.asarray(at_centre - [0.0, gravity] + np.einsum("tdi,ti->td", body_axes, relative))


def ride(points: xr.Dataset) -> xr.Dataset:
    """The accelerations in the bands of EN 14363: frames below 10 Hz, the car body from 0.4 to 10 Hz.

    Args:
        points: what `accelerations` returns.

    Returns:
        The same, with what was done to each point as the coordinate `filter`.

    Raises:
        ValueError: the run's output_step is too coarse, or the run too short.
    """
    values = points["acceleration"]
    framed = points["on_wheelsets"].to_numpy()
    out = values.copy(deep=True)
    if framed.any():
        out[:, framed] = low_pass(values[:, framed], FRAME_CUTOFF)
    if (~framed).any():
        out[:, ~framed] = band_pass(values[:, ~framed], *RIDE_BAND)
    bands = np.where(framed, f"{FRAME_CUTOFF:g} Hz", "{:g} to {:g} Hz".format(*RIDE_BAND))
    return points.assign(acceleration=out).assign_coords(filter=("point", bands))


def weight(frequency: Rows, direction: str) -> Rows:
    """How strongly people feel an acceleration of a frequency: |W_d| of lateral, |W_b| of vertical ones, EN 12299.

    Args:
        frequency: [Hz], any shape.
        direction: "lateral" or "vertical".
    """
    s = 2j * np.pi * np.asarray(frequency, dtype=np.float64)

    def second_order(corner: float, quality: float) -> NDArray[np.complex128]:
        w = 2 * np.pi * corner
        return np.asarray(s * s + s * w / quality + w * w)

    def transition(zero: float, pole: float) -> NDArray[np.complex128]:
        return np.asarray((1 + s / (2 * np.pi * zero)) * (2 * np.pi * pole) ** 2 / second_order(pole, 0.63))

    band = s * s / second_order(0.4, 0.5**0.5) * (200 * np.pi) ** 2 / second_order(100.0, 0.5**0.5)
    if direction == "lateral":
        return np.abs(band * transition(2.0, 2.0))
    step = 0.4 * (4.0 / 2.5) ** 2 * second_order(2.5, 0.8) / second_order(4.0, 0.8)
    return np.abs(band * transition(16.0, 16.0) * step)


def weighted_rms(points: xr.Dataset) -> xr.DataArray:
    """Root mean square of the weighted accelerations (W_d lateral, W_b vertical), the run taken as periodic.

    Args:
        points: what `accelerations` returns, unfiltered.

    Returns:
        Over point and direction [m/s^2].

    Raises:
        ValueError: the run's output_step is too coarse, or the run too short.
    """
    values = points["acceleration"].transpose("time", "point", "direction")
    count, time = values.sizes["time"], points["time"].to_numpy()
    rate = min(sampling_rate(time, cutoff) for cutoff in RIDE_BAND)
    frequency: Rows = np.asarray(np.fft.rfftfreq(count, 1.0 / rate), dtype=np.float64)
    spectrum = np.abs(np.fft.rfft(values.to_numpy(), axis=0)) / count
    spectrum *= np.stack([weight(frequency, d) for d in DIRECTIONS], axis=1)[:, None, :]
    folded = np.where((frequency == 0) | (2 * np.arange(len(frequency)) == count), 1.0, 2.0)  # Parseval, half the lines
    power = np.einsum("f,fpd->pd", folded, spectrum**2)
    attributes = {"units": "m/s^2", "long_name": "weighted r.m.s. acceleration, EN 12299"}
    coordinates = {"point": points["point"], "direction": points["direction"]}
    return xr.DataArray(np.sqrt(power), coordinates, ["point", "direction"], attrs=attributes)
