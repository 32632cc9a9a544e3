"""Figures of one run over time: how the bodies move, what the wheels carry, how they slide, whether energy is kept."""

from __future__ import annotations

import json

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from rollerrig.plot.style import COLOURS, STYLES, house_style, new_figure


def motion_over_time(run: xr.Dataset) -> Figure:
    """Lateral displacement and yaw of the vehicle's bodies, and the running speed."""
    bodies = json.loads(run.attrs["vehicle_bodies"])
    with house_style():
        figure, (lateral, yaw, speed) = new_figure(3, height=5.6, sharex=True)
        for number, body in enumerate(bodies):
            _line(lateral, run["time"], 1e3 * run["lateral"].sel(body=body), number, body)
            _line(yaw, run["time"], 1e3 * run["yaw"].sel(body=body), number, body)
        _line(speed, run["time"], 3.6 * run["speed"], 0, "running speed")
        lateral.set_ylabel("lateral [mm]")
        yaw.set_ylabel("yaw [mrad]")
        speed.set_ylabel("speed [km/h]")
        speed.set_xlabel("time [s]")
        lateral.legend(loc="upper right", ncols=len(bodies))
        return figure


def forces_over_time(run: xr.Dataset) -> Figure:
    """Vertical, lateral and longitudinal contact force of every wheel."""
    names = {"vertical_force": "vertical Q", "lateral_force": "lateral Y", "longitudinal_force": "longitudinal"}
    with house_style():
        figure, panels = new_figure(3, height=5.6, sharex=True)
        for axes, (name, label) in zip(panels, names.items(), strict=True):
            for number, wheel in enumerate(run["wheel"].to_numpy()):
                _line(axes, run["time"], 1e-3 * run[name].sel(wheel=wheel), number, str(wheel))
            axes.set_ylabel(f"{label} [kN]")
        panels[-1].set_xlabel("time [s]")
        panels[0].legend(loc="upper right", ncols=2)
        return figure


def sliding_over_time(run: xr.Dataset) -> Figure:
    """Longitudinal sliding of the wheels, and where they touch on their profiles."""
    with house_style():
        figure, (sliding, place) = new_figure(2, height=4.2, sharex=True)
        for number, wheel in enumerate(run["wheel"].to_numpy()):
            _line(sliding, run["time"], 1e3 * run["longitudinal_sliding"].sel(wheel=wheel), number, str(wheel))
            _line(place, run["time"], 1e3 * run["contact_abscissa"].sel(wheel=wheel), number, str(wheel))
        sliding.set_ylabel("longitudinal sliding [mm/s]")
        place.set_ylabel("contact on the wheel S [mm]")
        place.set_xlabel("time [s]")
        sliding.legend(loc="upper right", ncols=2)
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
        label=label,
        rasterized=True,
    )
