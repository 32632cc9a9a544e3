"""Figures of a test programme for wheel slide protection: means with intervals, distributions of slip, one test over time."""

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from rollerrig.common.arrays import Array
from rollerrig.plot.style import COLOURS, GREY, house_style, line, logarithmic, new_figure, new_grid, panels

Ends = tuple[float, float, float]
"""Mean, lower and upper end of its interval."""

LOOKS: Mapping[str, tuple[str, str]] = {"track": (COLOURS[1], "s"), "rig": (COLOURS[0], "o")}
"""Colour and marker."""


@house_style()
def means_with_intervals(
    stops: Sequence[str],
    found: Mapping[str, Sequence[Ends | None]],
    xlabel: str,
    *,
    dry: Sequence[float | None] = (),
    limits: Sequence[float | None] = (),
    zero: bool = False,
) -> Figure:
    """A line per stop, track and rig beside each other: means with their ends, values of the dry stop, limits; None: none.

    With a line at `zero` for differences.
    """
    figure, (axes,) = new_figure(1, height=1.1 + 0.32 * len(stops))
    for number, (label, ends) in enumerate(found.items()):
        shift = 0.14 * (2 * number - 1)
        colour, marker = LOOKS[label]
        rows = [(row + shift, one) for row, one in enumerate(ends) if one is not None]
        means = [one[0] for _, one in rows]
        reach = [[max(0.0, abs(one[0] - end)) if math.isfinite(end) else 0.0 for _, one in rows for end in (one[k],)]
                 for k in (1, 2)]  # fmt: skip
        look: dict[str, Any] = {"fmt": marker, "markersize": 4, "color": colour, "capsize": 2.5}
        axes.errorbar(means, [at for at, _ in rows], xerr=reach, label=label, **look)
    marks: tuple[tuple[str, Sequence[float | None], dict[str, Any]], ...] = (
        ("dry", dry, {"marker": "|", "color": GREY}),
        ("limit", limits, {"marker": "D", "facecolors": "none", "edgecolors": "black"}),
    )
    for label, values, look in marks:
        points = [(value, row) for row, value in enumerate(values) if value is not None]
        if points:
            across, places = zip(*points, strict=True)
            axes.scatter(across, places, s=34, label=label, zorder=4, **look)
    if zero:
        axes.axvline(0.0, color=GREY, linewidth=0.8)
    axes.set_yticks(range(len(stops)), [name.replace("_", " ") for name in stops])
    axes.set(ylim=(len(stops) - 0.5, -0.5), xlabel=xlabel)
    axes.legend(loc="best")
    return figure


@house_style()
def slip_grid(edges: Array, shares: Mapping[str, Mapping[str, Array]]) -> Figure:
    """Part of the time at each slip: a panel per stop, track beside rig.

    Args:
        edges: of the classes of |slip| [-], the last one infinite; shape (class + 1,).
        shares: stop -> support -> part of the time, shape (class,).
    """
    columns = 3
    rows = math.ceil(len(shares) / columns)
    figure, grid = new_grid(rows, columns, height=0.6 + 1.7 * rows, sharex=True, sharey=True)
    ends = 100.0 * np.where(np.isfinite(edges), edges, 2.0 * edges[-2] - edges[-3])
    for axes, (name, own) in zip(grid.flat, shares.items(), strict=False):
        for label, one in own.items():
            look: dict[str, Any] = {"color": LOOKS[label][0], "linewidth": 1.2}
            style = "--" if label == "track" else "-"
            axes.stairs(np.maximum(100.0 * one, 1e-3), ends, label=label, linestyle=style, **look)
        axes.set_title(name.replace("_", " "))
        logarithmic(axes, "y")
        axes.set_ylim(0.05, 120.0)
    for axes in grid.flat[len(shares) :]:
        axes.set_visible(False)
    grid[0, 0].legend()
    figure.supxlabel("|wheel speed - train speed| over train speed [%]", fontsize=9.0)
    figure.supylabel("part of the time [%]", fontsize=9.0)
    return figure


def stop_over_time(signals: Mapping[str, Mapping[str, Array]]) -> Figure:
    """Speeds of train and wheels, and cylinder pressures, of the first tests of a stop: track above, rig below."""
    labels = [f"{label}\n{what}" for label in signals for what in ("speed [km/h]", "cylinder [bar]")]
    with panels(labels, "time since the demand [s]", 1.0 + 1.5 * len(labels)) as (figure, axes):
        for (speeds, pressures), one in zip(zip(axes[::2], axes[1::2], strict=True), signals.values(), strict=True):
            time = one["time_s"]
            wheels = [name.removesuffix("_pressure_bar") for name in one if name.endswith("_pressure_bar")]
            for number, wheel in enumerate(wheels):
                style = "-" if number % 2 == 0 else "--"
                line(speeds, time, one[f"{wheel}_speed_kmh"], number, style, wheel)
                line(pressures, time, one[f"{wheel}_pressure_bar"], number, style, wheel)
            line(speeds, time, one["train_speed_kmh"], 5, "-.", "train", linewidth=1.3)
        return figure
