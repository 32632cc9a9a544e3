"""Figures of a fit: measured and fitted values with what is left, over the abscissa and over frequency.

abscissa, measured and fitted values -> [comparison], [spectrum] -> Figure
"""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from rollerrig.common.arrays import Array
from rollerrig.plot.style import COLOURS, GREY, into_axes, panels

EVEN = 1e-3
"""Steps of a log may differ by this part and still have a spectrum."""


@into_axes
def comparison(x: Array, measured: Array, fitted: Array, used: Array, along: str, label: str) -> Figure:
    """Measured values and those of the fitted case, and the difference; rows held back in grey.

    Args:
        x: abscissa, shape (row,).
        measured: values, shape (row,).
        fitted: those of the fitted case, shape (row,).
        used: whether a row was fitted to.
        along: name of the abscissa with its unit.
        label: name of the values with their unit.
    """
    order, size = np.argsort(x), float(np.clip(60.0 / np.sqrt(len(x)), 1.0, 4.0))
    held_back = np.logical_not(used)
    with panels([label, "fitted -\nmeasured"], along, 4.6) as (figure, axes):
        for rows, colour, name in ((used, COLOURS[1], "measured"), (held_back, GREY, "measured, held back")):
            if rows.any():
                axes[0].plot(x[rows], measured[rows], "o", color=colour, markersize=size, label=name)
                axes[1].plot(x[rows], (fitted - measured)[rows], "o", color=colour, markersize=size)
        axes[0].plot(x[order], fitted[order], color=COLOURS[0], label="fitted")
        axes[1].axhline(0.0, color=COLOURS[0], linewidth=0.8)
        return figure


def spectrum(time: Array, residual: Array, unit: str) -> Figure | None:
    """Amplitude density over frequency of what is left at the times [s] of the rows; None where these are uneven."""
    from scipy.signal import welch

    steps = np.diff(time)
    if len(steps) < 16 or np.ptp(steps) > EVEN * steps.mean():
        return None
    frequency, power = welch(residual, 1.0 / steps.mean(), nperseg=min(len(residual), 512))
    with panels([f"density\n[{unit.replace('1', '-')}/√Hz]"], "frequency [Hz]", 2.6) as (figure, axes):
        axes[0].loglog(frequency[1:], np.sqrt(power[1:]), color=COLOURS[0])
        return figure
