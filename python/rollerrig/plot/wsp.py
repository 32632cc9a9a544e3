"""Figure of a test programme for wheel slide protection: means with intervals."""

from collections.abc import Mapping, Sequence
from typing import Any

from matplotlib.figure import Figure

from rollerrig.plot.style import COLOURS, GREY, house_style, new_figure


@house_style()
def means_with_intervals(
    stops: Sequence[str],
    found: Mapping[str, Sequence[Mapping[str, Any] | None]],
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
    for label, ends in found.items():
        shift, colour, marker = (-0.14, COLOURS[1], "s") if label == "track" else (0.14, COLOURS[0], "o")
        shown = [(row + shift, one) for row, one in enumerate(ends) if one is not None and one["mean"] is not None]
        reach = [[abs(one["mean"] - (one["mean"] if one[end] is None else one[end])) for _, one in shown]
                 for end in ("low", "high")]  # fmt: skip
        look: dict[str, Any] = {"fmt": marker, "markersize": 4, "color": colour, "capsize": 2.5}
        axes.errorbar([one["mean"] for _, one in shown], [row for row, _ in shown], xerr=reach, label=label, **look)
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
