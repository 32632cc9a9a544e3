"""Figures of a test on degraded track and on the rig that reproduces it, of ensembles, and of the lateral motion in it.

Signals of the axles of one or more runs over time: a colour per axle, a line style per run.
Of ensembles: bars of causes with their errors, distributions of slip, distance over dead time.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from rollerrig.common.arrays import Array
from rollerrig.plot.style import COLOURS, GREY, STYLES, house_style, line, logarithmic, new_figure, new_grid, panels

Signal = tuple[str, str | Callable[[xr.Dataset], xr.DataArray], float]
"""Label of the ordinate, variable or function of a run (over time, and over axle if each has its own), factor."""

PRESSURE: Signal = ("cylinder [bar]", "cylinder_pressure", 1e-5)
BRAKE = (PRESSURE, ("dump cycles\nso far", "dump_cycles", 1.0), ("air taken\nso far [l]", "air", 1e3))
TRACTION = (("traction torque [kN m]", "traction_torque", 1e-3), ("part of the demand", "torque_factor", 1.0))
ROLLERS = (("roller torque\n[kN m]", "roller_torque", 1e-3),)


def axles_over_time(runs: Mapping[str, xr.Dataset], signals: Sequence[Signal], height: float) -> Figure:
    """A panel per signal, of a height [inches]; the first run is drawn with full lines, the next dashed, by label."""
    with panels([label for label, _, _ in signals], "time [s]", height) as (figure, axes):
        for panel, (_, signal, factor) in zip(axes, signals, strict=True):
            for (label, run), style in zip(runs.items(), STYLES, strict=False):
                values = factor * (run[signal] if isinstance(signal, str) else signal(run))
                suffix = f", {label}" if len(runs) > 1 else ""
                if "axle" not in values.dims:
                    line(panel, run["time"], values, 5, style, f"train{suffix}")
                    continue
                for number, axle in enumerate(values["axle"].to_numpy()):
                    line(panel, run["time"], values.sel(axle=axle), number, style, f"{axle}{suffix}")
        return figure


AxleCurve = tuple[xr.DataArray, int, Any, str]
"""Values over time, of each axle or the train, number of the colour, style, label."""


def per_axle(what: str, curves: Sequence[AxleCurve]) -> Figure:
    """A panel per axle of the first curve, with all of them; `{}` in what it shows stands for the axle."""
    axles = [str(axle) for axle in curves[0][0]["axle"].to_numpy()]
    labels = [what.format(axle.replace("_", " ")) for axle in axles]
    with panels(labels, "time [s]", 1.0 + 1.7 * len(axles)) as (figure, found):
        for axes, axle in zip(found, axles, strict=True):
            for values, *look in curves:
                line(axes, values["time"], values.sel(axle=axle) if "axle" in values.dims else values, *look)
        return figure


def speeds(track: xr.Dataset, rig: xr.Dataset, radius: float) -> Figure:
    """Speeds of train and wheels: one panel per axle with rig, virtual train and track."""
    wheel = 3.6 * radius
    return per_axle("{}\nspeed [km/h]", (
        (wheel * rig["virtual_speed"], 2, ":", "wheel, virtual"),
        (3.6 * track["train_speed"], 5, "--", "train, track"),
        (3.6 * rig["train_speed"], 4, "-", "train, virtual"),
        (wheel * track["axle_speed"], 1, "--", "wheel, track"),
        (wheel * rig["axle_speed"], 0, "-", "wheel, rig"),
    ))  # fmt: skip


def wheel_less_train(radius: float) -> Signal:
    """Sliding of the wheels on rail, or on the virtual one; radius of the wheels [m]."""
    return "wheel less\ntrain [m/s]", lambda run: radius * run["axle_speed"] - run["train_speed"], 1.0


def sliding(rig: xr.Dataset, ideal: xr.Dataset | None, radius: float) -> Figure:
    """Sliding of wheels on rollers, tracking error, and the wheelsets' own motion: with contact model, and pure rolling."""
    signals: tuple[Signal, ...] = (
        ("sliding of wheel\non roller [mm/s]", "real_sliding", 1e3),
        ("wheel less virtual\nwheel [mm/s]", lambda run: run["axle_speed"] - run["virtual_speed"], 1e3 * radius),
        ("wheelset along\nthe track [mm/s]", _own_motion, 1e3),
    )
    runs = {"contact model": rig} | ({"pure rolling": ideal} if ideal is not None else {})
    return axles_over_time(runs, signals, 6.4)


def _own_motion(run: xr.Dataset) -> xr.DataArray:
    return run["longitudinal_velocity"].sel(body=run["axle"].to_numpy()).rename(body="axle")


@house_style()
def cause_bars(causes: Mapping[str, Mapping[str, Any]]) -> Figure:
    """Bars of what each imperfection contributes to the difference in distance; the last one is all of them.

    By name the part of the track's distance [-] as `mean` and `standard_error`; drawn hollow if `within_its_error`.
    """
    figure, (axes,) = new_figure(1, height=2.6)
    for row, one in enumerate(causes.values()):
        share, error, hidden = one["mean"], one["standard_error"] or 0.0, one["within_its_error"]
        colour = COLOURS[1] if row == len(causes) - 1 else COLOURS[0]
        look: dict[str, Any] = (
            {"facecolor": "none", "edgecolor": colour, "linestyle": "--"} if hidden else {"color": colour}
        )
        whiskers = {"capsize": 3.0, "elinewidth": 0.9}
        bar = axes.barh(row, 100.0 * share, height=0.55, xerr=100.0 * error, error_kw=whiskers, **look)
        text = f"{100.0 * share:+.2f} ± {100.0 * error:.2f}" + (", inside its error" if hidden else "")
        axes.bar_label(bar, [text], padding=5)
    axes.set_yticks(range(len(causes)), list(causes))
    axes.invert_yaxis()
    axes.axvline(0.0, color="black", linewidth=0.8)
    axes.margins(x=0.45)
    axes.set_xlabel("mean distance of the rig less that of the track,\n± standard error [% of it]")
    return figure


@house_style()
def slip_histograms(edges: Array, shares: Mapping[str, Mapping[str, Array]]) -> Figure:
    """Part of the time at each slip: a panel per test, track beside rig.

    Edges of the classes of |slip| [-], the last one infinite, shape (class + 1,); test -> support -> shares, shape (class,).
    """
    columns = min(3, len(shares))
    rows = math.ceil(len(shares) / columns)
    figure, grid = new_grid(rows, columns, height=max(2.8, 0.6 + 1.7 * rows), sharex=True, sharey=True)
    ends = 100.0 * np.where(np.isfinite(edges), edges, 2.0 * edges[-2] - edges[-3])
    for axes, (name, own) in zip(grid.flat, shares.items(), strict=False):
        for label, one in own.items():
            colour, style = (COLOURS[1], "--") if label == "track" else (COLOURS[0], "-")
            axes.stairs(np.maximum(100.0 * one, 1e-3), ends, label=label, color=colour, linestyle=style, linewidth=1.2)
        axes.set_title(name.replace("_", " "))
        logarithmic(axes, "y")
        axes.set_ylim(0.05, 120.0)
    for axes in grid.flat[len(shares) :]:
        axes.set_visible(False)
    grid[0, 0].legend()
    figure.supxlabel("|wheel speed - train speed| over train speed [%]", fontsize=9.0)
    figure.supylabel("part of the time [%]", fontsize=9.0)
    return figure


@house_style()
def means_with_intervals(
    stops: Sequence[str],
    found: Mapping[str, Sequence[Mapping[str, Any] | None]],
    xlabel: str,
    *,
    dry: Sequence[float | None] = (),
    limits: Sequence[float | None] = (),
    zero: bool = False,
) -> Figure:
    """A line per stop, track and rig beside each other: means with their ends, values of the dry stop, limits; None: none.

    With a line at `zero` for differences.
    """
    figure, (axes,) = new_figure(1, height=1.1 + 0.32 * len(stops))
    for label, ends in found.items():
        shift, colour, marker = (-0.14, COLOURS[1], "s") if label == "track" else (0.14, COLOURS[0], "o")
        shown = [(row + shift, one) for row, one in enumerate(ends) if one is not None and one["mean"] is not None]
        reach = [[abs(one["mean"] - (one["mean"] if one[end] is None else one[end])) for _, one in shown]
                 for end in ("low", "high")]  # fmt: skip
        look: dict[str, Any] = {"fmt": marker, "markersize": 4, "color": colour, "capsize": 2.5}
        axes.errorbar([one["mean"] for _, one in shown], [row for row, _ in shown], xerr=reach, label=label, **look)
    marks: Mapping[str, dict[str, Any]] = {
        "dry": {"marker": "|", "color": GREY},
        "limit": {"marker": "D", "facecolors": "none", "edgecolors": "black"},
    }
    for (label, look), values in zip(marks.items(), (dry, limits), strict=True):
        points = [(value, row) for row, value in enumerate(values) if value is not None]
        if points:
            across, places = zip(*points, strict=True)
            axes.scatter(across, places, s=34, label=label, zorder=4, **look)
    if zero:
        axes.axvline(0.0, color=GREY, linewidth=0.8)
    axes.set_yticks(range(len(stops)), [name.replace("_", " ") for name in stops])
    axes.set(ylim=(len(stops) - 0.5, -0.5), xlabel=xlabel)
    axes.legend(loc="best")
    return figure


@house_style()
def dead_time_curve(
    track: Mapping[float, Mapping[str, Any]], rig: Mapping[str, Any], predicted: tuple[float, float]
) -> Figure:
    """Distance on track [m] over additional dead time [ms], that of the rig, each as mean and standard error.

    Vertical lines: equivalent dead time in closed form, and the least [ms].
    """
    figure, (axes,) = new_figure(1, height=2.8)
    delays, mean, reach = sorted(track), rig["mean"], rig["standard_error"] or 0.0
    means, errors = zip(*((track[d]["mean"], track[d]["standard_error"] or 0.0) for d in delays), strict=True)
    axes.errorbar(delays, means, errors, color=COLOURS[1], marker="o", markersize=4, capsize=3.0, label="track")
    axes.axhline(mean, color=COLOURS[0], linewidth=1.3, label="rig")
    axes.axhspan(mean - reach, mean + reach, color=COLOURS[0], alpha=0.2, linewidth=0.0)
    for value, style in zip(predicted, ("--", ":"), strict=True):
        axes.axvline(value, color=GREY, linestyle=style, linewidth=1.0)
    axes.set(xlabel="additional dead time of the protection on track [ms]", ylabel="mean distance [m]")
    axes.legend()
    return figure


def motions(runs: Mapping[str, tuple[Array, Array]], slide: float) -> Figure:
    """Lateral displacement [mm] of the leading wheelset over times [s], a panel per run; `slide`: its begin [s], or NaN."""
    labels = ["y [mm]"] * len(runs)
    with panels(labels, "time [s]", 1.0 + 1.15 * len(runs), legend=False, sharey=True) as (figure, all_axes):
        for axes, (label, series) in zip(all_axes, runs.items(), strict=True):
            line(axes, *series)
            axes.set_title(label, fontsize=8.0, loc="left", pad=2.0)
            if np.isfinite(slide):
                axes.axvline(slide, color="#b00020", linewidth=1.0, linestyle=(0, (5, 2)))
    return figure


def leading_axle(runs: Mapping[str, xr.Dataset], signals: Sequence[Signal], height: float) -> Figure:
    """A panel per signal of the leading axle or of the train, of a height [inches]; a colour and a style per run, by label."""
    with panels([label for label, _, _ in signals], "time [s]", height) as (figure, axes):
        for panel, (_, signal, factor) in zip(axes, signals, strict=True):
            for number, (label, run) in enumerate(runs.items()):
                values = factor * (run[signal] if isinstance(signal, str) else signal(run))
                style = STYLES[number % len(STYLES)]
                line(panel, run["time"], values.isel(axle=0, missing_dims="ignore"), number, style, label)
    return figure
