"""The limit-cycle diagram."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from rollerrig.plot.into import into_axes
from rollerrig.plot.log_axis import logarithmic
from rollerrig.plot.style import COLOURS, GREY, critical_line, panels

LOOKS: dict[str, dict[str, Any]] = {
    "up": {"color": COLOURS[0], "marker": "^", "linestyle": "-"},
    "down": {"color": COLOURS[1], "marker": "v", "linestyle": "--"},
}


@into_axes
def limit_cycle_diagram(cycles: xr.Dataset, modes: xr.Dataset | None = None) -> Figure:
    """Amplitude, frequency and guiding force over speed, on the upward sweep and on the downward sweep.

    Args:
        cycles: Dataset of `limit_cycle_table`.
        modes: Dataset of `stability`: its linear critical speed, and the frequency of hunting for comparison.
    """
    labels = ("lateral amplitude of wheelsets [mm]", "frequency [Hz]", "largest |Y| [kN]")
    ratios = {"height_ratios": (2.2, 1, 1)}
    with panels(labels, "speed [km/h]", 7.0, legend=False, gridspec_kw=ratios) as (figure, axes):
        amplitude, frequency, force = axes
        for sweep, drawn in LOOKS.items():
            _sweep(axes, cycles.isel(cycle_point=cycles["cycle_sweep"].to_numpy() == sweep), sweep, drawn)
        if modes is not None and bool(modes["hunting_frequency"].notnull().any()):
            linear = {"color": GREY, "linewidth": 1.0, "label": "linear hunting mode"}
            frequency.plot(modes["speed"], modes["hunting_frequency"], **linear)  # type: ignore[arg-type]
            frequency.legend(loc="best")
        critical = {"critical speed by continuation": float(cycles.attrs["critical_speed_by_continuation_kmh"])}
        if modes is not None:
            critical["linear critical speed"] = float(modes.attrs["linear_critical_speed_kmh"])
        for name, value in critical.items():
            if math.isfinite(value):
                critical_line(amplitude, value, f"{name} {value:.1f} km/h")
                for panel in (frequency, force):
                    panel.axvline(value, color=GREY, linewidth=1.0, linestyle=(0, (4, 2)))
        speeds, sizes = cycles["cycle_speed"].to_numpy(), np.nan_to_num(1e3 * cycles["cycle_amplitude"].to_numpy())
        margin = 0.03 * float(np.ptp(speeds)) + 1.0
        amplitude.set_xlim(float(speeds.min()) - margin, float(speeds.max()) + margin)
        amplitude.set_ylim(bottom=-0.03 * max(1.0, float(sizes.max(initial=0.0))))
        amplitude.legend(loc="upper left")
        frequency.set_ylim(bottom=0.0)
        if float(np.nan_to_num(1e-3 * cycles["cycle_guiding_force"].to_numpy()).max(initial=0.0)) > 100.0:
            logarithmic(force, "y")
        return figure


def _sweep(axes: Sequence[Axes], one: xr.Dataset, sweep: str, drawn: dict[str, Any]) -> None:
    """Amplitude, frequency and force on one sweep through the speeds."""
    amplitude, frequency, force = axes
    down = sweep == "down"
    style = {**drawn, "markersize": 5, "markerfacecolor": "white" if down else drawn["color"]}
    speed, size = one["cycle_speed"].to_numpy(), 1e3 * one["cycle_amplitude"].to_numpy()
    amplitude.plot(speed, size, label=f"{sweep}ward sweep", zorder=4 if down else 3, **style)
    frequency.plot(speed, one["cycle_frequency"].to_numpy(), **style)
    force.plot(speed, 1e-3 * one["cycle_guiding_force"].to_numpy(), **style)
    for v, status in zip(speed, one["cycle_status"].to_numpy(), strict=True):
        if status != "ok":
            place: dict[str, Any] = {"xycoords": ("data", "axes fraction"), "rotation": 90, "fontsize": 7.5}
            amplitude.annotate(str(status).replace("_", " "), (v, 0.5), **place)
