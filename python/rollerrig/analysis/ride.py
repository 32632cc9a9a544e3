"""Accelerations that passengers and bogies feel, at points of the bodies, and their weights.

    run -> [accelerations] -> at the centre of each body and over what carries it -> [ride] -> filtered, weighted

A point ρ of a rigid body with the centre's acceleration a_C, angular velocity ω and acceleration α is accelerated by

    a = a_C + α × ρ + ω × (ω × ρ)                                                  (R4)

and an accelerometer fixed to the body feels R^T (a + g e_z), of which the g at rest is taken off. What the centre feels and
ω, α along the body's axes are recorded as sensors there would show them: in curves with the uncompensated part, and with the
turning of the track under the body, of its plan and of its cant (W11).

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
        motion = run.sel(body=body.name)
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


def _at_point(motion: xr.Dataset, arm: Rows, gravity: float) -> Rows:
    """Specific force, lateral and vertical, less that of gravity, at a point fixed to a body (R4), shape (time, 2) [m/s^2]."""
    turn, spin_up = (
        np.stack([motion[f"inertial_{axis}_{kind}"] for axis in ("roll", "pitch", "yaw")], axis=1)
        for kind in ("rate", "acceleration")
    )
    relative = np.cross(spin_up, arm) + np.cross(turn, np.cross(turn, arm))
    at_centre = np.stack([motion[f"{direction}_specific_force"] for direction in DIRECTIONS], axis=1)
    return np.asarray(at_centre - [0.0, gravity] + relative[:, 1:])


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
