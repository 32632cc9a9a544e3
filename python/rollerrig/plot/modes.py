"""Figures of the modes over speed."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from rollerrig.plot.into import into_axes
from rollerrig.plot.style import (
    COLOURS,
    GREY,
    MARKERS,
    STYLES,
    colour,
    critical_line,
    house_style,
    legend_beside,
    look,
    new_figure,
    panels,
)

HIGHEST_FREQUENCY = 30.0
"""Modes above are those of wheels on their Hertz springs; they say nothing about stability and squeeze the rest [Hz]."""

SHOWN_DAMPING = 0.6
"""Modes that are always damped more than this are left out of the figures [1]."""


DAMPING_STEPS = (-100, -10, -5, 0, 5, 10, 20, 30, 50, 100)
"""Limits of the shades of the damping map [%]."""

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


def _where_it_oscillates(modes: xr.Dataset, variable: str, name: str) -> xr.DataArray:
    mode = modes.sel(mode=name)
    return mode[variable].where(mode["frequency"] > 0.0)


@into_axes
def root_locus(modes: xr.Dataset) -> Figure:
    """Eigenvalues in the complex plane, one line per mode, from the lowest speed (open) to the highest (filled).

    Args:
        modes: Dataset of `stability`.
    """
    with panels(["frequency Im λ / 2π [Hz]"], "growth rate Re λ [1/s]", _height(modes, 4.4), legend=False) as (
        figure,
        (axes,),
    ):
        for number, name in enumerate(shown_modes(modes)):
            mode = modes.sel(mode=name)
            going = mode["frequency"].to_numpy() > 0.0
            real, imaginary = mode["growth_rate"].to_numpy()[going], mode["frequency"].to_numpy()[going]
            drawn = _look(name, number)
            axes.plot(real, imaginary, marker=".", markersize=4, label=name, **drawn)
            marker: dict[str, Any] = {
                "marker": "o",
                "markersize": 5,
                "color": drawn["color"],
                "linestyle": "none",
                "zorder": 6,
            }
            axes.plot(real[:1], imaginary[:1], markerfacecolor="white", **marker)
            axes.plot(real[-1:], imaginary[-1:], **marker)
        axes.axvline(0.0, color=GREY, linewidth=1.0)
        low, high = (float(modes["speed"][k]) for k in (0, -1))
        axes.set_title(f"open: {low:g} km/h, filled: {high:g} km/h; unstable right of 0", loc="left")
        axes.set_xlim(right=max(2.0, 1.08 * axes.get_xlim()[1]))
        legend_beside(axes)
        return figure


@into_axes
def damping_over_speed(modes: xr.Dataset) -> Figure:
    """Damping ratio of each mode over speed.

    Args:
        modes: Dataset of `stability`.
    """
    with panels(["damping ratio [%]"], "speed [km/h]", _height(modes, 3.4), legend=False) as (figure, (axes,)):
        for number, name in enumerate(shown_modes(modes)):
            axes.plot(
                modes["speed"], 100 * _where_it_oscillates(modes, "damping", name), label=name, **_look(name, number)
            )
        axes.axhline(0.0, color=GREY, linewidth=1.0)
        _mark_critical(axes, modes)
        legend_beside(axes)
        return figure


@into_axes
def damping_map(modes: xr.Dataset) -> Figure:
    """Damping of all oscillatory modes over speed as colours, one row per mode, by frequency.

    Args:
        modes: Dataset of `stability`.
    """
    with house_style():
        names = [str(name) for name in modes["mode"].to_numpy()]
        figure, (axes,) = new_figure(height=max(2.7, 1.3 + 0.185 * len(names)))
        speed = modes["speed"].to_numpy()
        values = 100 * modes["damping"].where(modes["frequency"] > 0.0).transpose("mode", "speed").to_numpy()
        edges = np.concatenate([[speed[0]], 0.5 * (speed[1:] + speed[:-1]), [speed[-1]]])
        if len(speed) == 1:
            edges = np.array([speed[0] - 1.0, speed[0] + 1.0])
        shades = ListedColormap(DAMPING_COLOURS)
        steps = BoundaryNorm(DAMPING_STEPS, shades.N, extend="neither")
        shown = np.clip(values, DAMPING_STEPS[0], DAMPING_STEPS[-1] - 1e-9)
        axes.set_facecolor("#e4e4e4")
        mesh = axes.pcolormesh(edges, np.arange(len(names) + 1), shown, cmap=shades, norm=steps, rasterized=False)
        for row, value in enumerate(values):
            for low, high in zip(edges[:-1][value < 0], edges[1:][value < 0], strict=True):
                axes.add_patch(
                    Rectangle((low, row), high - low, 1, fill=False, hatch="////", edgecolor="#333333", linewidth=0)
                )
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
    """Frequency of each mode over speed, and of limit cycles where they are given.

    Args:
        modes: Dataset of `stability`.
        cycles: Dataset of `limit_cycle_table`.
    """
    with panels(["frequency [Hz]"], "speed [km/h]", _height(modes, 4.0), legend=False) as (figure, (axes,)):
        for number, name in enumerate(shown_modes(modes)):
            axes.plot(modes["speed"], _where_it_oscillates(modes, "frequency", name), label=name, **_look(name, number))
        if cycles is not None and bool((cycles["cycle_amplitude"] > 0).any()):
            speed, frequency = cycles["cycle_speed"].to_numpy(), cycles["cycle_frequency"].to_numpy()
            axes.plot(speed, frequency, "ks", markersize=4, markerfacecolor="none", label="limit cycles (runs)")
        _mark_critical(axes, modes)
        axes.set_ylim(bottom=0.0)
        legend_beside(axes)
        return figure


def hunting_frequencies(linear: dict[str, xr.Dataset], runs: dict[str, xr.Dataset], title: str = "") -> Figure:
    """Frequency of hunting over speed: linear modes as lines; runs as markers, filled where they end in a limit cycle.

    Args:
        linear: label -> Dataset of `stability`; drawn where a mode hunts, see `hunting_frequency`.
        runs: label -> Dataset of `hunting_table`; in the colour of the line with the same label, if there is one.
        title: of the figure.
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
                    drawn: dict[str, Any] = {
                        "color": own,
                        "markerfacecolor": face,
                        "markersize": 5,
                        "label": f"{ends}, {label}",
                    }
                    axes.plot(speed[kept], values, marker, **drawn)
        axes.set_ylim(bottom=0.0)
        axes.set_title(title, loc="left")
        legend_beside(axes)
        return figure
