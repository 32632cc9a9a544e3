"""One look for all figures: readable in print and without colour, the same bytes every time; also in axes of the caller's own.

    a function that draws results into a new figure -> [into_axes] -> the same with `axes=`
    axes -> [logarithmic] -> scale, places of the numbers, how they are written

A figure of several panels takes as many axes as are given, from the top; the other panels are not drawn.
"""

import functools
import inspect
import io
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from typing import Any, Literal, cast

import matplotlib as mpl
import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from rollerrig.common.arrays import Array
from rollerrig.common.formatting import number
from rollerrig.results.marks import PROGRAM

_GIVEN: ContextVar[tuple[Axes, ...]] = ContextVar("axes of the caller's own", default=())


def into_axes(draw: Callable[..., Figure]) -> Callable[..., Any]:
    """The function in the house style, with a last argument `axes`: what it is given is drawn into, and returned."""
    styled = house_style()(draw)

    @functools.wraps(draw)
    def drawn(*results: Any, axes: Axes | Sequence[Axes] | None = None, **options: Any) -> Any:
        if axes is None:
            return styled(*results, **options)
        given = (axes,) if isinstance(axes, Axes) else tuple(np.ravel(np.asarray(axes, dtype=object)))
        token = _GIVEN.set(given)
        try:
            styled(*results, **options)
        finally:
            _GIVEN.reset(token)
        return axes

    own = inspect.signature(draw)
    extra = inspect.Parameter(
        "axes", inspect.Parameter.KEYWORD_ONLY, default=None, annotation="Axes | Sequence[Axes] | None"
    )
    drawn.__signature__ = own.replace(parameters=[*own.parameters.values(), extra])  # type: ignore[attr-defined]
    return drawn


def given() -> tuple[Axes, ...]:
    """Axes of the caller's own that are drawn into now; none: a new figure is made."""
    return _GIVEN.get()


COLOURS = ("#0b5394", "#c0392b", "#2e7d32", "#8e5ea2", "#b9770e", "#455a64", "#00838f", "#6d4c41")
"""Dark enough for print; lines that share a figure also differ in style or marker."""

STYLES = ("-", "--", "-.", ":")
MARKERS = ("o", "s", "^", "D", "v", "P", "X", "*")
GREY = "#777777"

SETTINGS: dict[str, Any] = {
    "font.family": "DejaVu Sans",
    "font.size": 9.0,
    "axes.titlesize": 9.5,
    "axes.labelsize": 9.0,
    "axes.grid": True,
    "axes.unicode_minus": False,  # one minus in figures, tables and files
    "axes.axisbelow": True,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "grid.color": "#dddddd",
    "grid.linewidth": 0.6,
    "legend.fontsize": 8.0,
    "legend.framealpha": 0.9,
    "legend.edgecolor": "#cccccc",
    "lines.linewidth": 1.3,
    "svg.hashsalt": "rollerrig",
    "svg.fonttype": "path",
    "path.simplify": True,
}


@contextmanager
def house_style() -> Iterator[None]:
    """Within it, figures are made and drawn in this style, whatever the user's own settings are."""
    with mpl.rc_context():
        mpl.rcdefaults()
        mpl.rcParams.update(SETTINGS)  # type: ignore[arg-type, unused-ignore]
        yield


def new_figure(rows: int = 1, width: float = 7.2, height: float = 3.4, **options: Any) -> tuple[Figure, list[Axes]]:
    """A figure with axes one above the other [inches]; needs no display."""
    figure, axes = new_grid(rows, 1, width, height, **options)
    return figure, list(axes[:, 0])


def new_grid(rows: int, columns: int, width: float = 7.2, height: float = 3.4, **options: Any) -> tuple[Figure, Any]:
    """A figure with a grid of axes, shape (row, column) [inches]; needs no display.

    Given axes are the grid, filled up with axes of a figure that nobody will see.
    """
    figure, axes = Figure(figsize=(width, height), layout="constrained"), given()
    FigureCanvasAgg(figure)
    if not axes:
        return figure, figure.subplots(rows, columns, squeeze=False, **options)
    missing = rows * columns - len(axes)
    spare = figure.subplots(1, missing, squeeze=False)[0] if missing > 0 else []
    grid = np.empty(rows * columns, dtype=object)
    grid[:] = [*axes, *spare][: rows * columns]
    return cast(Figure, axes[0].get_figure(root=True)), grid.reshape(rows, columns)


@contextmanager
def panels(
    labels: Sequence[str], xlabel: str, height: float, *, legend: bool = True, **options: Any
) -> Iterator[tuple[Figure, list[Axes]]]:
    """Within it, axes one above the other are drawn into; then they are labelled.

    Args:
        labels: of the ordinates, from the top; empty: set within.
        xlabel: of the common abscissa.
        height: of the figure [inches].
        legend: whether the first panel's legend stands above all.
        **options: for `new_figure`.
    """
    with house_style():
        figure, axes = new_figure(len(labels), height=height, **{"sharex": True, **options})
        yield figure, axes
        for one, label in zip(axes, labels, strict=True):
            one.set_ylabel(label or one.get_ylabel())
        axes[min(len(given()) or len(axes), len(axes)) - 1].set_xlabel(xlabel)
        if legend:
            legend_above(figure, axes[0])


def cell_edges(values: Array) -> Array:
    """Edges of the cells around two or more values: half-way between them."""
    middle = 0.5 * (values[1:] + values[:-1])
    return np.concatenate([[2.0 * values[0] - middle[0]], middle, [2.0 * values[-1] - middle[-1]]])


def colour(number: int) -> str:
    """The colour of the curve of a number."""
    return COLOURS[number % len(COLOURS)]


def look(number: int) -> dict[str, Any]:
    """Colour and line style of the curve of a number."""
    return {"color": colour(number), "linestyle": STYLES[number % len(STYLES)]}


def line(axes: Axes, along: Any, values: Any, number: int = 0, style: Any = "-", label: str = "", **more: Any) -> None:
    """A thin line, rasterised since it has many points; colour by number, blanks for underscores in the label."""
    options = {"linewidth": 0.9, "rasterized": True, "color": colour(number), "linestyle": style, **more}
    axes.plot(np.asarray(along), np.asarray(values), label=label.replace("_", " "), **options)


def calm(axes: Axes, least: float) -> None:
    """Show at least this range: what is rounding is not drawn as motion."""
    low, high = axes.get_ylim()
    if high - low < least:
        middle = 0.5 * (low + high)
        axes.set_ylim(middle - 0.5 * least, middle + 0.5 * least)


def legend_above(figure: Figure, axes: Axes) -> None:
    """One legend above all panels, in as many columns as fit."""
    handles, labels = axes.get_legend_handles_labels()
    if given():
        given()[0].legend(handles, labels)
        return
    widest = max((len(label) for label in labels), default=1)
    room = int(figure.get_figwidth() * 13.5)  # letters of this size beside each other, a line's sample takes 8
    columns = max(1, min(4, len(labels), room // (widest + 8)))
    figure.legend(handles, labels, loc="outside upper center", ncols=columns)


def legend_below(figure: Figure, axes: Axes) -> None:
    """One legend of the labels of some axes below all panels."""
    handles, labels = axes.get_legend_handles_labels()
    if given():
        given()[-1].legend(handles, labels)
    else:
        figure.legend(handles, labels, loc="outside lower center", ncols=min(4, len(labels)))


def headline(figure: Figure, text: str) -> None:
    """A title above all panels."""
    if given():
        given()[0].set_title(text)
    else:
        figure.suptitle(text, fontsize=10)


def legend_beside(axes: Axes, **options: Any) -> None:
    """A legend to the right of the axes, where something has a label."""
    if axes.get_legend_handles_labels()[0]:
        axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), **options)


def wheel_lines(axes: Axes, along: xr.DataArray, values: xr.DataArray) -> None:
    """A line per wheel over time: each wheelset its colour, left wheels full and right ones dashed."""
    wheels = [str(wheel) for wheel in values["wheel"].to_numpy()]
    wheelsets = list(dict.fromkeys(wheel.rpartition("_")[0] for wheel in wheels))
    for wheel in wheels:
        wheelset, _, side = wheel.rpartition("_")
        number, style = wheelsets.index(wheelset), "-" if side == "left" else (0, (4, 2))
        line(axes, along, values.sel(wheel=wheel), number, style, wheel)


def critical_line(axes: Axes, speed_kmh: float | tuple[float, float], label: str) -> None:
    """A vertical line at a critical speed, or a band over the interval in which it lies, named at its top."""
    dashes: dict[str, Any] = {"color": GREY, "linewidth": 1.0, "linestyle": (0, (4, 2))}
    if isinstance(speed_kmh, tuple):
        axes.axvspan(*speed_kmh, color=GREY, alpha=0.2, linewidth=0.0)
        for end in speed_kmh:
            axes.axvline(end, **dashes)
        speed_kmh = speed_kmh[1]
    else:
        axes.axvline(speed_kmh, **dashes)
    axes.annotate(
        label,
        (speed_kmh, 1.0),
        (-3, -4),
        xycoords=("data", "axes fraction"),
        textcoords="offset points",
        rotation=90,
        ha="right",
        va="top",
        fontsize=7.5,
        color="#444444",
        zorder=10,
        bbox={"boxstyle": "square,pad=0.1", "facecolor": "white", "edgecolor": "none", "alpha": 0.85},
    )


def critical_lines(axes: Axes, speeds_kmh: Mapping[str, float | tuple[float, float]]) -> None:
    """Lines at all critical speeds that are known: name -> speed, or both ends of its interval [km/h]."""
    for name, speed in speeds_kmh.items():
        if np.isfinite(speed).all():
            ends = speed if isinstance(speed, tuple) else (speed,)
            critical_line(axes, speed, f"{name} {' … '.join(dict.fromkeys(f'{end:.0f}' for end in ends))} km/h")


def watermark(figure: Figure, text: str) -> None:
    """A word across the whole figure, above all that is drawn and light enough to read through; once only."""
    name = "watermark"
    if not any(one.get_gid() == name for one in figure.texts):
        figure.text(0.5, 0.5, text, gid=name, size=64, weight="bold", color=GREY, alpha=0.22, rotation=25,
                    ha="center", va="center", zorder=1000)  # fmt: skip


def figure_bytes(figure: Figure, kind: Literal["svg", "png", "pdf"] = "svg", dpi: int = 150) -> bytes:
    """The figure as a file in memory; no dates, no random names, so the same figure gives the same bytes."""
    buffer = io.BytesIO()
    metadata: dict[str, str | None] = {"Software": PROGRAM}
    if kind != "png":
        metadata = {"Creator": PROGRAM, "Date" if kind == "svg" else "CreationDate": None}
    with house_style():
        figure.savefig(buffer, format=kind, dpi=dpi, metadata=metadata)
    return buffer.getvalue()


def fewer_colours(png: bytes) -> bytes:
    """A PNG picture with a palette of 64 colours, a third to a fifth of the bytes: enough for lines and letters on paper."""
    from matplotlib.image import imread
    from PIL import Image  # matplotlib brings it; slow to load

    pixels = np.round(255.0 * imread(io.BytesIO(png))[..., :3]).astype(np.uint8)
    few = Image.fromarray(pixels).quantize(64, method=Image.Quantize.MEDIANCUT, dither=Image.Dither.NONE)
    buffer = io.BytesIO()
    few.save(buffer, "png", optimize=True)
    return buffer.getvalue()


_STEPS = ((1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 8.0), (1.0, 2.0, 5.0), (1.0, 3.0), (1.0,))
"""Numbers stand at these multiples of the powers of ten; at as many as have room."""

_LETTER = 0.62
"""Width of a digit over the size of the letters."""


class _Places(LogLocator):
    """Where numbers stand."""

    def tick_values(self, vmin: float, vmax: float) -> Any:
        low, high = sorted((vmin, vmax))
        if not 0.0 < low < high:
            return super().tick_values(vmin, vmax)
        powers = 10.0 ** np.arange(np.floor(np.log10(low)), np.ceil(np.log10(high)) + 1.0)
        places = np.zeros(0)
        for steps in _STEPS:
            places = np.outer(powers, steps).ravel()
            places = places[(places >= low * (1.0 - 1e-9)) & (places <= high * (1.0 + 1e-9))]
            if self._have_room(places, high / low):
                return places
        stride = next(n for n in range(2, len(places) + 2) if self._have_room(places[::n], high / low))
        return places[::stride]

    def _have_room(self, places: Any, span: float) -> bool:
        """Whether the numbers at these places, written beside or above each other, do not touch."""
        axis: Any = self.axis
        if axis is None or len(places) < 2:
            return True
        across, size, box = axis.axis_name == "x", float(mpl.rcParams["font.size"]), axis.axes.bbox
        length = (box.width if across else box.height) * 72.0 / axis.axes.figure.dpi
        wide = np.array([_LETTER * size * len(_text(place)) if across else size for place in places])
        gaps = np.diff(np.log(places)) / np.log(span) * length
        return bool((gaps > 0.5 * (wide[1:] + wide[:-1]) + 0.5 * size).all())


def _text(value: float) -> str:
    return number(float(value), 3)


def logarithmic(axes: Axes, which: Literal["x", "y"] = "x") -> None:
    """Make the abscissa or the ordinate logarithmic."""
    (axes.set_xscale if which == "x" else axes.set_yscale)("log")
    axis = axes.xaxis if which == "x" else axes.yaxis
    axis.set_major_locator(_Places())
    axis.set_major_formatter(FuncFormatter(lambda value, _place: _text(value)))
    axis.set_minor_formatter(NullFormatter())
