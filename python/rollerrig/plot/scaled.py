"""Figures of a test at full scale and on a scaled model mapped back, both in one plot."""

from collections.abc import Mapping

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from rollerrig.plot.style import calm, line, panels

STYLES = {"full scale": "--", "model": "-"}
Runs = tuple[xr.Dataset, xr.Dataset]  # at full scale, and of the model mapped back

XLABEL = "time at full scale [s]"


def speeds(runs: Runs, radius: float) -> Figure:
    """Speeds of train and wheels, a panel for each axle."""
    axles = [str(axle) for axle in runs[0]["axle"].to_numpy()]
    labels = [f"{axle.replace('_', ' ')}\nspeed [km/h]" for axle in axles]
    with panels(labels, XLABEL, 2.3 + 2.2 * len(axles)) as (figure, all_axes):
        for axes, axle in zip(all_axes, axles, strict=True):
            for run, (label, style) in zip(runs, STYLES.items(), strict=True):
                line(axes, run["time"], 3.6 * run["train_speed"], 5, style, f"train, {label}")
                line(axes, run["time"], 3.6 * radius * run["axle_speed"].sel(axle=axle), 0, style, f"wheel, {label}")
    return figure


def torques(runs: Runs, torque: tuple[xr.DataArray, xr.DataArray]) -> Figure:
    """Torque of brake or motor on the axles [N m], force of the contact, and real sliding of wheel on roller."""
    labels = ("torque on\nthe axle [kN m]", "contact force\non the axle [kN]", "sliding of wheel\non roller [mm/s]")
    with panels(labels, XLABEL, 6.2) as (figure, (top, middle, low)):
        for run, values, (label, style) in zip(runs, torque, STYLES.items(), strict=True):
            for number, axle in enumerate(run["axle"].to_numpy()):
                line(top, run["time"], 1e-3 * values.sel(axle=axle), number, style, f"{axle}, {label}")
                line(middle, run["time"], 1e-3 * run["contact_force"].sel(axle=axle), number, style)
                line(low, run["time"], 1e3 * run["real_sliding"].sel(axle=axle), number, style)
    return figure


def lateral(runs: Runs) -> Figure:
    """Lateral displacement of the wheelsets, a panel each."""
    names = [str(body) for body in runs[0]["body"].to_numpy() if str(body).startswith("wheelset")]
    labels = [f"{name.replace('_', ' ')}\nlateral [mm]" for name in names]
    with panels(labels, XLABEL, 1.8 + 1.8 * len(names)) as (figure, all_axes):
        for axes, name in zip(all_axes, names, strict=True):
            for number, (run, (label, style)) in enumerate(zip(runs, STYLES.items(), strict=True)):
                line(axes, run["time"], 1e3 * run["lateral"].sel(body=name), 1 - number, style, label)
            calm(axes, 0.01)
    return figure


def differences(full: xr.Dataset, others: Mapping[str, xr.Dataset], radius: float) -> Figure:
    """Speed of the first axle and of the train, model less full scale, and with each violation alone.

    Args:
        full: at full scale.
        others: by words for the legend: runs at the times of full scale, as far as both ran.
        radius: of the wheels [m].
    """
    labels = ("first axle, model less\nfull scale [m/s]", "train, model less\nfull scale [m/s]")
    with panels(labels, XLABEL, 4.8) as (figure, (wheel, train)):
        for number, (label, run) in enumerate(others.items()):
            part = full.isel(time=slice(0, run.sizes["time"]))
            first = radius * (run["axle_speed"].isel(axle=0) - np.asarray(part["axle_speed"].isel(axle=0)))
            style = "-" if number == 0 else (":", "--", "-.")[number % 3]
            line(wheel, run["time"], first, number, style, label)
            line(train, run["time"], run["train_speed"] - np.asarray(part["train_speed"]), number, style, label)
    return figure
