"""Figures of a sweep: maps of a grid, scatter pictures of samples, tornado, Sobol indices."""

import itertools
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


def _spread(count: int, most: int) -> list[int]:
    """Up to so many of the numbers from 0, both ends included."""
    return sorted({round(i) for i in np.linspace(0, count - 1, min(count, most))})


@house_style()
def grid_map(data: xr.Dataset, name: str) -> Figure:
    """A number of a grid: lines over one or two varied keys of which one has few values, else maps, a panel per third value.

    Over a fourth and further keys the middle value is shown.
    """
    values = data[name]
    shown = sorted(values.dims, key=lambda dim: (-values.sizes[dim], values.dims.index(dim)))[:3]
    rest = {dim: values.sizes[dim] // 2 for dim in values.dims if dim not in shown}
    values = values.isel(rest)
    shown = [dim for dim in values.dims if dim in shown]
    if len(shown) == 1:
        figure, axes = new_figure(1)
        _line(axes[0], values)
        axes[0].set_ylabel(_label(values))
        return figure
    if len(shown) == 2 and min(values.sizes[dim] for dim in shown) < 4:
        return _lines(values, shown)
    across, up, *third = sorted(shown, key=lambda dim: -values.sizes[dim])
    panels = _spread(values.sizes[third[0]], MOST_PANELS) if third else [0]
    columns = min(3, len(panels))
    figure, grid = new_grid(-(-len(panels) // columns), columns, 7.2, 3.2 if columns > 1 else 4.2)
    low, high = float(values.min()), float(values.max())
    picture: Any = None
    for axes, k in itertools.zip_longest(grid.ravel(), panels):
        if k is None:
            axes.set_visible(False)
            continue
        part = values.isel({third[0]: k}) if third else values
        picture = _map(axes, part.transpose(up, across), low, high)
        if third:
            axes.set_title(f"{str(third[0]).replace('_', ' ')} \n= {_shown(part[third[0]])}")
    if picture is not None:
        figure.colorbar(picture, ax=list(grid.ravel()), label=_label(values))
    return figure


def _shown(value: xr.DataArray) -> str:
    found, unit = value.item(), value.attrs.get("units", "")
    return f"{found:.4g}{f' {unit}' if unit not in ('', '1') else ''}" if isinstance(found, float) else str(found)


def _places(values: xr.DataArray, dim: str) -> tuple[Any, list[str]]:
    """Where the values of a key stand on an axis, and what is written there if they are words."""
    coordinate = values[dim].to_numpy()
    if coordinate.dtype.kind == "f":
        return coordinate, []
    return np.arange(len(coordinate)), [str(word) for word in coordinate]


def _line(axes: Axes, values: xr.DataArray, number: int = 0, label: str = "") -> None:
    dim = str(values.dims[0])
    places, words = _places(values, dim)
    style = {"color": COLOURS[number % len(COLOURS)], "marker": MARKERS[number % len(MARKERS)], "markersize": 3.5}
    axes.plot(places, values.to_numpy(), label=label, **style)  # type: ignore[arg-type]
    if words:
        axes.set_xticks(places, words)
    axes.set_xlabel(_label(values[dim]))


def _lines(values: xr.DataArray, shown: list[Any]) -> Figure:
    _, other = sorted(shown, key=lambda dim: -values.sizes[dim])
    figure, axes = new_figure(1)
    for number, k in enumerate(_spread(values.sizes[other], MOST_LINES)):
        part = values.isel({other: k})
        _line(axes[0], part, number, f"{other.replace('_', ' ')} = {_shown(part[other])}")
    axes[0].set_ylabel(_label(values))
    axes[0].legend()
    return figure


def _map(axes: Axes, values: xr.DataArray, low: float, high: float) -> Any:
    (up, across) = (str(dim) for dim in values.dims)
    (x, x_words), (y, y_words) = _places(values, across), _places(values, up)
    axes.grid(visible=False)
    corners = _edges(x), _edges(y)
    picture = axes.pcolormesh(*corners, values.to_numpy(), shading="flat", vmin=low, vmax=high, cmap="viridis")
    _logarithmic(axes, x if not x_words else [], y if not y_words else [])
    if x_words:
        axes.set_xticks(x, x_words)
    if y_words:
        axes.set_yticks(y, y_words)
    axes.set(xlabel=_label(values[across]), ylabel=_label(values[up]))
    return picture


def _logarithmic(axes: Axes, x: Any, y: Any = ()) -> None:
    """Logarithmic axes for values over a decade or more, with plain numbers at them."""
    if _is_wide(x):
        logarithmic(axes)
    if _is_wide(y):
        logarithmic(axes, "y")


def _is_wide(places: Any) -> bool:
    """Whether values are shown by their logarithms: positive ones over a decade or more."""
    return bool(len(places) and np.min(places) > 0.0 and np.max(places) >= DECADE * np.min(places))


def _edges(places: Any) -> Any:
    """Borders of the cells around values, one more than them: in the middle, or that of the logarithms."""
    if len(places) == 1:
        return np.array([places[0] - 0.5, places[0] + 0.5])
    return np.exp(cell_edges(np.log(places))) if _is_wide(places) else cell_edges(np.asarray(places, dtype=np.float64))


@house_style()
def scatter(data: xr.Dataset, name: str) -> Figure:
    """A number of each case over each varied key."""
    values = data[name]
    keys = [str(key) for key in values.coords]
    columns = min(3, len(keys))
    figure, grid = new_grid(-(-len(keys) // columns), columns, 7.2, 2.6 if columns > 1 else 3.4)
    for axes, key in itertools.zip_longest(grid.ravel(), keys):
        if key is None:
            axes.set_visible(False)
            continue
        column = values[key].to_numpy()
        numbers = column.dtype.kind == "f"
        places = column if numbers else np.unique(column.astype(str), return_inverse=True)[1]
        axes.plot(places, values.to_numpy(), ".", color=COLOURS[0], markersize=3.5, alpha=0.7)
        if not numbers:
            words = np.unique(column.astype(str))
            axes.set_xticks(range(len(words)), list(words))
        _logarithmic(axes, column if numbers else [])
        axes.set_xlabel(_label(values[key]))
    for axes in grid[:, 0]:
        axes.set_ylabel(_label(values), wrap=True)
    return figure


PAIR: tuple[dict[str, Any], ...] = tuple(
    {"color": colour, "hatch": hatch, "alpha": 0.75, "edgecolor": "white"}
    for colour, hatch in ((COLOURS[0], ""), (COLOURS[1], "///"))
)
"""Looks of the two bars of a key."""


@house_style()
def tornado(ends: Mapping[str, tuple[float, float]], attributes: Mapping[str, Any], middle: float) -> Figure:
    """Bars from the mean at the low end of each varied key to that at its high end, the longest at the top; mean of all cases."""
    keys = sorted(ends, key=lambda key: abs(ends[key][1] - ends[key][0]))
    figure, axes = new_figure(1, height=max(1.8, 0.9 + 0.35 * len(keys)))
    for place, key in enumerate(keys):
        for value, label, look in zip(ends[key], ("low end", "high end"), PAIR, strict=True):
            named = label if place == 0 else None
            axes[0].barh(place, value - middle, left=middle, height=0.6, label=named, **look)
    axes[0].axvline(middle, color="#444444", linewidth=1.0)
    axes[0].set_yticks(range(len(keys)), [key.replace("_", " ") for key in keys])
    unit = attributes["units"]
    axes[0].set_xlabel(f"mean{f' [{unit}]' if unit not in ('', '1') else ''}")
    axes[0].legend()
    return figure


@house_style()
def sobol_bars(found: Mapping[str, Mapping[str, float]]) -> Figure:
    """First-order and total Sobol indices of each varied key with their intervals."""
    keys = list(found)[::-1]
    figure, axes = new_figure(1, height=max(1.8, 0.9 + 0.45 * len(keys)))
    kinds = ((0.18, "first", "first order"), (-0.18, "total", "total"))
    for (shift, kind, label), look in zip(kinds, PAIR, strict=True):
        places = [place + shift for place in range(len(keys))]
        sizes = [found[key][kind] for key in keys]
        errors = [found[key][f"{kind}_confidence"] for key in keys]
        axes[0].barh(places, sizes, xerr=errors, height=0.34, label=label, **look)
    axes[0].set_yticks(range(len(keys)), [key.replace("_", " ") for key in keys])
    axes[0].set_xlabel("part of the variance [-]")
    axes[0].legend()
    return figure
