"""Figures of a sweep: lines and maps of a grid, scatter pictures of samples, bars for tornado and Sobol indices."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from rollerrig.plot.style import COLOURS, MARKERS, cell_edges, house_style, logarithmic, new_figure, new_grid

MOST_PANELS = 6
"""Panels of a map: values of the third thing that is varied."""

MOST_LINES = 6
DECADE = 10.0


def _label(values: xr.DataArray) -> str:
    unit = values.attrs.get("units", "")
    return f"{str(values.name).replace('_', ' ')}{f' [{unit}]' if unit not in ('', '1') else ''}"


def _value(coordinate: xr.DataArray) -> str:
    """Name and value of a varied key."""
    found, unit = coordinate.item(), coordinate.attrs.get("units", "")
    shown = f"{found:.4g}{f' {unit}' if unit not in ('', '1') else ''}" if isinstance(found, float) else str(found)
    return f"{str(coordinate.name).replace('_', ' ')} = {shown}"


def _spread(count: int, most: int) -> list[int]:
    """Up to so many of the numbers from 0, both ends included."""
    return sorted({round(i) for i in np.linspace(0, count - 1, min(count, most))})


def _panels(count: int, high: float, low: float) -> tuple[Figure, Any]:
    """A figure with up to three panels beside each other, and the panels; height of a row [inches] of one or of several."""
    columns = min(3, count)
    figure, grid = new_grid(-(-count // columns), columns, 7.2, low if columns > 1 else high)
    for axes in grid.ravel()[count:]:
        axes.set_visible(False)
    return figure, grid


def _along(axes: Axes, which: str, values: xr.DataArray) -> Any:
    """Places of the values of a varied key on an axis, which is labelled: with words, or by logarithms over a decade or more."""
    places, words = values.to_numpy(), list[str]()
    if places.dtype.kind != "f":
        texts = places.astype(str).tolist()
        words = list(dict.fromkeys(texts))
        places = np.array([words.index(text) for text in texts])
    axis = axes.xaxis if which == "x" else axes.yaxis
    axis.set_label_text(_label(values))
    if words:
        axis.set_ticks(range(len(words)), words)
    elif _is_wide(places):
        logarithmic(axes, "x" if which == "x" else "y")
    return places


def _is_wide(places: Any) -> bool:
    return bool(np.min(places) > 0.0 and np.max(places) >= DECADE * np.min(places))


def _edges(places: Any) -> Any:
    """Borders of the cells around values, one more than them: in the middle, or that of the logarithms."""
    if len(places) == 1:
        return np.array([places[0] - 0.5, places[0] + 0.5])
    return np.exp(cell_edges(np.log(places))) if _is_wide(places) else cell_edges(np.asarray(places, dtype=np.float64))


@house_style()
def grid_map(data: xr.Dataset, name: str) -> Figure:
    """A number of a grid: lines over one or two varied keys of which one has few values, else maps, a panel per third value.

    Over a fourth and further keys the middle value is shown.
    """
    values = data[name]
    shown = sorted(values.dims, key=lambda dim: (-values.sizes[dim], values.dims.index(dim)))[:3]
    values = values.isel({dim: values.sizes[dim] // 2 for dim in values.dims if dim not in shown})
    if len(shown) == 1 or (len(shown) == 2 and values.sizes[shown[1]] < 4):
        return _lines(values, *shown)
    across, up, *third = shown
    panels = [values.isel({dim: k}) for dim in third for k in _spread(values.sizes[dim], MOST_PANELS)] or [values]
    figure, grid = _panels(len(panels), 4.2, 3.2)
    ends: dict[str, Any] = {"vmin": float(values.min()), "vmax": float(values.max())}
    picture: Any = None
    for axes, part in zip(grid.ravel(), panels, strict=False):
        axes.grid(visible=False)
        corners = (_edges(_along(axes, which, part[dim])) for which, dim in (("x", across), ("y", up)))
        picture = axes.pcolormesh(*corners, part.transpose(up, across).to_numpy(), cmap="viridis", **ends)
        axes.set_title("".join(_value(part[dim]).replace(" =", " \n=") for dim in third))
    figure.colorbar(picture, ax=list(grid.ravel()), label=_label(values))
    return figure


def _lines(values: xr.DataArray, along: Any, *others: Any) -> Figure:
    """A number over one key, a line per value of another one."""
    figure, (axes,) = new_figure(1)
    places = _along(axes, "x", values[along])
    parts = [values.isel({dim: k}) for dim in others for k in _spread(values.sizes[dim], MOST_LINES)] or [values]
    for colour, marker, part in zip(COLOURS, MARKERS, parts, strict=False):
        label = "".join(_value(part[dim]) for dim in others)
        axes.plot(places, part.to_numpy(), label=label, color=colour, marker=marker, markersize=3.5)
    axes.set_ylabel(_label(values))
    if others:
        axes.legend()
    return figure


@house_style()
def scatter(data: xr.Dataset, name: str) -> Figure:
    """A number of each case over each varied key."""
    values = data[name]
    figure, grid = _panels(len(values.coords), 3.4, 2.6)
    for axes, key in zip(grid.ravel(), values.coords, strict=False):
        places = _along(axes, "x", values[key])
        axes.plot(places, values.to_numpy(), ".", color=COLOURS[0], markersize=3.5, alpha=0.7)
    for axes in grid[:, 0]:
        axes.set_ylabel(_label(values), wrap=True)
    return figure


@house_style()
def pair_bars(
    pairs: Mapping[str, Any], names: tuple[str, str], label: str, errors: Any = None, middle: float = 0.0
) -> Figure:
    """Two bars for each varied key, from a middle value, the first key at the top.

    Args:
        pairs: key -> both ends of its bars.
        names: of the two bars.
        label: of the abscissa.
        errors: key -> half the interval of each, where there are any.
        middle: where bars begin.
    """
    places = -np.arange(len(pairs), dtype=float)
    figure, (axes,) = new_figure(1, height=max(1.8, 0.9 + 0.45 * len(pairs)))
    for k, (shift, hatch) in enumerate(((0.18, ""), (-0.18, "///"))):
        look: dict[str, Any] = {"color": COLOURS[k], "hatch": hatch, "alpha": 0.75, "edgecolor": "white"}
        sizes = np.array([pair[k] for pair in pairs.values()]) - middle
        spread = None if errors is None else [errors[key][k] for key in pairs]
        axes.barh(places + shift, sizes, left=middle, height=0.34, label=names[k], xerr=spread, **look)
    axes.axvline(middle, color="#444444", linewidth=1.0)
    axes.set_yticks(places, [key.replace("_", " ") for key in pairs])
    axes.set_xlabel(label)
    axes.legend()
    return figure
