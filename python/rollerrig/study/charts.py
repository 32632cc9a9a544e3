"""Figures of curves over time or distance as numbers, so that a report can show them as charts that a reader zooms.

    matplotlib Figure -> [chart_of] -> Chart: panels, curves, numbers as text -> report -> uPlot

Only what such a chart can show whole becomes one: panels of unmarked lines that share one abscissa, and straight lines at an
ordinate. All other figures stay pictures.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from rollerrig.common.arrays import Array
from rollerrig.viewer.columns import Columns, extremes

_LEAST_POINTS = 40
"""Fewer are no history."""

_DASHES = {"-": [], "--": [7, 4], "-.": [9, 4, 2, 4], ":": [2, 3]}


@dataclass(frozen=True)
class Chart:
    """What the page needs of one figure: panels and places of their numbers, as JSON; the numbers, compressed, as base64."""

    head: dict[str, Any]
    numbers: str


def chart_of(figure: Figure, name: str, mark: str = "") -> Chart | None:
    """The figure as a chart, with a mark across; None where it is no history of lines over one abscissa."""
    panels = [axes for axes in figure.axes if axes.get_visible()]
    abscissae = {axes.get_xlabel() for axes in panels} - {""}
    if len(abscissae) != 1 or not all(map(_is_plain, panels)):
        return None
    if max(np.size(line.get_xdata()) for axes in panels for line in _curves(axes)) < _LEAST_POINTS:
        return None
    if len({axes.get_xlim() for axes in panels}) > 1:
        return None
    columns = Columns()
    shown = [_panel(axes, number, columns) for number, axes in enumerate(panels)]
    head = {"id": f"figure-{name}", "x": abscissae.pop(), "mark": mark, "panels": shown, "columns": columns.places}
    return Chart(head, columns.text())


def _is_plain(axes: Axes) -> bool:
    """Whether lines over a rising abscissa and straight ones are all that is in it."""
    others = (*axes.collections, *axes.patches, *axes.images, *axes.texts)
    lines = _curves(axes)
    straight = all(_is_level(axes, line) for line in axes.lines if line not in lines)
    return not others and bool(lines) and straight and axes.get_xscale() == axes.get_yscale() == "linear" and all(
        line.get_marker() in ("None", "", " ") and _rises(_numbers(line.get_xdata())) for line in lines
    )  # fmt: skip


def _curves(axes: Axes) -> list[Line2D]:
    return [line for line in axes.lines if line.get_transform() == axes.transData]


def _is_level(axes: Axes, line: Line2D) -> bool:
    return line.get_transform() == axes.get_yaxis_transform(which="grid")


def _rises(values: Array) -> bool:
    return len(values) > 0 and bool(np.isfinite(values).all()) and bool((np.diff(values) >= 0.0).all())


def _numbers(values: Any) -> Array:
    return np.ma.filled(np.ma.asarray(values, dtype=float), np.nan)


def _panel(axes: Axes, number: int, columns: Columns) -> dict[str, Any]:
    """One panel's head; its numbers are added to the columns, abscissae that several curves share once."""
    lines = _curves(axes)
    groups: dict[bytes, list[Line2D]] = {}
    for line in lines:
        groups.setdefault(_numbers(line.get_xdata()).tobytes(), []).append(line)
    places = {}
    for group, shared in enumerate(groups.values()):
        along = _numbers(shared[0].get_xdata())
        values = np.stack([_numbers(line.get_ydata()) for line in shared], axis=1)
        kept = extremes(values)
        columns.add(f"x{number}.{group}", along[kept], exact=True)
        for k, line in enumerate(shared):
            places[line] = f"x{number}.{group}", f"y{number}.{group}.{k}"
            columns.add(places[line][1], values[kept, k])
    curves = [
        {"x": places[line][0], "y": places[line][1], "label": _label(line), "colour": to_hex(line.get_color())}
        | {"dash": _DASHES.get(str(line.get_linestyle()), _DASHES["--"])}
        for line in lines
    ]
    low, high = (float(end) for end in axes.get_ylim())
    found = np.concatenate([_numbers(line.get_ydata()) for line in lines])
    span = float(np.ptp(found[np.isfinite(found)])) if np.isfinite(found).any() else 0.0
    levels = [float(np.ravel(line.get_ydata())[0]) for line in axes.lines if _is_level(axes, line)]
    return {
        "label": _words(axes),
        "curves": curves,
        "levels": levels,
        "range": [low, high],
        "least": high - low if high - low > 1.3 * span and not levels else 0.0,
        "cut": high - low < 0.95 * span,
    }


def _words(axes: Axes) -> str:
    """What a panel shows: the ordinate's name, or the figure's with the panel's unit; and its titles."""
    own, figure = " ".join(axes.get_ylabel().split()), axes.get_figure()
    shared = figure.get_supylabel() if isinstance(figure, Figure) else ""
    titles = [title for where in ("left", "center", "right") if (title := axes.get_title(loc=where))]
    return ", ".join([f"{shared} {own}".strip(), *titles])


def _label(line: Line2D) -> str:
    label = str(line.get_label())
    return "" if label.startswith("_") else label
