"""Figures of a comparison of rig controllers: errors over what is varied, who fares worst, where the loop rings."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from rollerrig.plot.style import COLOURS, GREY, MARKERS, STYLES, house_style, legend_above, new_figure


@dataclass(frozen=True)
class Curve:
    """Errors along one axis.

    Attributes:
        label: in the legend.
        value: along the axis.
        tracking: RMS [%] of train speed.
        ripple: of the roller torque [N m]; NaN: not known.
        ended: whether the test ended before its time.
    """

    label: str
    value: Sequence[float]
    tracking: Sequence[float]
    ripple: Sequence[float]
    ended: Sequence[bool]


@dataclass(frozen=True)
class Bar:
    """Range of errors of one curve, for a tornado chart; limits as of `Curve`."""

    label: str
    tracking: tuple[float, float]
    ripple: tuple[float, float]
    ended: bool


def _limit(axes: Axes, value: float, across: Literal["x", "y"] = "y") -> None:
    (axes.axhline if across == "y" else axes.axvline)(value, color="#b00020", linewidth=1.0, linestyle=(0, (5, 2)))


def over_parameter(
    curves: Sequence[Curve],
    label: str,
    scale: Literal["log", "linear"],
    base: float | None,
    limits: tuple[float, float],
) -> Figure:
    """Tracking error and ripple over what is varied, a line per curve.

    Args:
        curves: to be compared.
        label: of the axis.
        scale: of the axis.
        base: value of the case, a vertical line.
        limits: tracking RMS [%] and ripple [N m] from which on a variant counts as broken.
    """
    with house_style():
        figure, (tracking, ripple) = new_figure(2, height=4.6, sharex=True)
        for number, curve in enumerate(curves):
            colour = COLOURS[number % len(COLOURS)]
            marker, line = MARKERS[number % len(MARKERS)], STYLES[number % len(STYLES)]
            x, over = np.array(curve.value), np.array(curve.ended)
            for axes, values in ((tracking, np.array(curve.tracking)), (ripple, np.array(curve.ripple))):
                y = np.where(over, np.nan, values)
                axes.plot(x, y, color=colour, marker=marker, linestyle=line, markersize=4.0, label=curve.label)
            if over.any():
                y, top = np.full(over.sum(), 0.94 - 0.08 * number), tracking.get_xaxis_transform()
                name = f"{curve.label}: test ended early"
                tracking.plot(x[over], y, "x", color=colour, markersize=7.0, transform=top, label=name)
        texts = ("tracking error\nRMS [%]", "torque ripple\nRMS [N m]")
        for axes, limit, text in zip((tracking, ripple), limits, texts, strict=True):
            axes.set_yscale("log")
            _limit(axes, limit)
            axes.set_ylim(bottom=max(axes.get_ylim()[0], 1e-2 * limit if axes is ripple else 0.0))
            axes.set_ylabel(text)
            if base is not None:
                axes.axvline(base, color=GREY, linewidth=1.0, linestyle=":")
        ripple.set_xscale(scale)
        ripple.set_xlabel(label)
        legend_above(figure, tracking)
        return figure


def tornado(bars: Sequence[Bar], base: tuple[float, float], limits: tuple[float, float]) -> Figure:
    """Range of tracking error and ripple of every curve, the worst on top.

    Args:
        bars: from the worst on.
        base: of the case as it is.
        limits: from which on a variant counts as broken.
    """
    with house_style():
        figure, panels = new_figure(1, height=1.4 + 0.24 * len(bars))
        figure.clear()
        tracking, ripple = figure.subplots(1, 2, sharey=True, width_ratios=(3, 2))
        del panels
        rows = np.arange(len(bars))
        for axes, values, limit, shipped in (
            (tracking, [bar.tracking for bar in bars], limits[0], base[0]),
            (ripple, [bar.ripple for bar in bars], limits[1], base[1]),
        ):
            low, high = np.array(values).T
            colours = [COLOURS[1] if h > limit else COLOURS[0] for h in high]
            axes.barh(rows, high - low, left=low, height=0.62, color=colours)
            axes.plot(low, rows, "|", color="black", markersize=6)
            axes.plot(high, rows, "|", color="black", markersize=6)
            axes.set_xscale("log")
            axes.set_xlim(0.5 * max(low.min(), 3e-3 * limit), 2.0 * high.max())
            axes.margins(y=0.01)
            _limit(axes, limit, "x")
            axes.axvline(shipped, color=GREY, linewidth=1.0, linestyle=":")
        right = tracking.get_xlim()[1]
        for row, bar in enumerate(bars):
            if bar.ended:
                tracking.annotate("test ended early ✕", (right, row), ha="right", va="center", fontsize=7.5, color=COLOURS[1],
                                  bbox={"boxstyle": "square,pad=0.1", "facecolor": "white", "edgecolor": "none"})  # fmt: skip
        tracking.set_yticks(rows, [bar.label for bar in bars], fontsize=7.5)
        tracking.invert_yaxis()
        tracking.set_xlabel("tracking error RMS [%]")
        ripple.set_xlabel("torque ripple RMS [N m]")
        return figure


def ring_limit(points: Mapping[str, Sequence[float]]) -> Figure:
    """Growth rate and frequency of the fastest growing ring over the factor on the gains.

    Args:
        points: `factor`, and rate [1/s] and frequency [Hz] as `rolling_rate`, `rolling_hz`, `vehicle_*`, `measured_*`; NaN
            where nothing rang; `rang`: 1 where a run did.
    """
    with house_style():
        figure, (rate, frequency) = new_figure(2, height=4.8, sharex=True)
        x = points["factor"]
        for axes, end in ((rate, "rate"), (frequency, "hz")):
            axes.plot(x, points[f"rolling_{end}"], "--", color=COLOURS[5], label="computed, wheel and roller alone")
            axes.plot(x, points[f"vehicle_{end}"], "-", color=COLOURS[0], label="computed, with the vehicle")
            axes.plot(x, points[f"measured_{end}"], "o", color=COLOURS[1], label="measured in quiet runs that rang")
        rang = np.array(points["rang"]) > 0.0
        bottom, at = rate.get_xaxis_transform(), np.array(x)
        for which, marker, name in ((rang, "x", "a quiet run rang"), (~rang, ".", "a quiet run stayed calm")):
            y = np.full(which.sum(), 0.05)
            rate.plot(at[which], y, marker, color=COLOURS[1], markersize=5.0, transform=bottom, label=name)
        rate.axhline(0.0, color="#b00020", linewidth=1.0, linestyle=(0, (5, 2)))
        worst = [v for key in ("vehicle_rate", "measured_rate") for v in points[key] if math.isfinite(v)]
        rate.set_ylim(min(-12.0, *worst), 1.3 * max(10.0, *worst))
        frequency.set_xscale("log")
        rate.set_ylabel("growth rate [1/s]\nabove 0 it rings")
        frequency.set_ylabel("frequency [Hz]")
        frequency.set_ylim(0.0, None)
        frequency.set_xlabel("factor on the gains of the PI feedback [-]")
        legend_above(figure, rate)
        return figure


def courses(runs: Mapping[str, xr.Dataset], radius: float) -> Figure:
    """Leading axle of some runs over time: wheel and virtual wheel, tracking error, roller torque; a column with own scales each.

    Args:
        runs: label -> Dataset with `axle_speed`, `virtual_speed`, `train_speed`, `roller_torque`.
        radius: of the wheels [m].
    """
    with house_style():
        figure, _ = new_figure(1, height=5.6, width=7.2)
        figure.clear()
        grid = figure.subplots(3, len(runs), sharex=True, squeeze=False)
        for column, (label, run) in enumerate(runs.items()):
            speed, error, torque = grid[:, column]
            axle = run.isel(axle=0)
            time = run["time"].to_numpy()
            for values, style, colour, name in (
                (axle["train_speed"], "--", 5, "virtual train"),
                (radius * axle["axle_speed"], "-", 0, "wheel"),
                (radius * axle["virtual_speed"], ":", 1, "virtual wheel"),
            ):
                line: dict[str, Any] = {"color": COLOURS[colour], "linewidth": 0.9, "label": name}
                speed.plot(time, 3.6 * values, style, rasterized=True, **line)
            away = 100.0 * radius * (axle["axle_speed"] - axle["virtual_speed"]) / axle["train_speed"]
            error.plot(time, away, color=COLOURS[0], linewidth=0.8, rasterized=True)
            torque.plot(time, 1e-3 * axle["roller_torque"], color=COLOURS[0], linewidth=0.6, rasterized=True)
            speed.set_title(label, fontsize=8.0)
            torque.set_xlabel("time [s]")
        for axes, text in zip(grid[:, 0], ("speed [km/h]", "tracking error [%]", "roller torque [kN m]"), strict=True):
            axes.set_ylabel(text)
        legend_above(figure, grid[0, 0])
        return figure
