"""Figures of the traction study."""

from __future__ import annotations

from collections.abc import Mapping

import xarray as xr
from matplotlib.figure import Figure

from rollerrig.plot.style import COLOURS, STYLES, house_style, new_figure


def traction_sliding(study: xr.Dataset, wheels: Mapping[str, str]) -> Figure:
    """Absolute sliding of wheels over time, with what the theory gives.

    Args:
        study: `sliding` and `sliding_theory` [m/s] over time and wheel, `torque` [N m] and `speed` [m/s] over time.
        wheels: wheel -> label.
    """
    with house_style():
        figure, (top, bottom) = new_figure(2, height=4.6, sharex=True, height_ratios=[2.2, 1])
        time = study["time"].to_numpy()
        for number, (wheel, label) in enumerate(wheels.items()):
            own = study.sel(wheel=wheel)
            top.plot(time, 1e3 * own["sliding"], color=COLOURS[number], linestyle=STYLES[number], label=label)
        first = next(iter(wheels))
        theory = 1e3 * study["sliding_theory"].sel(wheel=first)
        top.plot(
            time,
            theory,
            color="black",
            linestyle=":",
            linewidth=1.6,
            label="slope of the creep law at the start × force × speed",
        )
        top.set_ylim(bottom=0.0)
        top.set_ylabel("absolute sliding [mm/s]")
        top.legend(loc="upper left")
        bottom.plot(time, 1e-3 * study["torque"], color=COLOURS[2], label="torque per wheelset [kN m]")
        bottom.set_ylabel("torque [kN m]", color=COLOURS[2])
        other = bottom.twinx()
        other.plot(time, 3.6 * study["speed"], color=COLOURS[4], linestyle="--")
        other.set_ylabel("speed [km/h]", color=COLOURS[4])
        other.grid(visible=False)
        bottom.set_xlabel("time [s]")
        return figure


def traction_forces(study: xr.Dataset, wheels: Mapping[str, str]) -> Figure:
    """Longitudinal and vertical contact force of wheels over time, with the closed form of the load transfer.

    Args:
        study: `longitudinal_force`, `vertical_force`, `vertical_force_theory`, `longitudinal_force_theory` [N] over time and
            wheel.
        wheels: wheel -> label.
    """
    with house_style():
        figure, (top, bottom) = new_figure(2, height=4.8, sharex=True)
        time = study["time"].to_numpy()
        for number, (wheel, label) in enumerate(wheels.items()):
            own = study.sel(wheel=wheel)
            look = {"color": COLOURS[number], "linestyle": STYLES[number]}
            top.plot(time, 1e-3 * own["longitudinal_force"], label=label, **look)  # type: ignore[arg-type]
            bottom.plot(time, 1e-3 * own["vertical_force"], label=label, **look)  # type: ignore[arg-type]
            theory = {"color": "black", "linestyle": ":", "linewidth": 1.2}
            named = "closed form" if number == 0 else None
            bottom.plot(time, 1e-3 * own["vertical_force_theory"], label=named, **theory)  # type: ignore[arg-type]
            if number == 0:
                top.plot(time, 1e-3 * own["longitudinal_force_theory"], label=named, **theory)  # type: ignore[arg-type]
        top.set_ylabel("longitudinal force\non the wheel [kN]")
        bottom.set_ylabel("vertical force\non the wheel [kN]")
        bottom.set_xlabel("time [s]")
        top.legend(loc="lower right")
        bottom.legend(loc="center right")
        return figure
