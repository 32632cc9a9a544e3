"""Figures of a test on degraded track and on the rig that reproduces it, both in one plot."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from rollerrig.plot.style import COLOURS, GREY, house_style, legend_above, new_figure

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
    """Cylinder pressures, and what the slide protection has done so far."""
    with house_style():
        figure, (pressure, vents, air) = new_figure(3, height=6.0, sharex=True)
        _both(pressure, track, rig, "cylinder_pressure", 1e-5)
        _both(vents, track, rig, "dump_cycles")
        _both(air, track, rig, "air", 1e3)
        pressure.set_ylabel("cylinder [bar]")
        vents.set_ylabel("dump cycles\nso far")
        air.set_ylabel("air taken\nso far [l]")
        air.set_xlabel("time [s]")
        legend_above(figure, pressure)
        return figure


def closer(track: xr.Dataset, rig: xr.Dataset, radius: float) -> Figure:
    """Slip of the wheels over some seconds of sliding, and what slide protection or wheel-slip control does."""
    start = _first_slide(track, radius)
    cut = [run.sel(time=slice(start, start + 8.0)) for run in (track, rig)]
    with house_style():
        figure, (slip, act) = new_figure(2, height=4.6, sharex=True)
        for label, run in zip(ON, cut, strict=True):
            for number, axle in enumerate(run["axle"].to_numpy()):
                values = radius * run["axle_speed"].sel(axle=axle) - run["train_speed"]
                _line(slip, run["time"], values, number, ON[label], f"{axle}, {label}")
        braked = float(track["dump_cycles"][-1].sum()) > 0
        name, scale = ("cylinder_pressure", 1e-5) if braked else ("torque_factor", 1.0)
        _both(act, cut[0], cut[1], name, scale)
        slip.set_ylabel("wheel less\ntrain [m/s]")
        act.set_ylabel("cylinder [bar]" if braked else "part of\nthe demand")
        act.set_xlabel("time [s]")
        legend_above(figure, slip)
        return figure


def _first_slide(run: xr.Dataset, radius: float) -> float:
    """Shortly before a wheel first slides by 5 % [s]; 0 if none does."""
    slides = (abs(radius * run["axle_speed"] / run["train_speed"] - 1.0) > 0.05).any("axle").to_numpy()
    return max(0.0, float(run["time"][int(np.argmax(slides))]) - 0.5) if slides.any() else 0.0


def tractions(track: xr.Dataset, rig: xr.Dataset) -> Figure:
    """Torque of the traction motors, and what wheel-slip control leaves of the demand."""
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
    """Force of rail or rollers on each axle over its static load: the adhesion used."""
    with house_style():
        figure, (used,) = new_figure(1, height=3.2)
        _both(used, track, rig, "contact_force", 1.0 / axle_load)
        used.set_ylabel("contact force\nover static load [-]")
        used.set_xlabel("time [s]")
        legend_above(figure, used)
        return figure


def rollers(rig: xr.Dataset) -> Figure:
    """Torque of the roller drives."""
    with house_style():
        figure, (torque,) = new_figure(1, height=2.8)
        for number, axle in enumerate(rig["axle"].to_numpy()):
            _line(torque, rig["time"], 1e-3 * rig["roller_torque"].sel(axle=axle), number, "-", str(axle))
        torque.set_ylabel("roller torque\n[kN m]")
        torque.set_xlabel("time [s]")
        legend_above(figure, torque)
        return figure


def sliding(rig: xr.Dataset, ideal: xr.Dataset | None, radius: float) -> Figure:
    """Sliding of wheels on rollers, error of tracking, and the wheelsets' own motion: with it (full), without (dotted)."""
    runs = [("contact model", rig, "-")] + ([("ideal rolling", ideal, ":")] if ideal is not None else [])
    with house_style():
        figure, (sliding, error, own) = new_figure(3, height=6.4, sharex=True)
        for label, run, style in runs:
            difference = radius * (run["axle_speed"] - run["virtual_speed"])
            for number, axle in enumerate(run["axle"].to_numpy()):
                name = f"{axle}, {label}"
                _line(sliding, run["time"], 1e3 * run["real_sliding"].sel(axle=axle), number, style, name)
                _line(error, run["time"], 1e3 * difference.sel(axle=axle), number, style, name)
                own_speed = run["longitudinal_velocity"].sel(body=str(axle))
                _line(own, run["time"], 1e3 * own_speed, number, style, name)
        sliding.set_ylabel("sliding of wheel\non roller [mm/s]")
        error.set_ylabel("wheel less virtual\nwheel [mm/s]")
        own.set_ylabel("wheelset along\nthe track [mm/s]")
        own.set_xlabel("time [s]")
        legend_above(figure, sliding)
        return figure


def causes(shares: Mapping[str, float], spread: Mapping[str, float | None]) -> Figure:
    """Bars of what each cause adds to the difference in distance, and the range of chance."""
    with house_style():
        figure, (axes,) = new_figure(1, height=2.6)
        chance = 50.0 * max((value for value in spread.values() if value is not None), default=0.0)
        if chance > 0.0:
            axes.axvspan(-chance, chance, color=GREY, alpha=0.35, linewidth=0)
        names = [*shares, "together"]
        values = [100.0 * share for share in (*shares.values(), sum(shares.values()))]
        axes.barh(names, values, height=0.55, color=[COLOURS[0]] * len(shares) + [COLOURS[1]])
        for row, value in enumerate(values):
            axes.annotate(
                f"{value:+.2f}",
                (value, row),
                (4 if value >= 0 else -4, 0),
                textcoords="offset points",
                va="center",
                ha="left" if value >= 0 else "right",
            )
        axes.invert_yaxis()
        axes.axvline(0.0, color="black", linewidth=0.8)
        axes.margins(x=0.15)
        axes.set_xlabel("distance of the rig less that of the track [% of it]")
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
