"""Figures of lateral motion during a slide, on the rig and on track in the same axes."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import xarray as xr
from matplotlib.figure import Figure
from numpy.typing import NDArray

from rollerrig.plot.style import COLOURS, GREY, STYLES, house_style, legend_above, new_figure

Array = NDArray[np.float64]


def motions(runs: Mapping[str, tuple[Array, Array]], slide: float) -> Figure:
    """Lateral displacement of the leading wheelset over time, a panel per run.

    Args:
        runs: label -> times [s] and displacement [mm].
        slide: when the wheels begin to slide [s]; NaN: they do not.
    """
    with house_style():
        figure, panels = new_figure(len(runs), height=1.0 + 1.15 * len(runs), sharex=True, sharey=True)
        for axes, (label, (time, lateral)) in zip(panels, runs.items(), strict=True):
            axes.plot(time, lateral, color=COLOURS[0], linewidth=0.7, rasterized=True)
            axes.set_title(label, fontsize=8.0, loc="left", pad=2.0)
            axes.set_ylabel("y [mm]")
            if np.isfinite(slide):
                axes.axvline(slide, color="#b00020", linewidth=1.0, linestyle=(0, (5, 2)))
        panels[-1].set_xlabel("time [s]")
        return figure


def amplitudes(runs: Mapping[str, tuple[Array, Array]], slips: Mapping[str, tuple[Array, Array]]) -> Figure:
    """Amplitude of hunting over time above, slip of the leading wheelset below.

    Args:
        runs: label -> times [s] and amplitude [mm].
        slips: label -> times [s] and slip [%].
    """
    with house_style():
        figure, (size, slip) = new_figure(2, height=4.6, sharex=True)
        for axes, lines in ((size, runs), (slip, slips)):
            for number, (label, (time, values)) in enumerate(lines.items()):
                axes.plot(time, values, STYLES[number % 4], color=COLOURS[number], linewidth=1.1, label=label)
        size.set_yscale("log")
        size.set_ylim(1e-3, None)
        size.set_ylabel("amplitude of the\nleading wheelset [mm]")
        slip.set_ylabel("slip of the leading\nwheelset [%]")
        slip.set_xlabel("time [s]")
        legend_above(figure, size)
        return figure


def disturbed_control(runs: Mapping[str, xr.Dataset], radius: float) -> Figure:
    """Tracking error and real sliding of the leading wheelset over time, a line per run.

    Args:
        runs: label -> Dataset of a rig.
        radius: of the wheels [m].
    """
    with house_style():
        figure, (error, sliding) = new_figure(2, height=4.6, sharex=True)
        for number, (label, run) in enumerate(runs.items()):
            axle = run.isel(axle=0)
            away = 100.0 * radius * (axle["axle_speed"] - axle["virtual_speed"]) / axle["train_speed"]
            for axes, values in ((error, away), (sliding, 1e3 * axle["real_sliding"])):
                axes.plot(run["time"], values, color=COLOURS[number], linewidth=0.8, label=label, rasterized=True)
        error.set_ylabel("tracking error\n[% of train speed]")
        sliding.set_ylabel("sliding of wheel\non roller [mm/s]")
        sliding.set_xlabel("time [s]")
        legend_above(figure, error)
        return figure


def creep_forces(runs: Mapping[str, tuple[Array, Array, Array]]) -> Figure:
    """Creep forces of the leading left wheel over time: along and across, a column per run.

    Args:
        runs: label -> times [s], force along and force across the track [kN].
    """
    with house_style():
        figure, _ = new_figure(1, height=4.0)
        figure.clear()
        grid = figure.subplots(2, len(runs), sharex=True, sharey="row", squeeze=False)
        for column, (label, (time, along, across)) in enumerate(runs.items()):
            for axes, values in zip(grid[:, column], (along, across), strict=True):
                axes.plot(time, values, color=COLOURS[column], linewidth=0.7, rasterized=True)
            grid[0, column].set_title(label, fontsize=8.0)
            grid[1, column].set_xlabel("time [s]")
        grid[0, 0].set_ylabel("creep force along [kN]")
        grid[1, 0].set_ylabel("creep force across [kN]")
        return figure


def viscous(expected: Array, force: Array, slope: float) -> Figure:
    """Lateral creep force of sliding wheels over the closed form.

    Args:
        expected: -F v_y / w [N].
        force: of the run [N].
        slope: of the line through both.
    """
    with house_style():
        figure, (axes,) = new_figure(1, height=3.6, width=5.2)
        axes.plot(
            expected,
            force,
            ".",
            color=COLOURS[0],
            markersize=2.0,
            label="axles on track",
            rasterized=True,
        )
        ends = np.array([expected.min(), expected.max()])
        axes.plot(ends, ends, "--", color=GREY, label="Coulomb: opposite to sliding")
        axes.plot(ends, slope * ends, "-", color=COLOURS[1], linewidth=1.0, label=f"slope {slope:.2f}")
        axes.set_xlabel("-F v_y / w, both wheels [N]")
        axes.set_ylabel("lateral creep force\nof the axle [N]")
        axes.legend(fontsize=8.0)
        return figure
