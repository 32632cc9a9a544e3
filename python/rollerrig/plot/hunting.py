"""Figures of runs from a disturbance: over time, over speed during a ramp, and limit cycles over speed."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from rollerrig.plot.into import into_axes
from rollerrig.plot.style import colour, critical_lines, line, panels


@into_axes
def ramp_over_speed(
    ramps: Mapping[str, xr.Dataset], body: str, critical: Mapping[str, Mapping[str, float | tuple[float, float]]]
) -> Figure:
    """Lateral displacement over speed while the rollers are sped up and slowed down again.

    Args:
        ramps: label -> Dataset of `ramp_run`; one panel each.
        body: whose displacement.
        critical: label -> name -> speed, or both ends of its interval [km/h], marked.
    """
    labels = ["lateral displacement [mm]"] * len(ramps)
    height = 0.6 + 2.6 * len(ramps)
    with panels(labels, "speed [km/h]", height, legend=False, sharex=False) as (figure, found):
        for axes, (label, ramp) in zip(found, ramps.items(), strict=True):
            speed, lateral = 3.6 * ramp["speed"].to_numpy(), 1e3 * ramp["lateral"].sel(body=body).to_numpy()
            top = int(np.argmax(speed))
            line(axes, speed[top:], lateral[top:], label="slowing down", color="#e6a29a", linewidth=0.7)
            line(axes, speed[: top + 1], lateral[: top + 1], label="speeding up", linewidth=0.7)
            perturbations = np.array(json.loads(ramp.attrs["perturbation_times_s"]))
            if perturbations.size:
                at, bottom = np.interp(perturbations, ramp["time"].to_numpy(), speed), axes.get_xaxis_transform()
                marks = {"color": "black", "markersize": 4, "label": "perturbation", "transform": bottom}
                axes.plot(at, np.full_like(at, 0.02), "^", **marks)  # type: ignore[arg-type]
            critical_lines(axes, critical.get(label, {}))
            axes.set_title(label, loc="left")
            axes.legend(loc="upper left", ncols=1)
        return figure


@into_axes
def hunting_over_time(runs: Sequence[tuple[float, xr.Dataset]], body: str, title: str = "") -> Figure:
    """Lateral displacement over time at constant speeds, one panel per speed.

    Args:
        runs: speed [km/h] and the run's Dataset.
        body: whose displacement.
        title: of the figure.
    """
    height = 0.7 + 1.25 * len(runs)
    with panels(["[mm]"] * len(runs), "time [s]", height, legend=False, sharey=True) as (figure, found):
        for axes, (speed, run) in zip(found, runs, strict=True):
            line(axes, run["time"], 1e3 * run["lateral"].sel(body=body), rasterized=False)
            axes.set_title(f"{speed:.0f} km/h", loc="right", fontsize=8, weight="bold", pad=2)
            axes.set_xlim(0.0, float(run["time"][-1]))
        found[0].set_title(title, loc="left")
        figure.supylabel(f"lateral displacement of {body.replace('_', ' ')}", fontsize=9)
        return figure


@into_axes
def amplitude_over_speed(
    tables: Mapping[str, xr.Dataset], critical: Mapping[str, float] | None = None, title: str = ""
) -> Figure:
    """Amplitude at the end of runs over speed: zero where the disturbance decayed, else that of the limit cycle.

    Runs that did not come to their end are crosses at the upper edge.

    Args:
        tables: label -> Dataset of `hunting_table`.
        critical: name -> speed [km/h], marked by a vertical line.
        title: of the figure.
    """
    with panels(["lateral amplitude at the end [mm]"], "speed [km/h]", 4.8) as (figure, (axes,)):
        for number, (label, table) in enumerate(tables.items()):
            speed, amplitude = table["speed"].to_numpy(), 1e3 * table["amplitude"].to_numpy()
            persists, decays = (table[name].to_numpy() == 1 for name in ("persists", "decays"))
            early, marker = ~(persists | decays), "os^Dv"[number % 5]
            drawn: dict[str, Any] = {"color": colour(number), "marker": marker}
            size = 4.5 + 2.5 * (len(tables) - 1 - number)  # those of several tables lie upon each other
            axes.plot(speed[persists], amplitude[persists], "-", markersize=4.5, label=f"{label}: persists", **drawn)
            drawn |= {"linestyle": "none", "markerfacecolor": "none", "markersize": size, "label": f"{label}: decays"}
            axes.plot(speed[decays], np.zeros(int(decays.sum())), **drawn)
            if early.any():  # neither: at the edge of the figure, where no amplitude can be read
                drawn |= {"marker": "x", "label": f"{label}: not decided", "transform": axes.get_xaxis_transform()}
                axes.plot(speed[early], np.full(int(early.sum()), 0.97), **drawn)
        critical_lines(axes, critical or {})
        axes.set_ylim(-0.15, max(1.0, axes.get_ylim()[1]))  # where all decay the axis is not round-off
        axes.set_title(title, loc="left")
        return figure
