"""Figures of the traction study."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import xarray as xr
from matplotlib.figure import Figure

from rollerrig.plot.into import into_axes
from rollerrig.plot.style import COLOURS, look, panels


@into_axes
def traction_sliding(study: xr.Dataset, wheels: Mapping[str, str]) -> Figure:
    """Absolute sliding of wheels over time, with what the theory gives.

    Args:
        study: `sliding` and `sliding_theory` [m/s] over time and wheel, `torque` [N m] and `speed` [m/s] over time.
        wheels: wheel -> label.
    """
    labels = ("absolute sliding [mm/s]", "torque [kN m]")
    with panels(labels, "time [s]", 4.6, legend=False, height_ratios=[2.2, 1]) as (figure, (top, bottom)):
        time = study["time"].to_numpy()
        for number, (wheel, label) in enumerate(wheels.items()):
            top.plot(time, 1e3 * study["sliding"].sel(wheel=wheel), label=label, **look(number))
        theory = 1e3 * study["sliding_theory"].sel(wheel=next(iter(wheels)))
        name = "slope of the creep law at the start × force × speed"
        top.plot(time, theory, color="black", linestyle=":", linewidth=1.6, label=name)
        top.set_ylim(bottom=0.0)
        top.legend(loc="upper left")
        bottom.plot(time, 1e-3 * study["torque"], color=COLOURS[2], label="torque per wheelset [kN m]")
        bottom.yaxis.label.set_color(COLOURS[2])
        other = bottom.twinx()
        other.plot(time, 3.6 * study["speed"], color=COLOURS[4], linestyle="--")
        other.set_ylabel("speed [km/h]", color=COLOURS[4])
        other.grid(visible=False)
        return figure


@into_axes
def traction_forces(study: xr.Dataset, wheels: Mapping[str, str]) -> Figure:
    """Longitudinal creep force and vertical contact force of wheels over time, with their closed forms.

    Args:
        study: `longitudinal_creep_force`, `longitudinal_creep_force_theory`, `vertical_force`, `vertical_force_theory` [N]
            over time and wheel.
        wheels: wheel -> label.
    """
    labels = ("longitudinal creep force\non the wheel [kN]", "vertical force\non the wheel [kN]")
    theory: dict[str, Any] = {"color": "black", "linestyle": ":", "linewidth": 1.2}
    with panels(labels, "time [s]", 4.8, legend=False) as (figure, (top, bottom)):
        time = study["time"].to_numpy()
        for number, (wheel, label) in enumerate(wheels.items()):
            own = study.sel(wheel=wheel)
            top.plot(time, 1e-3 * own["longitudinal_creep_force"], label=label, **look(number))
            bottom.plot(time, 1e-3 * own["vertical_force"], label=label, **look(number))
            named = "closed form" if number == 0 else None
            bottom.plot(time, 1e-3 * own["vertical_force_theory"], label=named, **theory)
            if number == 0:
                top.plot(time, 1e-3 * own["longitudinal_creep_force_theory"], label=named, **theory)
        top.legend(loc="lower right")
        bottom.legend(loc="center right")
        return figure
