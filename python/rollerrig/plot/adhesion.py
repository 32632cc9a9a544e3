"""Figures of a test on degraded track and on the rig that reproduces it: the rig full, the track dashed."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from rollerrig.plot.axles import axles_over_time
from rollerrig.plot.style import line, panels


def speeds(track: xr.Dataset, rig: xr.Dataset, radius: float) -> Figure:
    """Speeds of train and wheels: one panel per axle with rig, virtual train and track."""
    axles = [str(axle) for axle in rig["axle"].to_numpy()]
    labels = [f"{axle.replace('_', ' ')}\nspeed [km/h]" for axle in axles]
    with panels(labels, "time [s]", 2.3 + 2.2 * len(axles)) as (figure, found):
        for axes, axle in zip(found, axles, strict=True):
            for run, name, factor, colour, look, label in (
                (track, "train_speed", 3.6, 5, {"style": "--"}, "train, track"),
                (rig, "train_speed", 3.6, 4, {}, "train, virtual"),
                (track, "axle_speed", 3.6 * radius, 1, {"style": "--"}, "wheel, track"),
                (rig, "virtual_speed", 3.6 * radius, 2, {"linewidth": 3.2, "alpha": 0.45}, "wheel, virtual"),
                (rig, "axle_speed", 3.6 * radius, 0, {}, "wheel, rig"),
            ):  # the virtual wheel is a broad band, since the rig's lies on it
                values = run[name].sel(axle=axle) if "axle" in run[name].dims else run[name]
                line(axes, run["time"], factor * values, colour, label=label, **look)
        return figure


def brakes(track: xr.Dataset, rig: xr.Dataset) -> Figure:
    """Cylinder pressures, and what wheel slide protection has done so far."""
    signals = (
        ("cylinder [bar]", "cylinder_pressure", 1e-5),
        ("dump cycles\nso far", "dump_cycles", 1.0),
        ("air taken\nso far [l]", "air", 1e3),
    )
    return axles_over_time({"rig": rig, "track": track}, signals, 6.0)


def first_slide(track: xr.Dataset, rig: xr.Dataset, radius: float) -> Figure:
    """Slip of the wheels over some seconds of sliding, and what wheel slide protection or wheel-slip control does."""
    start = _first_slide(track, radius)
    cut = {label: run.sel(time=slice(start, start + 8.0)) for label, run in (("rig", rig), ("track", track))}
    braked = float(track["dump_cycles"][-1].sum()) > 0
    response = (
        ("cylinder [bar]", "cylinder_pressure", 1e-5) if braked else ("part of\nthe demand", "torque_factor", 1.0)
    )
    slip = ("wheel less\ntrain [m/s]", lambda run: radius * run["axle_speed"] - run["train_speed"], 1.0)
    return axles_over_time(cut, (slip, response), 4.6)


def _first_slide(run: xr.Dataset, radius: float) -> float:
    """Shortly before a wheel first slides by 5 % [s]; 0 if none does."""
    slides = (abs(radius * run["axle_speed"] / run["train_speed"] - 1.0) > 0.05).any("axle").to_numpy()
    return max(0.0, float(run["time"][int(np.argmax(slides))]) - 0.5) if slides.any() else 0.0


def tractions(track: xr.Dataset, rig: xr.Dataset) -> Figure:
    """Torque of the traction motors, and the part of the demand that wheel-slip control leaves."""
    signals = (("traction torque [kN m]", "traction_torque", 1e-3), ("part of the demand", "torque_factor", 1.0))
    return axles_over_time({"rig": rig, "track": track}, signals, 4.4)


def forces(track: xr.Dataset, rig: xr.Dataset, axle_load: float) -> Figure:
    """Creep force of rail or rollers on each axle over its static load [N]: the adhesion used."""
    signals = [("creep force\nover static load [-]", "creep_force", 1.0 / axle_load)]
    return axles_over_time({"rig": rig, "track": track}, signals, 3.2)


def rollers(rig: xr.Dataset) -> Figure:
    """Torque of the roller drives."""
    return axles_over_time({"rig": rig}, [("roller torque\n[kN m]", "roller_torque", 1e-3)], 2.8)


def sliding(rig: xr.Dataset, ideal: xr.Dataset | None, radius: float) -> Figure:
    """Sliding of wheels on rollers, tracking error, and the wheelsets' own motion: with contact model, and pure rolling."""
    signals: tuple[tuple[str, str | Callable[[xr.Dataset], xr.DataArray], float], ...] = (
        ("sliding of wheel\non roller [mm/s]", "real_sliding", 1e3),
        ("wheel less virtual\nwheel [mm/s]", lambda run: run["axle_speed"] - run["virtual_speed"], 1e3 * radius),
        ("wheelset along\nthe track [mm/s]", _own_motion, 1e3),
    )
    runs = {"contact model": rig} | ({"pure rolling": ideal} if ideal is not None else {})
    return axles_over_time(runs, signals, 6.4)


def _own_motion(run: xr.Dataset) -> xr.DataArray:
    return run["longitudinal_velocity"].sel(body=run["axle"].to_numpy()).rename(body="axle")


def errors(track: xr.Dataset, rig: xr.Dataset, radius: float) -> Figure:
    """Rig less track at the same time: wheels, train, distance."""
    count = min(track.sizes["time"], rig.sizes["time"])
    a, b = (run.isel(time=slice(0, count)).drop_vars("time") for run in (track, rig))
    away = rig.isel(time=slice(0, count))
    labels = ("speed, rig\nless track [m/s]", "distance, rig\nless track [m]")
    with panels(labels, "time [s]", 4.4) as (figure, (speed, distance)):
        for number, axle in enumerate(b["axle"].to_numpy()):
            line(speed, away["time"], radius * (b - a)["axle_speed"].sel(axle=axle), number, "-", str(axle))
        line(speed, away["time"], b["train_speed"] - a["train_speed"], 5, "--", "train")
        line(distance, away["time"], b["train_distance"] - a["train_distance"], 5, "--", "train")
        return figure
