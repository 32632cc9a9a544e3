"""Figures of one run over time: motion of the bodies, force and sliding of the wheels, energy balance."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from rollerrig.plot.into import into_axes
from rollerrig.plot.style import GREY, STYLES, calm, line, panels, wheel_lines
from rollerrig.results import COMPLETED, RunInfo
from rollerrig.results.contact_loss import contact_losses

STEADY = 1e-3
"""A speed that changes by no more than this part is not worth a panel."""


@into_axes
def motion_over_time(run: xr.Dataset) -> Figure:
    """Lateral displacement and yaw of the vehicle's bodies, and the running speed where it changes."""
    speed = run["speed"].to_numpy()
    changes = float(np.ptp(speed)) > STEADY * float(np.abs(speed).max())
    labels = ["lateral [mm]", "yaw [mrad]", *(["speed [km/h]"] if changes else [])]
    with panels(labels, "time [s]", 5.6 if changes else 4.4) as (figure, axes):
        for number, body in enumerate(RunInfo.of(run).moving):
            style = STYLES[number // 2 % len(STYLES)]
            for panel, name in zip(axes, ("lateral", "yaw"), strict=False):
                line(panel, run["time"], 1e3 * run[name].sel(body=body), number, style, body)
        if changes:
            line(axes[2], run["time"], 3.6 * run["speed"], label="running speed")
        for panel in axes[:2]:
            calm(panel, 1e-2)
        _mark_end(axes, run)
        return figure


@into_axes
def sliding_over_time(run: xr.Dataset) -> Figure:
    """Longitudinal creep force and sliding of the wheels, and where they touch on their profiles."""
    signals = {
        "longitudinal creep\nforce [kN]": (1e-3 * run["longitudinal_creep_force"], 1e-2),
        "longitudinal\nsliding [mm/s]": (1e3 * run["longitudinal_sliding"], 1e-2),
        "contact on\nthe wheel S [mm]": (1e3 * run["contact_abscissa"], 1e-1),
    }
    with panels(list(signals), "time [s]", 5.6) as (figure, axes):
        for panel, (values, least) in zip(axes, signals.values(), strict=True):
            wheel_lines(panel, run["time"], values)
            calm(panel, least)
        _mark_end(axes, run)
        return figure


def _mark_end(axes: Sequence[Axes], run: xr.Dataset) -> None:
    """Where a run ended early, and why; what it computed of a wheel in the air before is no motion to be read: grey."""
    status, end = str(run.attrs["status"]), float(run.attrs["stopped_at_s"])
    if status in (*COMPLETED, "interrupted"):
        return
    spells = [loss for loss in contact_losses(run) if loss.wheel == run.attrs["stopped_wheel"]]
    begin = spells[0].longest_from_s if status == "contact_lost" and spells else end
    for panel in axes:
        panel.axvline(end, color=GREY, linestyle=":", linewidth=1.0)
        panel.axvspan(begin, end, color=GREY, alpha=0.3, linewidth=0.0)
    text = f"ended: {status.replace('_', ' ')} "
    axes[0].text(end, 0.97, text, transform=axes[0].get_xaxis_transform(), ha="right", va="top", fontsize="small")


@into_axes
def energy_over_time(run: xr.Dataset) -> Figure:
    """Work put in, heat, change of what is stored, and the residual of their balance."""
    accounts = {
        "work in": ("work_of_drive", "work_of_torque"),
        "heat": ("dissipated_elements", "dissipated_normal", "dissipated_creep"),
        "stored": ("kinetic", "gravity", "elements", "stored_contacts"),
    }
    labels = ("change since the start [kJ]", "residual [J]")
    with panels(labels, "time [s]", 4.2, legend=False) as (figure, (balance, residual)):
        for number, (label, parts) in enumerate(accounts.items()):
            account = run[[f"energy_{part}" for part in parts]].to_array().sum("variable")
            change = 1e-3 * (account - account[:1].to_numpy())
            line(balance, run["time"], change, number, STYLES[number // 2 % len(STYLES)], label)
        line(residual, run["time"], run["energy_residual"], label="residual")
        balance.legend(loc="upper left")
        return figure
