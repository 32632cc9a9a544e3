"""Figures of ensembles on track and rig: bars of causes with their errors, distributions of slip, distance over dead time."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from rollerrig.plot.style import COLOURS, GREY, house_style, new_figure

Array = NDArray[np.float64]


def cause_bars(shares: Mapping[str, tuple[float, float, bool]]) -> Figure:
    """Bars of what each imperfection contributes to the difference in distance; the last one is all of them.

    Args:
        shares: name -> part of the track's distance [-], its standard error, and whether it is inside its error: drawn hollow.
    """
    with house_style():
        figure, (axes,) = new_figure(1, height=2.6)
        for row, (share, error, hidden) in enumerate(shares.values()):
            colour = COLOURS[1] if row == len(shares) - 1 else COLOURS[0]
            look: dict[str, Any] = (
                {"facecolor": "none", "edgecolor": colour, "linestyle": "--"} if hidden else {"color": colour}
            )
            axes.barh(row, 100.0 * share, height=0.55, **look)
            axes.errorbar(100.0 * share, row, xerr=100.0 * error, color="black", capsize=3.0, linewidth=0.9)
            text = f"{100.0 * share:+.2f} ± {100.0 * error:.2f}" + (", inside its error" if hidden else "")
            outer, right = 100.0 * (share + np.copysign(error, share)), share >= 0.0
            place: dict[str, Any] = {"xytext": (5 if right else -5, 0), "ha": "left" if right else "right"}
            axes.annotate(text, (outer, row), textcoords="offset points", va="center", **place)
        axes.set_yticks(range(len(shares)), list(shares))
        axes.invert_yaxis()
        axes.axvline(0.0, color="black", linewidth=0.8)
        axes.margins(x=0.45)
        axes.set_xlabel("mean distance of the rig less that of the track [% of it], ± standard error")
        return figure


def slip_histogram(edges: Array, shares: Mapping[str, Array]) -> Figure:
    """Part of the time at each slip, and the sums.

    Args:
        edges: of the classes of |slip| [-], the last one infinite; shape (class + 1,).
        shares: run -> part of the time, shape (class,).
    """
    with house_style():
        figure, (parts, sums) = new_figure(2, height=4.4, sharex=True)
        used = max(
            (int(np.flatnonzero(one > 1e-4)[-1]) + 1 for one in shares.values() if (one > 1e-4).any()), default=1
        )
        ends = 100.0 * np.where(np.isfinite(edges), edges, 2.0 * edges[-2] - edges[-3])[: used + 1]
        for number, (label, one) in enumerate(shares.items()):
            look: dict[str, Any] = {
                "color": COLOURS[1 - number % 2],
                "linestyle": "--" if label == "track" else "-",
                "linewidth": 1.3,
            }
            parts.stairs(100.0 * one[:used], ends, label=label, **look)
            sums.plot(ends[1:], 100.0 * np.cumsum(one)[:used], label=label, **look)
        parts.set_ylabel("part of the time [%]")
        sums.set_ylabel("at most this slip\n[% of the time]")
        sums.set_xlabel("|wheel speed - train speed| over train speed [%]")
        parts.legend()
        return figure


def dead_time_curve(
    track: Mapping[float, tuple[float, float]], rig: tuple[float, float], predicted: tuple[float, float]
) -> Figure:
    """Distance on track over additional dead time, and the rig's.

    Args:
        track: additional dead time [ms] -> mean distance, its standard error [m].
        rig: mean distance, its standard error [m].
        predicted: equivalent dead time in closed form, and the least [ms].
    """
    with house_style():
        figure, (axes,) = new_figure(1, height=2.8)
        delays = sorted(track)
        means, errors = zip(*(track[delay] for delay in delays), strict=True)
        axes.errorbar(delays, means, errors, color=COLOURS[1], marker="o", markersize=4, capsize=3.0, label="track")
        axes.axhline(rig[0], color=COLOURS[0], linewidth=1.3, label="rig")
        axes.axhspan(rig[0] - rig[1], rig[0] + rig[1], color=COLOURS[0], alpha=0.2, linewidth=0.0)
        for value, style in zip(predicted, ("--", ":"), strict=True):
            axes.axvline(value, color=GREY, linestyle=style, linewidth=1.0)
        axes.set_xlabel("additional dead time of the protection on track [ms]")
        axes.set_ylabel("mean distance [m]")
        axes.legend()
        return figure
