"""Mode shapes: outlines of the bodies, displaced as the mode displaces them; dimensions of the outlines are schematic."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from rollerrig.plot.into import into_axes
from rollerrig.plot.style import COLOURS, GREY, house_style, new_grid

Points = NDArray[np.float64]

VIEWS = {"plan": (0, 1), "side": (0, 2), "end": (1, 2)}
"""View -> the axes it shows."""

AXES = ("x", "y", "z")
REACH = {"plan": 0.5, "side": 0.5, "end": 0.35}
"""Largest displacement drawn in each view [m]."""

HALF_GAUGE, WHEEL_RADIUS = 0.75, 0.46


@into_axes
def mode_shape(modes: xr.Dataset, name: str = "", speed_kmh: float = math.nan) -> Figure:
    """One mode from above and from behind, now and a quarter of a period later.

    Args:
        modes: Dataset of `stability`.
        name: of the mode; by default the one that becomes unstable first, else the least damped hunting mode.
        speed_kmh: the shape is that of the nearest speed in the table [km/h]; NaN: see `shape_speed`.
    """
    chosen = name or modes.attrs["linear_critical_mode"] or modes.attrs["hunting_mode"] or str(modes["mode"][0].item())
    speed = speed_kmh if math.isfinite(speed_kmh) else shape_speed(modes)
    one = modes.sel(mode=chosen).sel(speed=speed, method="nearest")
    views = ("plan", "end") if view_of(one) != "side" else ("side", "end")
    with house_style():
        figure, panels = new_grid(2, 2, height=3.6, gridspec_kw={"width_ratios": (3.2, 1)})
        for row, (phase, label) in enumerate(((0.0, "at its largest"), (90.0, "a quarter of a period later"))):
            for axes, view in zip(panels[row], views, strict=True):
                _draw(axes, one, view, phase)
                axes.set_ylabel(f"{AXES[VIEWS[view][1]]} [m]")
            panels[row][0].set_title(label, loc="left")
        for axes, view in zip(panels[1], views, strict=True):
            axes.set_xlabel(f"{AXES[VIEWS[view][0]]} [m]")
        return figure


@into_axes
def mode_shapes(modes: xr.Dataset, names: Sequence[str], speed_kmh: float, columns: int = 3) -> Figure:
    """Several modes, each in the view that shows most of it.

    Args:
        modes: Dataset of `stability`.
        names: of the modes.
        speed_kmh: the shapes are those of the nearest speed in the table [km/h].
        columns: panels beside each other.
    """
    rows = max(1, math.ceil(len(names) / columns))
    with house_style():
        figure, grid = new_grid(rows, columns, height=0.2 + 1.55 * rows)
        panels = grid.ravel()
        for axes in panels[len(names) :]:
            axes.set_visible(False)
        for axes, name in zip(panels, names, strict=False):
            one = modes.sel(mode=name).sel(speed=speed_kmh, method="nearest")
            view = view_of(one)
            _draw(axes, one, view, 0.0)
            frequency, damping = float(one["frequency"]), 100 * float(one["damping"])
            axes.set_title(f"{name}\n{frequency:.2f} Hz, damping {damping:.1f} %", loc="left", fontsize=7.5)
            across, up = (AXES[axis] for axis in VIEWS[view])
            axes.set_xlabel(f"{across} [m]", fontsize=7.5, labelpad=1)
            axes.set_ylabel(f"{up} [m]", fontsize=7.5, labelpad=1)
            axes.tick_params(labelsize=7)
        return figure


def shape_speed(modes: xr.Dataset) -> float:
    """Speed at which shapes are drawn unless another one is asked for: the linear critical speed, else the highest [km/h]."""
    critical, speeds = float(modes.attrs["linear_critical_speed_kmh"]), modes["speed"].to_numpy()
    return float(speeds[-1] if math.isnan(critical) else speeds[np.argmin(np.abs(speeds - critical))])


def view_of(mode: xr.Dataset) -> str:
    """The view that shows most of a mode's kinetic energy: from above, from the side, or from behind."""
    share = mode["energy_share"].sum("body")
    parts = {way: float(share.sel(direction=way)) for way in share["direction"].to_numpy().tolist()}
    car = mode["role"].to_numpy() == "car body"
    sways = float(mode["energy_share"].isel(body=car).sel(direction=["lateral", "roll"]).sum()) > 0.5
    if sways or parts["roll"] > 0.4:
        return "end"
    return "plan" if parts["lateral"] + parts["yaw"] > 0.5 else "side"


def _draw(axes: Axes, mode: xr.Dataset, view: str, phase_deg: float) -> None:
    first, second = VIEWS[view]
    amplitude = mode["shape_amplitude"].fillna(0.0).to_numpy()
    motion = amplitude * np.exp(1j * np.radians(mode["shape_phase"].to_numpy()))
    places, roles = mode["position"].to_numpy(), mode["role"].to_numpy()
    outlines = [
        _outline(str(role), place, view, places[roles == "wheelsets"])
        for role, place in zip(roles, places, strict=True)
    ]
    moved = [_displacement(points, part, str(role)) for points, part, role in zip(outlines, motion, roles, strict=True)]
    # the phase at which what is drawn moves most; the same scale a quarter of a period later
    drawn = np.concatenate([m[:, [first, second]].ravel() for m in moved])
    largest = drawn[np.argmax(np.abs(drawn))]
    turn = np.exp(-1j * np.angle(largest)) * np.exp(1j * np.radians(phase_deg)) if largest else 1.0
    scale = REACH[view] / abs(largest) if largest else 0.0
    order = np.argsort([{"wheelsets": 2, "bogie": 1}.get(str(role), 0) for role in roles])
    for k in order:
        colour = {"wheelsets": COLOURS[1], "bogie": COLOURS[0]}.get(str(roles[k]), COLOURS[2])
        points = outlines[k] + places[k]
        shifted = points + scale * (moved[k] * turn).real
        axes.plot(points[:, first], points[:, second], color=GREY, linewidth=0.7, linestyle=(0, (3, 2)))
        axes.plot(shifted[:, first], shifted[:, second], color=colour, linewidth=1.3)
    axes.set_aspect("equal", adjustable="datalim")
    axes.margins(0.06, 0.12)
    axes.grid(visible=False)


def _displacement(points: Points, motion: NDArray[np.complex128], role: str) -> NDArray[np.complex128]:
    """Displacement of points of a body, shape (n, 3): u + rotation x point."""
    turn = motion[3:].copy()
    if role == "wheelsets":
        turn[1] = 0.0  # its spin shows in no outline
    return np.asarray(motion[:3] + np.cross(np.broadcast_to(turn, points.shape), points))


def _outline(role: str, place: Points, view: str, wheelsets: Points) -> Points:
    """A closed line around a body, from its centre of mass, shape (n, 3)."""
    if role == "wheelsets":
        if view == "side":
            angle = np.linspace(0.0, 2 * np.pi, 41)
            return WHEEL_RADIUS * np.stack([np.cos(angle), 0 * angle, np.sin(angle)], axis=1)
        return _wheelset(view)
    if role == "bogie":
        near = wheelsets[np.abs(wheelsets[:, 0] - place[0]) < 3.0, 0] - place[0] if len(wheelsets) else np.zeros(0)
        half = (float(np.abs(near).max()) if len(near) else 1.0) + 0.15
        return _box(view, half, 1.0, -0.1, 0.1)
    half = float(np.abs(wheelsets[:, 0] - place[0]).max()) + 1.5 if len(wheelsets) else 2.0
    return (
        _box(view, half, 1.4, 1.0 - place[2], 3.4 - place[2]) if role == "car body" else _box(view, 0.5, 0.5, -0.3, 0.3)
    )


def _wheelset(view: str) -> Points:
    """Axle and two wheels, from above or from behind."""
    r, inner, outer = WHEEL_RADIUS, HALF_GAUGE - 0.07, HALF_GAUGE + 0.07
    half = [(1.0, 0.0), (outer, 0.0), (outer, r), (inner, r), (inner, -r), (outer, -r), (outer, 0.0), (inner, 0.0)]
    line = half + [(-y, h) for y, h in reversed(half)]
    flat = [(h, y, 0.0) if view == "plan" else (0.0, y, h) for y, h in line]
    return np.array(flat)


def _box(view: str, half_length: float, half_width: float, bottom: float, top: float) -> Points:
    corners = {
        "plan": [(1, 1, 0), (1, -1, 0), (-1, -1, 0), (-1, 1, 0), (1, 1, 0)],
        "side": [(1, 0, 0), (1, 0, 1), (-1, 0, 1), (-1, 0, 0), (1, 0, 0)],
        "end": [(0, 1, 0), (0, 1, 1), (0, -1, 1), (0, -1, 0), (0, 1, 0)],
    }[view]
    return np.array([(half_length * x, half_width * y, bottom + (top - bottom) * z) for x, y, z in corners])
