"""Figures of lateral motion during a slide, on the rig and on track in the same axes."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.figure import Figure
from numpy.typing import NDArray

from rollerrig.plot.log_axis import logarithmic
from rollerrig.plot.style import COLOURS, GREY, STYLES, house_style, line, new_figure, new_grid, panels

Array = NDArray[np.float64]


def motions(runs: Mapping[str, tuple[Array, Array]], slide: float) -> Figure:
    """Lateral displacement of the leading wheelset over time, a panel per run.

    Args:
        runs: label -> times [s] and displacement [mm].
        slide: when the wheels begin to slide [s]; NaN: they do not.
    """
    labels = ["y [mm]"] * len(runs)
    with panels(labels, "time [s]", 1.0 + 1.15 * len(runs), legend=False, sharey=True) as (figure, all_axes):
        for axes, (label, series) in zip(all_axes, runs.items(), strict=True):
            line(axes, *series)
            axes.set_title(label, fontsize=8.0, loc="left", pad=2.0)
            if np.isfinite(slide):
                axes.axvline(slide, color="#b00020", linewidth=1.0, linestyle=(0, (5, 2)))
    return figure


def amplitudes(runs: Mapping[str, tuple[Any, Any]], slips: Mapping[str, tuple[Any, Any]]) -> Figure:
    """Amplitude of hunting over time above, slip of the leading wheelset below.

    Args:
        runs: label -> times [s] and amplitude [mm].
        slips: label -> times [s] and slip [%].
    """
    labels = ("amplitude of the\nleading wheelset [mm]", "slip of the leading\nwheelset [%]")
    with panels(labels, "time [s]", 4.6) as (figure, all_axes):
        for axes, series in zip(all_axes, (runs, slips), strict=True):
            for number, (label, values) in enumerate(series.items()):
                line(axes, *values, number, STYLES[number % len(STYLES)], label, linewidth=1.1)
        logarithmic(all_axes[0], "y")
        all_axes[0].set_ylim(1e-3, None)
    return figure


def disturbed_control(runs: Mapping[str, xr.Dataset], radius: float) -> Figure:
    """Tracking error and real sliding of the leading wheelset over time, a line per run.

    Args:
        runs: label -> Dataset of a rig.
        radius: of the wheels [m].
    """
    labels = ("tracking error\n[% of train speed]", "sliding of wheel\non roller [mm/s]")
    with panels(labels, "time [s]", 4.6) as (figure, (error, sliding)):
        for number, (label, run) in enumerate(runs.items()):
            axle = run.isel(axle=0)
            relative = radius * (axle["axle_speed"] - axle["virtual_speed"]) / axle["train_speed"]
            line(error, run["time"], 100.0 * relative, number, label=label)
            line(sliding, run["time"], 1e3 * axle["real_sliding"], number, label=label)
    return figure


def creep_forces(runs: Mapping[str, tuple[Any, Any, Any]]) -> Figure:
    """Creep forces of the leading left wheel over time: along and across, a column per run.

    Args:
        runs: label -> times [s], force along and force across the track [kN].
    """
    with house_style():
        figure, grid = new_grid(2, len(runs), height=4.0, sharex=True, sharey="row")
        for column, (label, (time, along, across)) in enumerate(runs.items()):
            for axes, values in zip(grid[:, column], (along, across), strict=True):
                line(axes, time, values, column)
            grid[0, column].set_title(label, fontsize=8.0)
            grid[1, column].set_xlabel("time [s]")
        grid[0, 0].set_ylabel("creep force along [kN]")
        grid[1, 0].set_ylabel("creep force across [kN]")
    return figure


def viscous(expected: Array, force: Array, slope: float) -> Figure:
    """Lateral creep force of sliding wheels over the closed form.

    Args:
        expected: -F v_y / v_s [N].
        force: of the run [N].
        slope: of the line through both.
    """
    with house_style():
        figure, (axes,) = new_figure(1, height=3.6, width=5.2)
        line(axes, expected, force, 0, "", "axles on track", marker=".", markersize=2.0)
        ends = np.array([expected.min(), expected.max()])
        axes.plot(ends, ends, "--", color=GREY, label="Coulomb: opposite to sliding")
        axes.plot(ends, slope * ends, "-", color=COLOURS[1], linewidth=1.0, label=f"slope {slope:.2f}")
        axes.set_xlabel("-F v_y / v_s, both wheels [N]")
        axes.set_ylabel("lateral creep force\nof the axle [N]")
        axes.legend(fontsize=8.0)
    return figure
