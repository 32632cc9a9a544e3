"""Logarithmic axes with plain numbers at them, as many as have room.

axes -> [logarithmic] -> scale, places of the numbers, how they are written
"""

from __future__ import annotations

from typing import Any, Literal

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from rollerrig.common.formatting import number

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
    """Make an axis logarithmic.

    Args:
        axes: whose axis it is.
        which: the abscissa or the ordinate.
    """
    (axes.set_xscale if which == "x" else axes.set_yscale)("log")
    axis = axes.xaxis if which == "x" else axes.yaxis
    axis.set_major_locator(_Places())
    axis.set_major_formatter(FuncFormatter(lambda value, _place: _text(value)))
    axis.set_minor_formatter(NullFormatter())
