"""Figures of the rig's control: comparisons of controllers, and frequency responses."""

import math
from collections.abc import Mapping, Sequence
from typing import Any, Literal, NamedTuple

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from rollerrig.common.arrays import Array, Complex
from rollerrig.plot.style import (
    COLOURS,
    GREY,
    MARKERS,
    colour,
    house_style,
    legend_above,
    line,
    logarithmic,
    look,
    new_figure,
    new_grid,
    panels,
)


class Errors(NamedTuple):
    """Tracking RMS [% of train speed] and ripple of the roller torque [N m], and whether the test ended before its time.

    Of one curve along an axis each has a value per test, or both ends of its range; NaN where it is not known.
    """

    tracking: Sequence[float]
    ripple: Sequence[float]
    ended: Sequence[bool]


LIMIT: dict[str, Any] = {"color": "#b00020", "linewidth": 1.0, "linestyle": (0, (5, 2))}
SHIPPED: dict[str, Any] = {"color": GREY, "linewidth": 1.0, "linestyle": ":"}
"""Looks of a failure limit, and of the case as it is."""


def over_parameter(
    curves: Mapping[str, tuple[Sequence[float], Errors]],
    label: str,
    scale: Literal["log", "linear"],
    base: float | None,
    limits: tuple[float, float],
) -> Figure:
    """Tracking error and ripple over what is varied, a line per curve; a vertical line at the base, the value of the case.

    Curves are values along the axis with their errors, by label.
    Limits: tracking RMS [%] and ripple [N m] from which on a variant fails.
    """
    with panels(("tracking error\nRMS [%]", "torque ripple\nRMS [N m]"), label, 4.6) as (figure, (tracking, ripple)):
        for number, (name, (value, errors)) in enumerate(curves.items()):
            style = {**look(number), "marker": MARKERS[number % len(MARKERS)], "markersize": 4.0}
            x, over = np.array(value), np.array(errors.ended)
            for axes, values in ((tracking, errors.tracking), (ripple, errors.ripple)):
                axes.plot(x, np.where(over, np.nan, values), label=name, **style)
            if over.any():
                y, top = np.full(over.sum(), 0.94 - 0.08 * number), tracking.get_xaxis_transform()
                early = f"{name}: test ended early"
                tracking.plot(x[over], y, "x", color=colour(number), markersize=7.0, transform=top, label=early)
        for axes, limit in zip((tracking, ripple), limits, strict=True):
            logarithmic(axes, "y")
            axes.axhline(limit, **LIMIT)
            axes.set_ylim(bottom=max(axes.get_ylim()[0], 1e-2 * limit if axes is ripple else 0.0))
            if base is not None:
                axes.axvline(base, **SHIPPED)
        if scale == "log":
            logarithmic(ripple)
    return figure


@house_style()
def ranges(bars: Mapping[str, Errors], base: tuple[float, float], limits: tuple[float, float]) -> Figure:
    """Range of tracking error and ripple of every curve, the worst on top; those of the case as it is, limits of failure."""
    figure, axes = new_grid(1, 2, height=1.4 + 0.24 * len(bars), sharey=True, width_ratios=(3, 2))
    tracking, ripple = axes[0]
    rows = np.arange(len(bars))
    for axes, values, limit, shipped in (
        (tracking, [bar.tracking for bar in bars.values()], limits[0], base[0]),
        (ripple, [bar.ripple for bar in bars.values()], limits[1], base[1]),
    ):
        low, high = np.array(values).T
        colours = [COLOURS[1] if h > limit else COLOURS[0] for h in high]
        axes.barh(rows, high - low, left=low, height=0.62, color=colours)
        for end in (low, high):
            axes.plot(end, rows, "|", color="black", markersize=6)
        logarithmic(axes)
        axes.set_xlim(0.5 * max(low.min(), 3e-3 * limit), 2.0 * high.max())
        axes.margins(y=0.01)
        axes.axvline(limit, **LIMIT)
        axes.axvline(shipped, **SHIPPED)
    right = tracking.get_xlim()[1]
    for row in (row for row, bar in enumerate(bars.values()) if any(bar.ended)):
        tracking.annotate("test ended early ✕", (right, row), ha="right", va="center", fontsize=7.5, color=COLOURS[1],
                          bbox={"boxstyle": "square,pad=0.1", "facecolor": "white", "edgecolor": "none"})  # fmt: skip
    tracking.set_yticks(rows, list(bars), fontsize=7.5)
    tracking.invert_yaxis()
    tracking.set_xlabel("tracking error RMS [%]")
    ripple.set_xlabel("torque ripple RMS [N m]")
    return figure


def loop_growth(points: Mapping[str, Sequence[float]]) -> Figure:
    """Growth rate and frequency of the least damped motion over the factor on the gains.

    Args:
        points: `factor`, and rate [1/s] and frequency [Hz] as `rolling_rate`, `rolling_hz`, `vehicle_*`, `measured_*`; NaN
            where nothing grew; `unstable`: 1 where a run did.
    """
    labels = ("growth rate [1/s]\nabove 0: unstable", "frequency [Hz]")
    with panels(labels, "factor on the gains of the PI feedback [-]", 4.8) as (figure, (rate, frequency)):
        x = np.array(points["factor"])
        for axes, end in ((rate, "rate"), (frequency, "hz")):
            axes.plot(x, points[f"rolling_{end}"], "--", color=COLOURS[5], label="computed, wheel and roller alone")
            axes.plot(x, points[f"vehicle_{end}"], "-", color=COLOURS[0], label="computed, with the vehicle")
            axes.plot(x, points[f"measured_{end}"], "o", color=COLOURS[1], label="measured in unstable runs")
        unstable, bottom = np.array(points["unstable"]) > 0.0, rate.get_xaxis_transform()
        for which, marker, name in ((unstable, "x", "an unstable run"), (~unstable, ".", "a stable run")):
            y = np.full(which.sum(), 0.05)
            rate.plot(x[which], y, marker, color=COLOURS[1], markersize=5.0, transform=bottom, label=name)
        rate.axhline(0.0, **LIMIT)
        worst = [v for key in ("vehicle_rate", "measured_rate") for v in points[key] if math.isfinite(v)]
        rate.set_ylim(min(-12.0, *worst), 1.3 * max(10.0, *worst))
        logarithmic(frequency)
        frequency.set_ylim(0.0, None)
    return figure


@house_style()
def courses(runs: Mapping[str, xr.Dataset], radius: float) -> Figure:
    """Leading axle of some runs over time: wheel and virtual wheel, tracking error, roller torque; a column with own scales each.

    Args:
        runs: label -> Dataset with `axle_speed`, `virtual_speed`, `train_speed`, `roller_torque`.
        radius: of the wheels [m].
    """
    figure, grid = new_grid(3, len(runs), height=5.6, sharex=True)
    for (speed, error, torque), (label, run) in zip(grid.T, runs.items(), strict=True):
        axle, time = run.isel(axle=0), run["time"]
        line(speed, time, 3.6 * axle["train_speed"], 5, "--", "virtual train")
        line(speed, time, 3.6 * radius * axle["axle_speed"], 0, "-", "wheel")
        line(speed, time, 3.6 * radius * axle["virtual_speed"], 1, ":", "virtual wheel")
        line(error, time, 100.0 * radius * (axle["axle_speed"] - axle["virtual_speed"]) / axle["train_speed"])
        line(torque, time, 1e-3 * axle["roller_torque"])
        speed.set_title(label, fontsize=8.0)
        torque.set_xlabel("time [s]")
    for axes, text in zip(grid[:, 0], ("speed [km/h]", "tracking error [%]", "roller torque [kN m]"), strict=True):
        axes.set_ylabel(text)
    legend_above(figure, grid[0, 0])
    return figure


Response = tuple[Array, Complex]
"""Frequencies [Hz] and complex amplitudes there."""


def bode_figure(lines: Mapping[str, Response], points: Mapping[str, Response], unit: str) -> Figure:
    """Magnitude and phase over frequency: lines of the linear bench, points as measured, one colour per label."""
    with panels([f"magnitude [dB re 1 {unit}]", "phase [°]"], "frequency [Hz]", 5.0) as (figure, (magnitude, phase)):
        for number, (label, (frequencies, values)) in enumerate(lines.items()):
            angle = np.degrees(np.unwrap(np.angle(values)))
            magnitude.plot(frequencies, 20 * np.log10(np.abs(values)), label=label, **look(number))
            phase.plot(frequencies, angle, **look(number))
            if label not in points:
                continue
            at, measured = points[label]
            there = np.isfinite(measured)
            near = np.interp(at[there], frequencies, angle)
            turned = near + np.degrees(np.angle(measured[there] * np.exp(-1j * np.radians(near))))
            options: dict[str, Any] = {"marker": "o", "markersize": 3.5, "linestyle": "none", "color": colour(number)}
            magnitude.plot(at[there], 20 * np.log10(np.abs(measured[there])), label=f"{label}, measured", **options)
            phase.plot(at[there], turned, **options)
        logarithmic(magnitude)
        logarithmic(phase)
    return figure


@house_style()
def nyquist_figure(lines: Mapping[str, Response], unit: str) -> Figure:
    """The responses in the complex plane, with the point -1 of a loop closed over each."""
    figure, (axes,) = new_figure(height=4.2)
    for number, (label, (_, values)) in enumerate(lines.items()):
        axes.plot(values.real, values.imag, label=label, **look(number))
    axes.plot([-1.0], [0.0], "k+", label="−1")
    axes.set(xlabel=f"real part [{unit}]", ylabel=f"imaginary part [{unit}]")
    axes.legend(loc="best")
    return figure


@house_style()
def poles_and_zeros_figure(poles: Mapping[str, Complex], zeros: Mapping[str, Complex]) -> Figure:
    """Poles as crosses, zeros as circles [1/s], one colour per label."""
    figure, (axes,) = new_figure(height=4.2)
    for number, label in enumerate(poles):
        there = colour(number)
        axes.plot(poles[label].real, poles[label].imag / (2 * np.pi), "x", color=there, ms=5, label=label)
        axes.plot(zeros[label].real, zeros[label].imag / (2 * np.pi), "o", color=there, ms=5, mfc="none")
    axes.axvline(0.0, color="black", lw=0.6)
    axes.set_xscale("symlog", linthresh=1.0)
    axes.set_yscale("symlog", linthresh=1.0)
    axes.set(xlabel="growth rate [1/s]", ylabel="frequency [Hz]")
    axes.legend(loc="best")
    return figure


@house_style()
def front(points: Mapping[str, Sequence[Sequence[float]]], names: Sequence[str], shipped: str, chosen: str) -> Figure:
    """Torque ripple over tracking error of candidates, the front among them as a line.

    Args:
        points: by name tracking RMS [-] and ripple [N m], each as mean, lower and upper end.
        names: of the front, by rising tracking error.
        shipped: name of the case as it is.
        chosen: name of the compromise.
    """
    figure, (axes,) = new_figure(height=4.2)
    shown = {name: np.array(one) * [[100.0], [1.0]] for name, one in points.items()}
    on_front = [shown[name][:, 0] for name in names]
    if on_front:
        axes.plot(*np.array(on_front).T, color=COLOURS[0], label="front")
    for name, one in shown.items():
        reach = np.abs(one[:, 1:] - one[:, :1])
        looks: dict[str, Any] = {
            "fmt": "o",
            "color": COLOURS[0] if name in names else GREY,
            "markersize": 4.0,
            "linewidth": 0.8,
        }
        if name == shipped:
            looks |= {"fmt": "s", "color": COLOURS[1], "markersize": 7.0, "label": "as shipped"}
        elif name == chosen:
            looks |= {"fmt": "D", "markersize": 7.0, "label": "best compromise"}
        axes.errorbar(one[0, 0], one[1, 0], xerr=reach[0][:, None], yerr=reach[1][:, None], **looks)
    for which in ("x", "y"):
        logarithmic(axes, which)
    axes.set_xlabel("tracking error RMS [%]")
    axes.set_ylabel("torque ripple RMS [N m]")
    legend_above(figure, axes)
    return figure
