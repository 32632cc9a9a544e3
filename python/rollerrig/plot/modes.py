"""Figures of the modes over speed, and of mode shapes: schematic outlines of the bodies, as the mode displaces them."""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from rollerrig.common.arrays import Array, Complex
from rollerrig.plot.style import (
    COLOURS,
    GREY,
    MARKERS,
    STYLES,
    colour,
    critical_line,
    into_axes,
    legend_beside,
    look,
    new_figure,
    new_grid,
    panels,
)

VIEWS = {"plan": (0, 1), "side": (0, 2), "end": (1, 2)}  # view -> the axes it shows

AXES = ("x", "y", "z")
REACH = {"plan": 0.5, "side": 0.5, "end": 0.35}  # largest displacement drawn in each view [m]

HALF_GAUGE, WHEEL_RADIUS = 0.75, 0.46


@into_axes
def mode_shapes(modes: xr.Dataset, names: Sequence[str], speed_kmh: float) -> Figure:
    """Several modes, each in the view that shows most of it.

    Args:
        modes: Dataset of `stability`.
        names: of the modes.
        speed_kmh: the shapes are those of the nearest speed in the table [km/h].
    """
    rows = max(1, math.ceil(len(names) / 3))
    figure, grid = new_grid(rows, 3, height=0.2 + 1.55 * rows)
    panels = grid.ravel()
    for axes in panels[len(names) :]:
        axes.set_visible(False)
    for axes, name in zip(panels, names, strict=False):
        one = modes.sel(mode=name).sel(speed=speed_kmh, method="nearest")
        view = view_of(one)
        _draw(axes, one, view)
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


def _draw(axes: Axes, mode: xr.Dataset, view: str) -> None:
    first, second = VIEWS[view]
    amplitude = mode["shape_amplitude"].fillna(0.0).to_numpy()
    motion = amplitude * np.exp(1j * np.radians(mode["shape_phase"].to_numpy()))
    places, roles = mode["position"].to_numpy(), mode["role"].to_numpy()
    wheelsets = places[roles == "wheelsets"]
    outlines = [_outline(str(role), place, view, wheelsets) for role, place in zip(roles, places, strict=True)]
    moved = [_displacement(points, part, str(role)) for points, part, role in zip(outlines, motion, roles, strict=True)]
    # the phase at which what is drawn moves most
    drawn = np.concatenate([m[:, [first, second]].ravel() for m in moved])
    largest = drawn[np.argmax(np.abs(drawn))]
    turn = np.exp(-1j * np.angle(largest))
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


def _displacement(points: Array, motion: Complex, role: str) -> Complex:
    """Displacement of points of a body, shape (n, 3): u + rotation x point."""
    turn = motion[3:].copy()
    if role == "wheelsets":
        turn[1] = 0.0  # its spin shows in no outline
    return np.asarray(motion[:3] + np.cross(np.broadcast_to(turn, points.shape), points))


def _outline(role: str, place: Array, view: str, wheelsets: Array) -> Array:
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
    car = half, 1.4, 1.0 - place[2], 3.4 - place[2]
    return _box(view, *(car if role == "car body" else (0.5, 0.5, -0.3, 0.3)))


def _wheelset(view: str) -> Array:
    """Axle and two wheels, from above or from behind."""
    r, inner, outer = WHEEL_RADIUS, HALF_GAUGE - 0.07, HALF_GAUGE + 0.07
    half = [(1.0, 0.0), (outer, 0.0), (outer, r), (inner, r), (inner, -r), (outer, -r), (outer, 0.0), (inner, 0.0)]
    line = half + [(-y, h) for y, h in reversed(half)]
    flat = [(h, y, 0.0) if view == "plan" else (0.0, y, h) for y, h in line]
    return np.array(flat)


def _box(view: str, half_length: float, half_width: float, bottom: float, top: float) -> Array:
    ends = np.array([(-half_length, half_length), (-half_width, half_width), (bottom, top)])
    line, (first, second) = np.zeros((5, 3)), VIEWS[view]
    line[:, first], line[:, second] = ends[first][[1, 1, 0, 0, 1]], ends[second][[0, 1, 1, 0, 0]]
    return line


HIGHEST_FREQUENCY = 30.0
"""Modes above are those of wheels on their Hertz springs; they say nothing about stability and squeeze the rest [Hz]."""

SHOWN_DAMPING = 0.6  # modes that are always damped more than this are left out of the figures [1]


DAMPING_STEPS = (-100, -10, -5, 0, 5, 10, 20, 30, 50, 100)  # limits of the shades of the damping map [%]

DAMPING_COLOURS = ("#7f1d1d", "#c0392b", "#e8a09a", "#fff3b0", "#d9e8b4", "#a8d0b0", "#6fb0b4", "#3d83ad", "#1f4e86")
"""One per shade: red grows, yellow is hardly damped, blue is well damped; they also differ in grey."""


def shown_modes(modes: xr.Dataset) -> list[str]:
    """Modes worth a line: oscillations below HIGHEST_FREQUENCY that are not heavily damped throughout."""
    kept = (modes["frequency"].max("speed") <= HIGHEST_FREQUENCY) & (modes["damping"].min("speed") <= SHOWN_DAMPING)
    return [str(name) for name in modes["mode"].to_numpy()[kept.to_numpy()]]


def _look(name: str, number: int) -> dict[str, Any]:
    if name.startswith("hunting"):
        style = (0, (1.5, 1)) if name.endswith(("out of phase", "rear bogie")) else "-"
        return {"color": COLOURS[1], "linewidth": 2.2, "linestyle": style, "zorder": 5}
    colours = [c for c in COLOURS if c != COLOURS[1]]
    return {"color": colours[number % len(colours)], "linestyle": STYLES[(number // len(colours)) % len(STYLES)]}


def _height(modes: xr.Dataset, least: float) -> float:
    """Height of a figure whose legend beside it names all modes shown [inches]."""
    return max(least, 0.5 + 0.178 * (len(shown_modes(modes)) + 1))


def _mark_critical(axes: Axes, modes: xr.Dataset) -> None:
    speed = float(modes.attrs["linear_critical_speed_kmh"])
    if math.isfinite(speed):
        critical_line(axes, speed, f"linear critical speed {speed:.1f} km/h")


def _lines(axes: Axes, modes: xr.Dataset, variable: str, factor: float = 1.0) -> None:
    """A line for each mode shown, where it oscillates."""
    for number, name in enumerate(shown_modes(modes)):
        mode = modes.sel(mode=name)
        values = factor * mode[variable].where(mode["frequency"] > 0.0)
        axes.plot(modes["speed"], values, label=name, **_look(name, number))


@into_axes
def root_locus(modes: xr.Dataset) -> Figure:
    """Eigenvalues of `stability` in the complex plane, a line per mode, from the lowest speed (open) to the highest (filled)."""
    labels, height = ["frequency Im λ / 2π [Hz]"], _height(modes, 4.4)
    with panels(labels, "growth rate Re λ [1/s]", height, legend=False) as (figure, (axes,)):
        for number, name in enumerate(shown_modes(modes)):
            mode = modes.sel(mode=name)
            going = mode["frequency"].to_numpy() > 0.0
            real, imaginary = mode["growth_rate"].to_numpy()[going], mode["frequency"].to_numpy()[going]
            drawn = _look(name, number)
            axes.plot(real, imaginary, marker=".", markersize=4, label=name, **drawn)
            ends: dict[str, Any] = {**drawn, "marker": "o", "markersize": 5, "linestyle": "none", "zorder": 6}
            axes.plot(real[:1], imaginary[:1], markerfacecolor="white", **ends)
            axes.plot(real[-1:], imaginary[-1:], **ends)
        axes.axvline(0.0, color=GREY, linewidth=1.0)
        low, high = (float(modes["speed"][k]) for k in (0, -1))
        axes.set_title(f"open: {low:g} km/h, filled: {high:g} km/h; unstable right of 0", loc="left")
        axes.set_xlim(right=max(2.0, 1.08 * axes.get_xlim()[1]))
        legend_beside(axes)
        return figure


@into_axes
def damping_over_speed(modes: xr.Dataset) -> Figure:
    """Damping ratio of each mode of `stability` over speed."""
    with panels(["damping ratio [%]"], "speed [km/h]", _height(modes, 3.4), legend=False) as (figure, (axes,)):
        _lines(axes, modes, "damping", 100.0)
        axes.axhline(0.0, color=GREY, linewidth=1.0)
        _mark_critical(axes, modes)
        legend_beside(axes)
        return figure


@into_axes
def damping_map(modes: xr.Dataset) -> Figure:
    """Damping of all oscillatory modes of `stability` over speed as colours, one row per mode, by frequency."""
    names = [str(name) for name in modes["mode"].to_numpy()]
    figure, (axes,) = new_figure(height=max(2.7, 1.3 + 0.185 * len(names)))
    speed = modes["speed"].to_numpy()
    values = 100 * modes["damping"].where(modes["frequency"] > 0.0).transpose("mode", "speed").to_numpy()
    ends = speed[[0, -1]] if len(speed) > 1 else speed[0] + np.array([-1.0, 1.0])
    edges = np.concatenate([ends[:1], 0.5 * (speed[1:] + speed[:-1]), ends[1:]])
    shades = ListedColormap(DAMPING_COLOURS)
    steps = BoundaryNorm(DAMPING_STEPS, shades.N, extend="neither")
    shown = np.clip(values, DAMPING_STEPS[0], DAMPING_STEPS[-1] - 1e-9)
    axes.set_facecolor("#e4e4e4")
    mesh = axes.pcolormesh(edges, np.arange(len(names) + 1), shown, cmap=shades, norm=steps, rasterized=False)
    hatched: dict[str, Any] = {"fill": False, "hatch": "////", "edgecolor": "#333333", "linewidth": 0}
    for row, value in enumerate(values):
        for low, high in zip(edges[:-1][value < 0], edges[1:][value < 0], strict=True):
            axes.add_patch(Rectangle((low, row), high - low, 1, **hatched))
    typical = modes["frequency"].isel(speed=-1).to_numpy()
    axes.set_yticks(np.arange(len(names)) + 0.5)
    axes.set_yticklabels([f"{name}  ({f:.3g} Hz)" for name, f in zip(names, typical, strict=True)], fontsize=7.5)
    axes.grid(visible=False)
    for row in range(1, len(names)):
        axes.axhline(row, color="white", linewidth=0.8)
    _mark_critical(axes, modes)
    axes.set_xlabel("speed [km/h]")
    bar = figure.colorbar(mesh, ax=axes, ticks=DAMPING_STEPS, pad=0.015, aspect=30)
    bar.set_label("damping ratio [%]")
    axes.set_title("hatched: grows; grey: no oscillation", loc="left")
    return figure


@into_axes
def frequency_over_speed(modes: xr.Dataset, cycles: xr.Dataset | None = None) -> Figure:
    """Frequency of each mode of `stability` over speed, and of limit cycles where those of `limit_cycle_table` are given."""
    with panels(["frequency [Hz]"], "speed [km/h]", _height(modes, 4.0), legend=False) as (figure, (axes,)):
        _lines(axes, modes, "frequency")
        if cycles is not None and bool((cycles["cycle_amplitude"] > 0).any()):
            speed, frequency = cycles["cycle_speed"].to_numpy(), cycles["cycle_frequency"].to_numpy()
            axes.plot(speed, frequency, "ks", markersize=4, markerfacecolor="none", label="limit cycles (runs)")
        _mark_critical(axes, modes)
        axes.set_ylim(bottom=0.0)
        legend_beside(axes)
        return figure


def hunting_frequencies(linear: dict[str, xr.Dataset], runs: dict[str, xr.Dataset], title: str = "") -> Figure:
    """Frequency of hunting over speed: modes of `stability` as lines, runs of `hunting_table` as markers of the same colour.

    Lines are drawn where a mode hunts, see `hunting_frequency`; markers are filled where a run ends in a limit cycle.
    """
    with panels(["frequency of lateral oscillation [Hz]"], "speed [km/h]", 3.6, legend=False) as (figure, (axes,)):
        for number, (label, modes) in enumerate(linear.items()):
            frequency = modes["hunting_frequency"]
            if not bool(frequency.notnull().any()):
                continue
            axes.plot(modes["speed"], frequency, label=f"linear, {label}", **look(number))
            critical = float(modes.attrs["linear_critical_speed_kmh"])
            if math.isfinite(critical):
                at = float(modes.attrs["linear_critical_frequency_hz"])
                axes.plot([critical], [at], marker="x", color=colour(number), markersize=8, markeredgewidth=2)
        for number, (label, table) in enumerate(runs.items()):
            going, decays = (table[name].to_numpy() == 1 for name in ("persists", "decays"))
            speed, marker = table["speed"].to_numpy(), MARKERS[number % len(MARKERS)]
            own = colour(list(linear).index(label)) if label in linear else "black"
            for ends, kept, variable, face in (
                ("limit cycle", going, "oscillation_frequency", own),
                ("decaying", decays, "decay_frequency", "none"),
            ):
                values = table[variable].to_numpy()[kept]
                if np.isfinite(values).any():
                    drawn: dict[str, Any] = {"color": own, "markerfacecolor": face, "markersize": 5}
                    axes.plot(speed[kept], values, marker, label=f"{ends}, {label}", **drawn)
        axes.set_ylim(bottom=0.0)
        axes.set_title(title, loc="left")
        legend_beside(axes)
        return figure
