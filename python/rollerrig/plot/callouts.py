"""Names in a row above a view, each with a line to what it names: none lies upon another, and lines cross as little as can be.

view, names with places -> [callouts] -> texts and lines
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Any, cast

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

_LINE, _GAP = 11.0, 5.0
"""Height of a row, and least room between two names [points]."""
_SIZE = 6.8


@dataclass(frozen=True)
class Callout:
    """What is named.

    Attributes:
        text: its name.
        place: in the view [data].
        colour: of the line.
    """

    text: str
    place: tuple[float, float]
    colour: str = "#333333"


def callouts(axes: Axes, named: Sequence[Callout], *, wide: bool = False, above: float = 6.0) -> int:
    """Write the names above the axes, in more rows where one is too short.

    Args:
        axes: whose position and limits are settled.
        named: what is named.
        wide: whether the row may go on to the right edge of the figure; else it ends with the axes.
        above: room between the axes and the lowest row [points].

    Returns:
        Rows.
    """
    figure = cast(Figure, axes.get_figure(root=True))
    points = 72.0 / figure.dpi
    box = axes.get_window_extent()
    right = figure.get_figwidth() * 72.0 - _GAP if wide else box.x1 * points
    low, high, top = box.x0 * points, right, box.y1 * points + above
    widths = _widths(figure, named)
    anchors = [tuple(axes.transData.transform(one.place) * points) for one in named]
    order = sorted(range(len(named)), key=lambda k: anchors[k])
    rows = max(1, int(np.ceil((sum(widths) + _GAP * len(named)) / (high - low))))
    placed: dict[int, tuple[float, float]] = {}
    for row in range(rows):
        placed |= _row(order[row::rows], anchors, widths, (low, high), top + row * _LINE)
    width, height = figure.get_figwidth() * 72.0, figure.get_figheight() * 72.0
    for k, (x, y) in placed.items():
        line = {"arrowstyle": "-", "color": named[k].colour, "linewidth": 0.6, "shrinkA": 0.0, "shrinkB": 0.0}
        axes.annotate(named[k].text, named[k].place, (x / width, y / height), textcoords="figure fraction", fontsize=_SIZE,
                      ha="center", va="bottom", arrowprops={**line, "relpos": (0.5, 0.0)}, zorder=9, annotation_clip=False,
                      gid="callout")  # fmt: skip
        axes.plot(*named[k].place, "o", color=named[k].colour, markersize=2.0, zorder=9)
    return rows


def room(rows: int = 1) -> float:
    """That rows of names take above a view [points]."""
    return rows * _LINE + 8.0


def _widths(figure: Figure, named: Sequence[Callout]) -> list[float]:
    """Widths of the names [points]."""
    renderer = cast(Any, figure.canvas).get_renderer()
    found = []
    for one in named:
        text = figure.text(0.0, 0.0, one.text, fontsize=_SIZE)
        found.append(text.get_window_extent(renderer).width * 72.0 / figure.dpi)
        text.remove()
    return found


def _row(
    order: list[int], anchors: list[tuple[float, ...]], widths: list[float], limits: tuple[float, float], height: float
) -> dict[int, tuple[float, float]]:
    """Places of the names of one row: each as near above its anchor as the others let it, in the order of fewest crossings."""
    best = _spread(order, anchors, widths, limits)
    improved = True
    while improved:
        improved = False
        for i, j in combinations(range(len(order)), 2):
            other = list(order)
            other[i], other[j] = other[j], other[i]
            tried = _spread(other, anchors, widths, limits)
            if _crossings(tried, anchors, height) < _crossings(best, anchors, height):
                order[:], best, improved = other, tried, True
    return {k: (x, height) for k, x in best.items()}


def _spread(
    order: list[int], anchors: list[tuple[float, ...]], widths: list[float], limits: tuple[float, float]
) -> dict[int, float]:
    """Middles of names in this order: pushed to the right until none overlaps, then back from the right end."""
    low, high = limits
    found: dict[int, float] = {}
    edge = low
    for k in order:
        found[k] = max(anchors[k][0], edge + 0.5 * widths[k])
        edge = found[k] + 0.5 * widths[k] + _GAP
    edge = high
    for k in reversed(order):
        found[k] = min(found[k], edge - 0.5 * widths[k])
        edge = found[k] - 0.5 * widths[k] - _GAP
    return found


def _crossings(places: dict[int, float], anchors: list[tuple[float, ...]], height: float) -> int:
    """Pairs of lines that cross on their way to different places."""

    def turn(a: tuple[float, ...], b: tuple[float, ...], c: tuple[float, ...]) -> float:
        return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])

    count = 0
    for i, j in combinations(places, 2):
        a, b, c, d = (places[i], height), anchors[i], (places[j], height), anchors[j]
        count += turn(a, b, c) * turn(a, b, d) < 0.0 and turn(c, d, a) * turn(c, d, b) < 0.0
    return count
