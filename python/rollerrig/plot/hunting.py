"""Figures of runs from a disturbance: over time, over speed during a ramp, and limit cycles over speed."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from rollerrig.plot.style import COLOURS, critical_line, house_style, new_figure


def ramp_over_speed(ramps: Mapping[str, xr.Dataset], body: str, critical: Mapping[str, Mapping[str, float]]) -> Figure:
    """Lateral displacement over speed while the rollers are sped up and slowed down again.

    Args:
        ramps: label -> Dataset of `ramp_run`; one panel each.
        body: whose displacement.
        critical: label -> name -> speed [km/h], marked by a vertical line.
    """
    with house_style():
        figure, panels = new_figure(len(ramps), height=0.6 + 2.6 * len(ramps))
        for axes, (label, ramp) in zip(panels, ramps.items(), strict=True):
            speed, lateral = 3.6 * ramp["speed"].to_numpy(), 1e3 * ramp["lateral"].sel(body=body).to_numpy()
            top = int(np.argmax(speed))
            axes.plot(speed[top:], lateral[top:], color="#e6a29a", linewidth=0.7, label="slowing down", rasterized=True)
            axes.plot(
                speed[: top + 1],
                lateral[: top + 1],
                color=COLOURS[0],
                linewidth=0.7,
                label="speeding up",
                rasterized=True,
            )
            perturbations = np.array(json.loads(ramp.attrs["perturbation_times_s"]))
            if perturbations.size:
                at = np.interp(perturbations, ramp["time"].to_numpy(), speed)
                place = axes.get_xaxis_transform()
                axes.plot(
                    at, np.full_like(at, 0.02), "^", color="black", markersize=4, label="perturbation", transform=place
                )
            for name, value in critical.get(label, {}).items():
                if np.isfinite(value):
                    critical_line(axes, value, f"{name} {value:.0f} km/h")
            axes.set_title(label, loc="left")
            axes.set_ylabel("lateral displacement [mm]")
            axes.legend(loc="upper left", ncols=1)
        panels[-1].set_xlabel("speed [km/h]")
        return figure


def hunting_over_time(runs: Sequence[tuple[float, xr.Dataset]], body: str, title: str = "") -> Figure:
    """Lateral displacement over time at constant speeds, one panel per speed.

    Args:
        runs: speed [km/h] and the run's Dataset.
        body: whose displacement.
        title: of the figure.
    """
    with house_style():
        figure, panels = new_figure(len(runs), height=0.7 + 1.25 * len(runs), sharex=True, sharey=True)
        for axes, (speed, run) in zip(panels, runs, strict=True):
            lateral = 1e3 * run["lateral"].sel(body=body).to_numpy()
            axes.plot(run["time"].to_numpy(), lateral, color=COLOURS[0], linewidth=0.9)
            axes.set_title(f"{speed:.0f} km/h", loc="right", fontsize=8, weight="bold", pad=2)
            axes.set_xlim(0.0, float(run["time"][-1]))
            axes.set_ylabel("[mm]")
        panels[0].set_title(title, loc="left")
        panels[-1].set_xlabel("time [s]")
        figure.supylabel(f"lateral displacement of {body.replace('_', ' ')}", fontsize=9)
        return figure


def amplitude_over_speed(
    tables: Mapping[str, xr.Dataset], critical: Mapping[str, float] | None = None, title: str = ""
) -> Figure:
    """Amplitude at the end of runs over speed: zero where the disturbance died out, else that of the limit cycle.

    Args:
        tables: label -> Dataset of `hunting_table`.
        critical: name -> speed [km/h], marked by a vertical line.
        title: of the figure.
    """
    with house_style():
        figure, (axes,) = new_figure()
        for number, (label, table) in enumerate(tables.items()):
            speed, amplitude = table["speed"].to_numpy(), 1e3 * table["amplitude"].to_numpy()
            going = table["persists"].to_numpy() == 1
            colour, marker = COLOURS[number % len(COLOURS)], "os^Dv"[number % 5]
            axes.plot(
                speed[going], amplitude[going], marker + "-", color=colour, markersize=4.5, label=f"{label}: goes on"
            )
            axes.plot(
                speed[~going],
                np.zeros(int((~going).sum())),
                marker,
                color=colour,
                markerfacecolor="none",
                markersize=4.5 + 2.5 * (len(tables) - 1 - number),  # those of several tables lie upon each other
                label=f"{label}: dies out",
            )
        for name, value in (critical or {}).items():
            if np.isfinite(value):
                critical_line(axes, value, f"{name} {value:.0f} km/h")
        axes.set_ylim(bottom=-0.15)
        axes.set_xlabel("speed [km/h]")
        axes.set_ylabel("lateral amplitude at the end [mm]")
        axes.set_title(title, loc="left")
        axes.legend(loc="upper left")
        return figure
