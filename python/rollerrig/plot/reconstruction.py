"""Figures of a reconstructed rail: its friction over distance, and the measured stop beside the computed one."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from rollerrig.plot.style import GREY, line, panels

if TYPE_CHECKING:
    from rollerrig.analysis.adhesion_reconstruction import StopLog


def friction_over_distance(rail: xr.Dataset) -> Figure:
    """Friction at no slip of a reconstructed rail, of each axle alone, and adhesion used [-]."""
    along = rail["distance"].to_numpy()
    with panels(("friction\nand adhesion [-]",), "distance [m]", 3.2) as (figure, (axes,)):
        for k, axle in enumerate(rail["axle"].to_numpy()):
            one = rail.sel(axle=axle)
            line(axes, along, one["friction_of_axle"], k + 1, "none", f"friction, {axle}", marker="o", markersize=3.0)
            line(axes, along, one["used_adhesion"], k + 1, ":", f"used, {axle}")
        line(axes, along, rail["friction"], 0, "-", "friction", linewidth=1.6)
        axes.set_ylim(bottom=0.0)
        return figure


def stop_over_time(log: StopLog, run: xr.Dataset, radius: float) -> Figure:
    """Speeds of train and wheels and brake pressures, measured and computed; radius of the wheels [m]."""
    labels = ["speed [km/h]", *(f"{axle.replace('_', ' ')}\n[km/h]" for axle in log.axles), "pressure [bar]"]
    time, clock = log.time - log.time[0], run["time"].to_numpy()
    with panels(labels, "time [s]", 1.0 + 1.3 * len(labels)) as (figure, axes):
        line(axes[0], time, 3.6 * log.train_speed, 0, "-", "train, measured")
        line(axes[0], clock, 3.6 * run["train_speed"], 1, "--", "train, computed")
        for k, axle in enumerate(log.axles):
            own = run.sel(axle=axle)
            line(axes[k + 1], time, 3.6 * radius * log.axle_speed[:, k], 0, "-", "measured")
            line(axes[k + 1], clock, 3.6 * radius * own["axle_speed"], 1, "--", "computed")
        line(axes[-1], time, 1e-5 * np.mean(log.pressure, axis=1), 0, "-", "mean of the axles, measured")
        line(axes[-1], clock, 1e-5 * run["cylinder_pressure"].mean("axle"), 1, "--", "computed")
        for one in axes:
            one.axhline(0.0, color=GREY, linewidth=0.6)
        return figure
