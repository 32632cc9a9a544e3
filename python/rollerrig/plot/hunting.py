"""Figures of hunting: runs from a disturbance, limit cycles over speed, sensitivities, traction near the limit."""

import json
import math
from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from rollerrig.analysis.curving_sensitivity import largest_change
from rollerrig.analysis.slide_statistics import spells
from rollerrig.plot.style import (
    COLOURS,
    GREY,
    colour,
    critical_line,
    critical_lines,
    into_axes,
    line,
    logarithmic,
    look,
    panels,
)


@into_axes
def ramp_over_speed(
    ramps: Mapping[str, xr.Dataset], body: str, critical: Mapping[str, Mapping[str, float | tuple[float, float]]]
) -> Figure:
    """Lateral displacement over speed while the rollers are sped up and slowed down again.

    Args:
        ramps: label -> Dataset of `ramp_run`; one panel each.
        body: whose displacement.
        critical: label -> name -> speed, or both ends of its interval [km/h], marked.
    """
    labels = ["lateral displacement [mm]"] * len(ramps)
    height = 0.6 + 2.6 * len(ramps)
    with panels(labels, "speed [km/h]", height, legend=False, sharex=False) as (figure, found):
        for axes, (label, ramp) in zip(found, ramps.items(), strict=True):
            speed, lateral = 3.6 * ramp["speed"].to_numpy(), 1e3 * ramp["lateral"].sel(body=body).to_numpy()
            top = int(np.argmax(speed))
            line(axes, speed[top:], lateral[top:], label="slowing down", color="#e6a29a", linewidth=0.7)
            line(axes, speed[: top + 1], lateral[: top + 1], label="speeding up", linewidth=0.7)
            perturbations = np.array(json.loads(ramp.attrs["perturbation_times_s"]))
            if perturbations.size:
                at, bottom = np.interp(perturbations, ramp["time"].to_numpy(), speed), axes.get_xaxis_transform()
                marks = {"color": "black", "markersize": 4, "label": "perturbation", "transform": bottom}
                axes.plot(at, np.full_like(at, 0.02), "^", **marks)  # type: ignore[arg-type]
            critical_lines(axes, critical.get(label, {}))
            axes.set_title(label, loc="left")
            axes.legend(loc="upper left", ncols=1)
        return figure


@into_axes
def hunting_over_time(runs: Sequence[tuple[float, xr.Dataset]], body: str, title: str = "") -> Figure:
    """Lateral displacement over time at constant speeds, one panel per speed, as long as the longest run.

    Args:
        runs: speed [km/h] and the run's Dataset.
        body: whose displacement.
        title: of the figure.
    """
    height, end = 0.7 + 1.25 * len(runs), max(float(run["time"][-1]) for _, run in runs)
    with panels(["[mm]"] * len(runs), "time [s]", height, legend=False, sharey=True) as (figure, found):
        for axes, (speed, run) in zip(found, runs, strict=True):
            lateral = 1e3 * run["lateral"].sel(body=body).to_numpy()
            line(axes, np.append(run["time"], end), np.append(lateral, math.nan), rasterized=False)
            axes.set_title(f"{speed:.0f} km/h", loc="right", fontsize=8, weight="bold", pad=2)
            axes.set_xlim(0.0, end)
        found[0].set_title(title, loc="left")
        figure.supylabel(f"lateral displacement of {body.replace('_', ' ')}", fontsize=9)
        return figure


@into_axes
def amplitude_over_speed(tables: Mapping[str, xr.Dataset], critical: Mapping[str, float] | None = None) -> Figure:
    """Amplitude at the end of runs over speed: zero where the disturbance decayed, else that of the limit cycle.

    Runs that did not come to their end are crosses at the upper edge.

    Args:
        tables: label -> Dataset of `hunting_table`.
        critical: name -> speed [km/h], marked by a vertical line.
    """
    with panels(["lateral amplitude at the end [mm]"], "speed [km/h]", 4.8) as (figure, (axes,)):
        for number, (label, table) in enumerate(tables.items()):
            speed, amplitude = table["speed"].to_numpy(), 1e3 * table["amplitude"].to_numpy()
            persists, decays = (table[name].to_numpy() == 1 for name in ("persists", "decays"))
            early, marker = ~(persists | decays), "os^Dv"[number % 5]
            drawn: dict[str, Any] = {"color": colour(number), "marker": marker}
            size = 4.5 + 2.5 * (len(tables) - 1 - number)  # those of several tables lie upon each other
            axes.plot(speed[persists], amplitude[persists], "-", markersize=4.5, label=f"{label}: persists", **drawn)
            drawn |= {"linestyle": "none", "markerfacecolor": "none", "markersize": size, "label": f"{label}: decays"}
            axes.plot(speed[decays], np.zeros(int(decays.sum())), **drawn)
            if early.any():  # neither: at the edge of the figure, where no amplitude can be read
                drawn |= {"marker": "x", "label": f"{label}: not decided", "transform": axes.get_xaxis_transform()}
                axes.plot(speed[early], np.full(int(early.sum()), 0.97), **drawn)
        critical_lines(axes, critical or {})
        axes.set_ylim(-0.15, max(1.0, axes.get_ylim()[1]))  # where all decay the axis is not round-off
        return figure


LOOKS: dict[str, dict[str, Any]] = {
    "up": {"color": COLOURS[0], "marker": "^", "linestyle": "-", "zorder": 3},
    "down": {"color": COLOURS[1], "marker": "v", "linestyle": "--", "zorder": 4, "markerfacecolor": "white"},
}
CYCLES = {  # label of a panel -> variable of `limit_cycle_table`, and factor
    "lateral amplitude of wheelsets [mm]": ("cycle_amplitude", 1e3),
    "frequency [Hz]": ("cycle_frequency", 1.0),
    "largest |Y| [kN]": ("cycle_guiding_force", 1e-3),
}


@into_axes
def limit_cycle_diagram(cycles: xr.Dataset, modes: xr.Dataset | None = None) -> Figure:
    """Amplitude, frequency and guiding force over speed, on the upward sweep and on the downward sweep.

    Args:
        cycles: Dataset of `limit_cycle_table`.
        modes: Dataset of `stability`: its linear critical speed, and the frequency of hunting for comparison.
    """
    with panels(list(CYCLES), "speed [km/h]", 7.0, legend=False, height_ratios=(2.2, 1, 1)) as (figure, axes):
        amplitude, frequency, force = axes
        for sweep, drawn in LOOKS.items():
            one = cycles.isel(cycle_point=cycles["cycle_sweep"].to_numpy() == sweep)
            for panel, (name, factor) in zip(axes, CYCLES.values(), strict=True):
                panel.plot(one["cycle_speed"], factor * one[name], markersize=5, label=f"{sweep}ward sweep", **drawn)
        early = cycles.isel(cycle_point=cycles["cycle_status"].to_numpy() != "ok")
        for speed, status in zip(early["cycle_speed"].to_numpy(), early["cycle_status"].to_numpy(), strict=True):
            place: dict[str, Any] = {"xycoords": ("data", "axes fraction"), "rotation": 90, "fontsize": 7.5}
            amplitude.annotate(str(status).replace("_", " "), (speed, 0.5), **place)
        critical = {"critical speed by continuation": float(cycles.attrs["critical_speed_by_continuation_kmh"])}
        if modes is not None:
            critical["linear critical speed"] = float(modes.attrs["linear_critical_speed_kmh"])
            if bool(modes["hunting_frequency"].notnull().any()):
                label = "linear hunting mode"
                drawn_line = frequency.plot(
                    modes["speed"], modes["hunting_frequency"], color=GREY, linewidth=1.0, label=label
                )
                frequency.legend(handles=drawn_line, loc="best")
        for name, value in critical.items():
            if math.isfinite(value):
                critical_line(amplitude, value, f"{name} {value:.1f} km/h")
                for panel in (frequency, force):
                    panel.axvline(value, color=GREY, linewidth=1.0, linestyle=(0, (4, 2)))
        speeds, sizes = cycles["cycle_speed"].to_numpy(), np.nan_to_num(1e3 * cycles["cycle_amplitude"].to_numpy())
        margin = 0.03 * float(np.ptp(speeds)) + 1.0
        amplitude.set_xlim(float(speeds.min()) - margin, float(speeds.max()) + margin)
        amplitude.set_ylim(bottom=-0.03 * max(1.0, float(sizes.max(initial=0.0))))
        amplitude.legend(loc="upper left")
        frequency.set_ylim(bottom=0.0)
        if float(np.nan_to_num(1e-3 * cycles["cycle_guiding_force"].to_numpy()).max(initial=0.0)) > 100.0:
            logarithmic(force, "y")
        return figure


@into_axes
def bifurcation_diagram(branch: xr.Dataset) -> Figure:
    """Amplitude over speed along a branch of `bifurcation`, stable parts solid, unstable ones dashed, with its folds."""
    label = "lateral amplitude of the leading wheelset [mm]"
    with panels([label], "speed [km/h]", 4.8, legend=False) as (figure, (axes,)):
        linear = float(branch.attrs["linear_critical_speed_kmh"])
        speed = np.concatenate([[linear], branch["speed"].to_numpy()])
        amplitude = np.concatenate([[0.0], 1e3 * branch["amplitude"].to_numpy()])
        stable = branch["stable"].to_numpy() == 1
        for ink, holds, name, style in ((0, True, "stable", "-"), (1, False, "unstable", "--")):
            for number, (begin, end) in enumerate(zip(*spells(stable == holds), strict=True)):
                one = slice(begin, end + 1)  # from the point before it
                line(axes, speed[one], amplitude[one], ink, style, name if number == 0 else "", linewidth=1.6)
        for fold in json.loads(branch.attrs["folds"]):
            at = fold["speed_kmh"], fold["amplitude_mm"]
            axes.plot(*at, "o", color="black", markersize=4)
            axes.annotate(f"fold, {at[0]:.2f} km/h", at, (-6, -3), textcoords="offset points", fontsize=8, ha="right")
        critical_line(axes, linear, f"linear critical speed {linear:.2f} km/h")
        axes.margins(x=0.2)
        axes.set_ylim(bottom=0.0)
        axes.legend(loc="upper left")
        return figure


MOST_BARS, LEAST_BAR = 15, 0.005  # bars in one figure, and the shortest that can be seen, over the longest


@into_axes
def tornado_diagram(sensitivity: xr.Dataset, output: str = "") -> Figure:
    """Change of the linear critical speed, or of a force or angle in a curve, by numbers of the case that are 1 % larger.

    A bar each, the longest on top: at most MOST_BARS, those of at least LEAST_BAR of the longest; the scale on top says per cent.

    Args:
        sensitivity: Dataset of `stability_sensitivity`, or of `curving_sensitivity`.
        output: of the latter, its variable: drawn is where its magnitude is largest.
    """
    if output:
        one = sensitivity[output]
        largest = abs(one).idxmax()
        whole, unit = float(abs(one).max()), one.attrs["units"].replace("1", "-")
        change = largest_change(sensitivity, output).to_numpy()
        of = f"{output.replace('_', ' ')}, {str(largest.item()).replace('_', ' ')}"
    else:
        whole, unit, of = float(sensitivity.attrs["linear_critical_speed_kmh"]), "km/h", "linear critical speed"
        change = sensitivity["critical_speed_change"].to_numpy()
    longest = float(np.abs(change).max(initial=0.0))
    order = [k for k in np.argsort(-np.abs(change)) if abs(change[k]) >= LEAST_BAR * longest][:MOST_BARS]
    label = f"change of the {of} by 1 % more [{unit}]"
    with panels([""], label, 1.2 + 0.27 * len(order), legend=False) as (figure, (axes,)):
        for place, k in enumerate(order):
            ink, hatch = (COLOURS[0], "") if change[k] >= 0.0 else (COLOURS[1], "///")
            bar = axes.barh(place, change[k], 0.7, color=ink, alpha=0.85, hatch=hatch, edgecolor="white")
            axes.bar_label(bar, [f"{change[k]:+.2g}"], padding=3, fontsize=7.5)
        axes.axvline(0.0, color=GREY, linewidth=1.0)
        axes.set_yticks(range(len(order)), [_number_words(str(sensitivity["parameter"].to_numpy()[k])) for k in order])
        axes.invert_yaxis()
        axes.grid(visible=False, axis="y")
        low, high = axes.get_xlim()
        axes.set_xlim(low - 0.2 * longest * (low < 0.0), high + 0.2 * longest * (high > 0.0))  # room for the numbers
        factors = 100.0 / whole, whole / 100.0
        scale = axes.secondary_xaxis("top", functions=tuple(partial(np.multiply, one) for one in factors))  # type: ignore[arg-type]
        scale.set_xlabel(f"over the {of}, {whole:.4g} {unit}".removesuffix(" -") + " [%]")
        return figure


def _number_words(key: str) -> str:
    """A dotted key in a figure: 'primary, x, stiffness'."""
    return key.removeprefix("vehicle.element.").replace("_*", "").replace(".", ", ").replace("_", " ")


def _beside_theory(
    axes: Axes, study: xr.Dataset, wheels: Mapping[str, str], signal: str, factor: float, said: Sequence[str]
) -> None:
    """A signal of wheels over time; dotted the closed form of the first ones, with what each is called."""
    for number, (wheel, label) in enumerate(wheels.items()):
        axes.plot(study["time"], factor * study[signal].sel(wheel=wheel), label=label, **look(number))
    for wheel, text in zip(wheels, said, strict=False):
        theory = factor * study[f"{signal}_theory"].sel(wheel=wheel)
        axes.plot(study["time"], theory, color="black", linestyle=":", linewidth=1.4, label=text)


@into_axes
def traction_sliding(study: xr.Dataset, wheels: Mapping[str, str]) -> Figure:
    """Absolute sliding of wheels over time, with what the theory gives.

    Args:
        study: `sliding` and `sliding_theory` [m/s] over time and wheel, `torque` [N m] and `speed` [m/s] over time.
        wheels: wheel -> label.
    """
    labels = ("absolute sliding [mm/s]", "torque per wheelset [kN m]")
    with panels(labels, "time [s]", 4.6, legend=False, height_ratios=[2.2, 1]) as (figure, (top, bottom)):
        _beside_theory(top, study, wheels, "sliding", 1e3, ["slope of the creep law at the start × force × speed"])
        top.set_ylim(bottom=0.0)
        top.legend(loc="upper left")
        bottom.plot(study["time"], 1e-3 * study["torque"], color=COLOURS[2])
        bottom.yaxis.label.set_color(COLOURS[2])
        other = bottom.twinx()
        other.plot(study["time"], 3.6 * study["speed"], color=COLOURS[4], linestyle="--")
        other.set_ylabel("speed [km/h]", color=COLOURS[4])
        other.grid(visible=False)
        return figure


@into_axes
def traction_forces(study: xr.Dataset, wheels: Mapping[str, str]) -> Figure:
    """Longitudinal creep force and vertical contact force of wheels over time, with their closed forms.

    Args:
        study: `longitudinal_creep_force`, `longitudinal_creep_force_theory`, `vertical_force`, `vertical_force_theory` [N]
            over time and wheel.
        wheels: wheel -> label.
    """
    labels = ("longitudinal creep force\non the wheel [kN]", "vertical force\non the wheel [kN]")
    with panels(labels, "time [s]", 4.8, legend=False) as (figure, (top, bottom)):
        _beside_theory(top, study, wheels, "longitudinal_creep_force", 1e-3, ["closed form"])
        _beside_theory(bottom, study, wheels, "vertical_force", 1e-3, ["closed form", *("",) * (len(wheels) - 1)])
        top.legend(loc="lower right")
        bottom.legend(loc="center right")
        return figure
