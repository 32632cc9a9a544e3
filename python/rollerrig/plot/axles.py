"""Signals of the axles of one or more runs over time: a colour per axle, a line style per run."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import xarray as xr
from matplotlib.figure import Figure

from rollerrig.plot.style import STYLES, line, panels

Signal = tuple[str, str | Callable[[xr.Dataset], xr.DataArray], float]
"""Label of the ordinate, variable or function of a run (over time, and over axle if each has its own), factor."""


def axles_over_time(
    runs: Mapping[str, xr.Dataset], signals: Sequence[Signal], height: float, xlabel: str = "time [s]"
) -> Figure:
    """A panel per signal.

    Args:
        runs: label -> run; the first is drawn with full lines, the next dashed.
        signals: what is drawn.
        height: of the figure [inches].
        xlabel: of the abscissa.
    """
    with panels([label for label, _, _ in signals], xlabel, height) as (figure, axes):
        for panel, (_, signal, factor) in zip(axes, signals, strict=True):
            for (label, run), style in zip(runs.items(), STYLES, strict=False):
                values = factor * (run[signal] if isinstance(signal, str) else signal(run))
                suffix = f", {label}" if len(runs) > 1 else ""
                if "axle" not in values.dims:
                    line(panel, run["time"], values, 5, style, f"train{suffix}")
                    continue
                for number, axle in enumerate(values["axle"].to_numpy()):
                    line(panel, run["time"], values.sel(axle=axle), number, style, f"{axle}{suffix}")
        return figure
