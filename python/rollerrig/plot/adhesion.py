"""Figures of a test on degraded track and on the rig that imitates it, both in one plot."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from rollerrig.plot.style import COLOURS, house_style, legend_above, new_figure

ON = {"track": "--", "rig": "-"}


def _both(axes: Axes, track: xr.Dataset, rig: xr.Dataset, name: str, scale: float = 1.0) -> None:
    """A line per axle: colour the axle, full the rig, dashed the track."""
    for label, run in (("track", track), ("rig", rig)):
        for number, axle in enumerate(run["axle"].to_numpy()):
            _line(axes, run["time"], scale * run[name].sel(axle=axle), number, ON[label], f"{axle}, {label}")


def _line(axes: Axes, time: xr.DataArray, values: xr.DataArray, colour: int, style: str, label: str) -> None:
    text = label.replace("_", " ")
    colour_name = COLOURS[colour % len(COLOURS)]
    axes.plot(
        time.to_numpy(),
        values.to_numpy(),
        color=colour_name,
        linestyle=style,
        linewidth=0.9,
        label=text,
        rasterized=True,
    )


def speeds(track: xr.Dataset, rig: xr.Dataset, radius: float) -> Figure:
    """Speeds of train and wheels: one panel per axle with rig, virtual train and track."""
    axles = rig["axle"].to_numpy()
    with house_style():
        figure, panels = new_figure(len(axles), height=2.3 + 2.2 * len(axles), sharex=True)
        for axes, axle in zip(panels, axles, strict=True):
            _line(axes, track["time"], 3.6 * track["train_speed"], 5, "--", "train, track")
            _line(axes, rig["time"], 3.6 * rig["train_speed"], 5, "-", "train, virtual")
            _line(axes, track["time"], 3.6 * radius * track["axle_speed"].sel(axle=axle), 1, "--", "wheel, track")
            _line(axes, rig["time"], 3.6 * radius * rig["virtual_speed"].sel(axle=axle), 2, ":", "wheel, virtual")
            _line(axes, rig["time"], 3.6 * radius * rig["axle_speed"].sel(axle=axle), 0, "-", "wheel, rig")
            axes.set_ylabel(f"{str(axle).replace('_', ' ')}\nspeed [km/h]")
        panels[-1].set_xlabel("time [s]")
        legend_above(figure, panels[0])
        return figure


def brakes(track: xr.Dataset, rig: xr.Dataset) -> Figure:
    """Cylinder pressures, and what the dump valves do."""
    with house_style():
        figure, (pressure, valve) = new_figure(2, height=4.4, sharex=True)
        _both(pressure, track, rig, "cylinder_pressure", 1e-5)
        _both(valve, track, rig, "valve")
        pressure.set_ylabel("cylinder [bar]")
        valve.set_yticks([0, 1, 2], ["fill", "hold", "vent"])
        valve.set_ylabel("dump valve")
        valve.set_xlabel("time [s]")
        legend_above(figure, pressure)
        return figure


def tractions(track: xr.Dataset, rig: xr.Dataset) -> Figure:
    """Torque of the traction motors, and what anti-slip leaves of the demand."""
    with house_style():
        figure, (torque, factor) = new_figure(2, height=4.4, sharex=True)
        _both(torque, track, rig, "traction_torque", 1e-3)
        _both(factor, track, rig, "torque_factor")
        torque.set_ylabel("traction torque [kN m]")
        factor.set_ylabel("part of the demand")
        factor.set_xlabel("time [s]")
        legend_above(figure, torque)
        return figure


def forces(track: xr.Dataset, rig: xr.Dataset, axle_load: float) -> Figure:
    """Contact force of each axle, and the adhesion it uses."""
    with house_style():
        figure, (force, used) = new_figure(2, height=4.4, sharex=True)
        _both(force, track, rig, "contact_force", 1e-3)
        _both(used, track, rig, "contact_force", 1.0 / axle_load)
        force.set_ylabel("contact force\non the axle [kN]")
        used.set_ylabel("force over\nstatic load [-]")
        used.set_xlabel("time [s]")
        legend_above(figure, force)
        return figure


def rollers(rig: xr.Dataset, radius: float) -> Figure:
    """Torque of the roller drives, real sliding of wheel on roller, and the error of tracking."""
    with house_style():
        figure, (torque, sliding, error) = new_figure(3, height=6.0, sharex=True)
        difference = radius * (rig["axle_speed"] - rig["virtual_speed"])
        for number, axle in enumerate(rig["axle"].to_numpy()):
            _line(torque, rig["time"], 1e-3 * rig["roller_torque"].sel(axle=axle), number, "-", str(axle))
            _line(sliding, rig["time"], 1e3 * rig["real_sliding"].sel(axle=axle), number, "-", str(axle))
            _line(error, rig["time"], 1e3 * difference.sel(axle=axle), number, "-", str(axle))
        torque.set_ylabel("roller torque\n[kN m]")
        sliding.set_ylabel("sliding of wheel\non roller [mm/s]")
        error.set_ylabel("wheel less virtual\nwheel [mm/s]")
        error.set_xlabel("time [s]")
        legend_above(figure, torque)
        return figure


def errors(track: xr.Dataset, rig: xr.Dataset, radius: float) -> Figure:
    """Rig less track at the same time: train, wheels, distance."""
    count = min(track.sizes["time"], rig.sizes["time"])
    a, b = track.isel(time=slice(0, count)), rig.isel(time=slice(0, count))
    with house_style():
        figure, (speed, way) = new_figure(2, height=4.4, sharex=True)
        for number, axle in enumerate(b["axle"].to_numpy()):
            values = radius * (b["axle_speed"].sel(axle=axle) - np.asarray(a["axle_speed"].sel(axle=axle)))
            _line(speed, b["time"], values, number, "-", str(axle))
        _line(speed, b["time"], b["train_speed"] - np.asarray(a["train_speed"]), 5, "--", "train")
        _line(way, b["time"], b["train_distance"] - np.asarray(a["train_distance"]), 5, "--", "train")
        speed.set_ylabel("speed, rig\nless track [m/s]")
        way.set_ylabel("distance, rig\nless track [m]")
        way.set_xlabel("time [s]")
        legend_above(figure, speed)
        return figure
