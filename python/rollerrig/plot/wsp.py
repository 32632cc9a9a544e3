"""Figure of a test programme for wheel slide protection: means with intervals."""

import math
from collections.abc import Mapping, Sequence
from typing import Any

from matplotlib.figure import Figure

from rollerrig.plot.style import COLOURS, GREY, house_style, new_figure

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
