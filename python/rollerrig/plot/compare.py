"""Figures of several supports side by side: one colour or style per support, both always in the same axes."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from rollerrig.plot.modes import shown_modes
from rollerrig.plot.style import (
    COLOURS,
    GREY,
    STYLES,
    legend_beside,
    look,
    panels,
)

MOST_MODES = 7  # modes in one figure; the others are in the table
HIGHEST_FREQUENCY = 20.0  # modes above are left out: supports hardly change them, and they squeeze the rest [Hz]
LEAST_DIFFERENCE = 0.2  # modes whose eigenvalues differ by less between the supports are left out [1/s]


def telling_modes(modes: Mapping[str, xr.Dataset]) -> list[str]:
    """Names of the modes that differ most between the supports, hunting modes first; those that all supports have."""
    first = next(iter(modes.values()))
    common = set.intersection(*(set(shown_modes(one)) for one in modes.values()))
    low = first["frequency"].max("speed") < HIGHEST_FREQUENCY
    names = [name for name in shown_modes(first) if name in common and bool(low.sel(mode=name))]

    def apart(name: str) -> float:
        own, of = first.sel(mode=name), [m.sel(mode=name) for m in modes.values()]
        keys = ("growth_rate", "angular_frequency")
        return max(sum(float(np.abs(one[key].to_numpy() - own[key].to_numpy()).max()) for key in keys) for one in of)

    hunting = [name for name in names if name.startswith("hunting")]
    others = [name for name in names if name not in hunting and (len(modes) == 1 or apart(name) > LEAST_DIFFERENCE)]
    others.sort(key=apart, reverse=True)
    return [*hunting, *others][:MOST_MODES]


def modes_side_by_side(modes: Mapping[str, xr.Dataset]) -> Figure:
    """Frequency and damping of the modes of `stability` over speed: a colour per mode, a line style per support."""
    names = telling_modes(modes)
    labels = ("frequency [Hz]", "damping ratio [%], unstable below 0")
    colours = [COLOURS[(1, 0, 2, 3, 4, 5, 6, 7)[number % 8]] for number in range(len(names))]
    with panels(labels, "speed [km/h]", 6.2, legend=False) as (figure, (frequency, damping)):
        for name, one in zip(names, colours, strict=True):
            for style, dataset in zip(STYLES, modes.values(), strict=False):
                mode = dataset.sel(mode=name)
                oscillates, width = mode["frequency"] > 0.0, 2.0 if name.startswith("hunting") else 1.2
                drawn: dict[str, Any] = {"color": one, "linestyle": style, "linewidth": width}
                frequency.plot(dataset["speed"], mode["frequency"].where(oscillates), **drawn)
                damping.plot(dataset["speed"], 100 * mode["damping"].where(oscillates), **drawn)
        damping.axhline(0.0, color=GREY, linewidth=1.0)
        low, high = damping.get_ylim()
        damping.set_ylim(max(low, -25.0), min(high, 65.0))
        frequency.set_ylim(bottom=0.0)
        by_name = [Line2D([], [], color=one, label=name) for one, name in zip(colours, names, strict=True)]
        by_style = [Line2D([], [], label=n, **{**look(k), "color": "black"}) for k, n in enumerate(modes)]
        legend_beside(frequency, handles=by_name, title="mode")
        legend_beside(damping, handles=by_style, title="on")
        return figure
