"""Figures of one run over time: how the bodies move, how the wheels pull and slide, whether energy is kept."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from rollerrig.plot.style import COLOURS, STYLES, calm, house_style, legend_above, new_figure, wheel_lines
from rollerrig.results import RunInfo

STEADY = 1e-3
"""A speed that changes by no more than this part is not worth a panel."""


def motion_over_time(run: xr.Dataset) -> Figure:
    """Lateral displacement and yaw of the vehicle's bodies, and the running speed where it changes."""
    bodies = RunInfo.of(run).moving
    speed = run["speed"].to_numpy()
    changes = float(np.ptp(speed)) > STEADY * float(np.abs(speed).max())
    with house_style():
        figure, panels = new_figure(3 if changes else 2, height=5.6 if changes else 4.4, sharex=True)
        lateral, yaw = panels[:2]
        for number, body in enumerate(bodies):
            _line(lateral, run["time"], 1e3 * run["lateral"].sel(body=body), number, body)
            _line(yaw, run["time"], 1e3 * run["yaw"].sel(body=body), number, body)
        if changes:
            _line(panels[2], run["time"], 3.6 * run["speed"], 0, "running speed")
            panels[2].set_ylabel("speed [km/h]")
        lateral.set_ylabel("lateral [mm]")
        yaw.set_ylabel("yaw [mrad]")
        panels[-1].set_xlabel("time [s]")
        calm(lateral, 1e-2)
        calm(yaw, 1e-2)
        legend_above(figure, lateral)
        return figure


def sliding_over_time(run: xr.Dataset) -> Figure:
    """Longitudinal force and sliding of the wheels, and where they touch on their profiles."""
    with house_style():
        figure, (force, sliding, place) = new_figure(3, height=5.6, sharex=True)
        wheel_lines(force, run["time"], 1e-3 * run["longitudinal_force"])
        wheel_lines(sliding, run["time"], 1e3 * run["longitudinal_sliding"])
        wheel_lines(place, run["time"], 1e3 * run["contact_abscissa"])
        force.set_ylabel("longitudinal\nforce [kN]")
        sliding.set_ylabel("longitudinal\nsliding [mm/s]")
        place.set_ylabel("contact on\nthe wheel S [mm]")
        place.set_xlabel("time [s]")
        for axes, least in ((force, 1e-2), (sliding, 1e-2), (place, 1e-1)):
            calm(axes, least)
        legend_above(figure, force)
        return figure


def energy_over_time(run: xr.Dataset) -> Figure:
    """Work put in, heat, change of what is stored, and the residual of their balance."""
    accounts = {
        "work in": run["energy_work_of_drive"] + run["energy_work_of_torque"],
        "heat": run["energy_dissipated_elements"] + run["energy_dissipated_normal"] + run["energy_dissipated_creep"],
        "stored": run["energy_kinetic"]
        + run["energy_gravity"]
        + run["energy_elements"]
        + run["energy_stored_contacts"],
    }
    with house_style():
        figure, (balance, residual) = new_figure(2, height=4.2, sharex=True)
        for number, (label, account) in enumerate(accounts.items()):
            _line(balance, run["time"], 1e-3 * (account - account[:1].to_numpy()), number, label)
        _line(residual, run["time"], run["energy_residual"], 0, "residual")
        balance.set_ylabel("change since the start [kJ]")
        residual.set_ylabel("residual [J]")
        residual.set_xlabel("time [s]")
        balance.legend(loc="upper left")
        return figure


def _line(axes: Axes, time: xr.DataArray, values: xr.DataArray, number: int, label: str) -> None:
    axes.plot(
        np.asarray(time),
        np.asarray(values),
        color=COLOURS[number % len(COLOURS)],
        linestyle=STYLES[number // 2 % len(STYLES)],
        linewidth=0.9,
        label=label.replace("_", " "),
        rasterized=True,
    )
