"""Figures of runs over time or along a line: motion, sliding, energy, several runs over each other, steady curving."""

from collections.abc import Mapping, Sequence

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from rollerrig.plot.style import (
    GREY,
    MARKERS,
    STYLES,
    calm,
    headline,
    into_axes,
    legend_below,
    line,
    look,
    new_grid,
    panels,
    wheel_lines,
)
from rollerrig.results import COMPLETED, RunInfo
from rollerrig.results.summary import contact_losses

STEADY = 1e-3  # a speed that changes by no more than this part is not worth a panel


@into_axes
def motion_over_time(run: xr.Dataset) -> Figure:
    """Lateral displacement and yaw of the vehicle's bodies, and the running speed where it changes."""
    speed = run["speed"].to_numpy()
    changes = float(np.ptp(speed)) > STEADY * float(np.abs(speed).max())
    labels = ["lateral [mm]", "yaw [mrad]", *(["speed [km/h]"] if changes else [])]
    with panels(labels, "time [s]", 5.6 if changes else 4.4) as (figure, axes):
        for panel, name in zip(axes, ("lateral", "yaw"), strict=False):
            for number, body in enumerate(RunInfo.of(run).moving):
                style = STYLES[number // 2 % len(STYLES)]
                line(panel, run["time"], 1e3 * run[name].sel(body=body), number, style, body)
            calm(panel, 1e-2)
        if changes:
            line(axes[2], run["time"], 3.6 * run["speed"], label="running speed")
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


_SHOWN = {"m": ("mm", 1e3), "rad": ("mrad", 1e3), "N": ("kN", 1e-3), "m/s": ("km/h", 3.6)}
"""Unit of a result -> the one that is shown, and its factor."""


@into_axes
def runs_together(comparison: xr.Dataset) -> Figure:
    """Each signal of `compare_runs` in one panel, a line per run."""
    signals = [str(name) for name, values in comparison.data_vars.items() if "time" in values.dims]
    shown = {name: shown_unit(comparison[name]) for name in signals}
    labels = [f"{name.replace(':', chr(10)).replace('_', ' ')} [{shown[name][0]}]" for name in signals]
    with panels(labels, "time [s]", 1.2 + 1.5 * len(signals)) as (figure, axes):
        for panel, name in zip(axes, signals, strict=True):
            for number, run in enumerate(comparison["run"].to_numpy().tolist()):
                values = shown[name][1] * comparison[name].sel(run=run)
                line(panel, comparison["time"], values, number, STYLES[number % len(STYLES)], str(run))
        return figure


def shown_unit(values: xr.DataArray) -> tuple[str, float]:
    """The unit in which a quantity is shown, and its factor."""
    unit = str(values.attrs["units"])
    return _SHOWN.get(unit, (unit, 1.0))


PANELS = {  # variable -> label and factor of its panel
    "guiding_force": ("guiding force Y [kN]", 1e-3),
    "wheel_load": ("wheel load Q [kN]", 1e-3),
    "derailment_quotient": ("Y/Q [-]", 1.0),
    "guiding_force_sum": ("sum of guiding forces |ΣY| [kN]", 1e-3),
    "wear_number": ("wear number Tγ [N]", 1.0),
    "angle_of_attack": ("angle of attack [mrad]", 1e3),
}


@into_axes
def curving_over_radius(results: xr.Dataset, limits: Mapping[str, float] | None = None) -> Figure:
    """A panel per quantity of `rollerrig.curving`: its largest magnitude of all wheels or wheelsets; limits by variable."""
    figure, grid = new_grid(3, 2, 7.2, 7.6, sharex=True)
    for axes, (name, (label, factor)) in zip(grid.ravel(), PANELS.items(), strict=True):
        values = factor * abs(results[name]).max(results[name].dims[2:])
        for number, deficiency in enumerate(results["cant_deficiency"].to_numpy()):
            line = values.sel(cant_deficiency=deficiency)
            axes.plot(results["radius"], line, marker=MARKERS[number % len(MARKERS)], markersize=3.0,
                      label=f"{1e3 * deficiency:g} mm", **look(number))  # fmt: skip
        if limits and name in limits:
            axes.axhline(factor * limits[name], color=GREY, linestyle=(0, (4, 2)), linewidth=1.0)
        axes.set_ylabel(label)
    for axes in grid[-1]:
        axes.set_xlabel("radius of the curve [m]")
    legend_below(figure, grid[0][0])
    headline(figure, f"{results.attrs['title']}, by cant deficiency; cant {1e3 * results.attrs['cant_m']:g} mm")
    return figure
