"""Signals of several runs over each other."""

from __future__ import annotations

import xarray as xr
from matplotlib.figure import Figure

from rollerrig.plot.into import into_axes
from rollerrig.plot.style import STYLES, line, panels

_SHOWN = {"m": ("mm", 1e3), "rad": ("mrad", 1e3), "N": ("kN", 1e-3), "m/s": ("km/h", 3.6)}
"""Unit of a result -> the one that is shown, and its factor."""


@into_axes
def runs_together(comparison: xr.Dataset) -> Figure:
    """Each signal of several runs in one panel, a line per run.

    Args:
        comparison: Dataset of `compare_runs`.
    """
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
