"""Figures of several supports side by side: one colour or style per support, both always in the same axes."""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import FixedLocator, NullFormatter

from rollerrig.plot.modes import shown_modes
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

MOST_MODES = 7  # modes in one figure; the others are in the table
HIGHEST_FREQUENCY = 20.0  # modes above are left out: supports hardly change them, and they squeeze the rest [Hz]
LEAST_DIFFERENCE = 0.2  # modes whose eigenvalues differ by less between the supports are left out [1/s]


def telling_modes(modes: Mapping[str, xr.Dataset]) -> list[str]:
    """Names of the modes that differ most between the supports, hunting modes first; those that all supports have."""
    first = next(iter(modes.values()))
    common = set.intersection(*(set(shown_modes(one)) for one in modes.values()))
    low = first["frequency"].max("speed") < HIGHEST_FREQUENCY
    names = [name for name in shown_modes(first) if name in common and bool(low.sel(mode=name))]

    def apart(name: str) -> float:
        own, of = first.sel(mode=name), [m.sel(mode=name) for m in modes.values()]
        keys = ("growth_rate", "angular_frequency")
        return max(sum(float(np.abs(one[key].to_numpy() - own[key].to_numpy()).max()) for key in keys) for one in of)

    hunting = [name for name in names if name.startswith("hunting")]
    others = [name for name in names if name not in hunting and (len(modes) == 1 or apart(name) > LEAST_DIFFERENCE)]
    others.sort(key=apart, reverse=True)
    return [*hunting, *others][:MOST_MODES]


def modes_side_by_side(modes: Mapping[str, xr.Dataset]) -> Figure:
    """Frequency and damping of the modes of `stability` over speed: a colour per mode, a line style per support."""
    names = telling_modes(modes)
    labels = ("frequency [Hz]", "damping ratio [%], unstable below 0")
    colours = [COLOURS[(1, 0, 2, 3, 4, 5, 6, 7)[number % 8]] for number in range(len(names))]
    with panels(labels, "speed [km/h]", 6.2, legend=False) as (figure, (frequency, damping)):
        for name, one in zip(names, colours, strict=True):
            for style, dataset in zip(STYLES, modes.values(), strict=False):
                mode = dataset.sel(mode=name)
                oscillates, width = mode["frequency"] > 0.0, 2.0 if name.startswith("hunting") else 1.2
                drawn: dict[str, Any] = {"color": one, "linestyle": style, "linewidth": width}
                frequency.plot(dataset["speed"], mode["frequency"].where(oscillates), **drawn)
                damping.plot(dataset["speed"], 100 * mode["damping"].where(oscillates), **drawn)
        damping.axhline(0.0, color=GREY, linewidth=1.0)
        low, high = damping.get_ylim()
        damping.set_ylim(max(low, -25.0), min(high, 65.0))
        frequency.set_ylim(bottom=0.0)
        by_name = [Line2D([], [], color=one, label=name) for one, name in zip(colours, names, strict=True)]
        by_style = [Line2D([], [], label=n, **{**look(k), "color": "black"}) for k, n in enumerate(modes)]
        legend_beside(frequency, handles=by_name, title="mode")
        legend_beside(damping, handles=by_style, title="on")
        return figure


def critical_over_radius(speeds: Mapping[str, Mapping[float, float]], marked: float) -> Figure:
    """Critical speeds [km/h] over the rollers' radius [m] by label; at infinity the track, the line that the curves approach."""
    with panels(["linear critical speed [km/h]"], "radius of the rollers [m]", 3.6, legend=False) as (figure, (axes,)):
        ticks = sorted({radius for curve in speeds.values() for radius in curve if math.isfinite(radius)})
        for number, (label, curve) in enumerate(speeds.items()):
            one, marker = colour(number), MARKERS[number % len(MARKERS)]
            values = [curve.get(radius, math.nan) for radius in ticks]
            axes.plot(ticks, values, marker=marker, color=one, markersize=5, label=f"{label}, on rollers")
            if math.isfinite(track := curve.get(math.inf, math.nan)):
                style = STYLES[1 + number % 3]
                axes.axhline(track, color=one, linestyle=style, linewidth=1.1, label=f"{label}, on track")
        axes.set_xscale("log")
        axes.xaxis.set_major_locator(FixedLocator(ticks))
        axes.xaxis.set_minor_formatter(NullFormatter())
        axes.set_xticklabels([f"{tick:g}" for tick in ticks])
        axes.minorticks_off()
        if math.isfinite(marked):
            critical_line(axes, marked, f"this rig, {marked:g} m")
        legend_beside(axes)
        return figure


@house_style()
def effect_bars(off: Mapping[str, float], alone: Mapping[str, float], loss: float) -> Figure:
    """What each effect of a roller costs [km/h]: left out of the rig, and alone on the track; loss from track to rig."""
    figure, (axes,) = new_figure(height=0.9 + 0.55 * (len(off) + 2))
    rows = [*off, "interaction", "all: track less rig"]
    places = np.arange(len(rows))[::-1]
    for values, shift, ink, hatch, label in (
        (off, 0.19, COLOURS[0], "", "switched off alone: gain of the rig"),
        (alone, -0.19, COLOURS[1], "///", "on alone: loss from the track"),
    ):
        bars = [*(values[effect] for effect in off), loss - sum(values.values()), loss]
        look_of: dict[str, Any] = {"color": ink, "alpha": 0.85, "hatch": hatch, "edgecolor": "white", "label": label}
        drawn = axes.barh(places + shift, bars, 0.36, **look_of)
        axes.bar_label(drawn, fmt="{:+.1f}", padding=3, fontsize=7.5)
    axes.axvline(0.0, color=GREY, linewidth=1.0)
    axes.set_yticks(places, rows)
    axes.margins(x=0.12)
    axes.set_xlabel("linear critical speed [km/h]")
    axes.legend(loc="lower center", bbox_to_anchor=(0.4, 1.0), ncols=2)
    return figure


def disturbed_over_time(runs: Mapping[str, xr.Dataset]) -> Figure:
    """The leading wheelset after a disturbance: motion, guiding force, sum of guiding forces, longitudinal creep force."""
    signals = {
        "lateral [mm]": ("lateral", 1e3),
        "Y, left wheel [kN]": ("guiding_force", 1e-3),
        "ΣY, 2 m mean [kN]": ("guiding_force_sum", 1e-3),
        "longitudinal creep force,\nleft wheel [kN]": ("longitudinal_creep_force", 1e-3),
    }
    with panels(list(signals), "time [s]", 8.0, legend=False) as (figure, axes):
        for number, (label, run) in enumerate(runs.items()):
            left = run.isel(wheel=0)
            for panel, (name, factor) in zip(axes, signals.values(), strict=True):
                panel.plot(run["time"], factor * left[name], label=label, **look(number))
        axes[0].set_xlim(0.0, float(next(iter(runs.values()))["time"][-1]))
        axes[0].legend(loc="upper right", ncols=len(runs))
        return figure
