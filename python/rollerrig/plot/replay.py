"""Figures of a replay: what the controller of a rig makes of a log, beside what was measured."""

from __future__ import annotations

import xarray as xr
from matplotlib.figure import Figure

from rollerrig.plot.style import line, panels


def forces_over_time(found: xr.Dataset) -> Figure:
    """Contact force of each axle over its static load: as estimated at the instant, without the delay, with its band [-]."""
    axles, time = found["axle"].to_numpy(), found["time"]
    labels = [f"force over load\n{axle.replace('_', ' ')} [-]" for axle in axles]
    with panels(labels, "time [s]", 1.0 + 1.8 * len(labels)) as (figure, panel):
        for axle, axes in zip(axles, panel, strict=True):
            own = found.sel(axle=axle)
            load = float(own["axle_load"])
            for sign, label in ((1.0, "95 %"), (-1.0, "")) if found.attrs["force_noise"] > 0.0 else ():
                line(axes, time, (own["force"] + sign * own["force_band"]) / load, 5, ":", label, linewidth=0.6)
            line(axes, time, own["force_at_once"] / load, 1, "--", "as estimated at the instant")
            line(axes, time, own["force"] / load, 0, "-", "without the delay")
            if "creep_force" in own:
                line(axes, time, own["creep_force"] / load, 2, "-.", "reference of the log")
        return figure


def torques_over_time(found: xr.Dataset) -> Figure:
    """Torque of each axle as drive and speeds say, and as brake and motor say [kN m]."""
    axles, time = found["axle"].to_numpy(), found["time"]
    labels = [f"torque\n{axle.replace('_', ' ')} [kN m]" for axle in axles]
    with panels(labels, "time [s]", 1.0 + 1.5 * len(labels)) as (figure, panel):
        for axle, axes in zip(axles, panel, strict=True):
            own = found.sel(axle=axle)
            line(axes, time, 1e-3 * own["torque"], 0, "-", "by drive and speeds")
            line(axes, time, 1e-3 * own["torque_expected"], 1, "--", "by brake and motor")
        return figure


def speeds_over_time(found: xr.Dataset, radius: float) -> Figure:
    """Circumference of measured and virtual wheels, and the virtual train [km/h]; radius of the wheels [m]."""
    axles, time = found["axle"].to_numpy(), found["time"]
    labels = [f"speed\n{axle.replace('_', ' ')} [km/h]" for axle in axles]
    with panels(labels, "time [s]", 1.0 + 1.5 * len(labels)) as (figure, panel):
        for axle, axes in zip(axles, panel, strict=True):
            own = found.sel(axle=axle)
            line(axes, time, 3.6 * found["train_speed"], 5, "-.", "virtual train")
            line(axes, time, 3.6 * radius * own["axle_speed"], 0, "-", "wheel, measured")
            line(axes, time, 3.6 * radius * own["virtual_axle_speed"], 1, "--", "wheel of the virtual train")
        return figure
