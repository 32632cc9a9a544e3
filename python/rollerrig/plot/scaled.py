"""Figures of a test at full scale and on a scaled model mapped back, both in one plot."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from rollerrig.plot.style import COLOURS, calm, house_style, legend_above, new_figure

STYLES = {"full scale": "--", "model": "-"}
Runs = tuple[xr.Dataset, xr.Dataset]
"""At full scale, and of the model mapped back."""


def _line(axes: Axes, time: xr.DataArray, values: xr.DataArray, colour: int, style: str, label: str) -> None:
    axes.plot(
        time.to_numpy(),
        values.to_numpy(),
        color=COLOURS[colour % len(COLOURS)],
        linestyle=style,
        linewidth=0.9,
        label=label.replace("_", " "),
        rasterized=True,
    )


def speeds(runs: Runs, radius: float) -> Figure:
    """Speeds of train and wheels, a panel for each axle."""
    axles = runs[0]["axle"].to_numpy()
    with house_style():
        figure, panels = new_figure(len(axles), height=2.3 + 2.2 * len(axles), sharex=True)
        for axes, axle in zip(panels, axles, strict=True):
            for run, (label, style) in zip(runs, STYLES.items(), strict=True):
                _line(axes, run["time"], 3.6 * run["train_speed"], 5, style, f"train, {label}")
                _line(axes, run["time"], 3.6 * radius * run["axle_speed"].sel(axle=axle), 0, style, f"wheel, {label}")
            axes.set_ylabel(f"{str(axle).replace('_', ' ')}\nspeed [km/h]")
        panels[-1].set_xlabel("time at full scale [s]")
        legend_above(figure, panels[0])
        return figure


def torques(runs: Runs, torque: tuple[xr.DataArray, xr.DataArray]) -> Figure:
    """Torque of brake or motor on the axles, force of the contact, and real sliding of wheel on roller.

    Args:
        runs: of full scale and model.
        torque: on the axles of both, over time and axle [N m].
    """
    with house_style():
        figure, (top, middle, low) = new_figure(3, height=6.2, sharex=True)
        for run, values, (label, style) in zip(runs, torque, STYLES.items(), strict=True):
            for number, axle in enumerate(run["axle"].to_numpy()):
                of = {"axle": axle}
                _line(top, run["time"], 1e-3 * values.sel(of), number, style, f"{axle}, {label}")
                _line(middle, run["time"], 1e-3 * run["contact_force"].sel(of), number, style, "")
                _line(low, run["time"], 1e3 * run["real_sliding"].sel(of), number, style, "")
        top.set_ylabel("torque on\nthe axle [kN m]")
        middle.set_ylabel("contact force\non the axle [kN]")
        low.set_ylabel("sliding of wheel\non roller [mm/s]")
        low.set_xlabel("time at full scale [s]")
        legend_above(figure, top)
        return figure


def lateral(runs: Runs) -> Figure:
    """Lateral displacement of the wheelsets, a panel each."""
    names = [str(body) for body in runs[0]["body"].to_numpy() if str(body).startswith("wheelset")]
    with house_style():
        figure, panels = new_figure(len(names), height=1.8 + 1.8 * len(names), sharex=True)
        for axes, name in zip(panels, names, strict=True):
            for run, (label, style) in zip(runs, STYLES.items(), strict=True):
                _line(axes, run["time"], 1e3 * run["lateral"].sel(body=name), 0 if style == "-" else 1, style, label)
            axes.set_ylabel(f"{name.replace('_', ' ')}\nlateral [mm]")
            calm(axes, 0.01)
        panels[-1].set_xlabel("time at full scale [s]")
        legend_above(figure, panels[0])
        return figure


def differences(full: xr.Dataset, others: Mapping[str, xr.Dataset], radius: float) -> Figure:
    """Speed of the first axle and of the train, model less full scale, and what each violation alone makes of it.

    Args:
        full: at full scale.
        others: by words for the legend: runs at the times of full scale, as far as both ran.
        radius: of the wheels [m].
    """
    with house_style():
        figure, (wheel, train) = new_figure(2, height=4.8, sharex=True)
        for number, (label, run) in enumerate(others.items()):
            part = full.isel(time=slice(0, run.sizes["time"]))
            first = radius * (run["axle_speed"].isel(axle=0) - np.asarray(part["axle_speed"].isel(axle=0)))
            of_train = run["train_speed"] - np.asarray(part["train_speed"])
            style = "-" if number == 0 else (":", "--", "-.")[number % 3]
            _line(wheel, run["time"], first, number, style, label)
            _line(train, run["time"], of_train, number, style, label)
        wheel.set_ylabel("first axle, model less\nfull scale [m/s]")
        train.set_ylabel("train, model less\nfull scale [m/s]")
        train.set_xlabel("time at full scale [s]")
        legend_above(figure, wheel)
        return figure
