"""Figure of a contact table: where a loaded wheelset touches, and how hard, over its lateral position."""

from __future__ import annotations

from typing import Any

import xarray as xr
from matplotlib.figure import Figure

from rollerrig.plot.style import COLOURS, MARKERS, house_style, new_figure


def contact_figure(table: xr.Dataset) -> Figure:
    """Position on the wheel, normal force, size of the patches and pose of the wheelset.

    Args:
        table: what `contact_table` returns; one entry per patch along `row`.
    """
    with house_style():
        figure, (place, force, size, pose) = new_figure(4, height=9.0, sharex=True)
        lateral = 1e3 * table["lateral"]
        for number, side in enumerate(("left", "right")):
            here = (table["side"] == side).to_numpy()
            y = lateral[here]
            look: dict[str, Any] = {"linestyle": "none", "markersize": 4, "color": COLOURS[number]}
            place.plot(y, 1e3 * table["wheel_abscissa"][here], MARKERS[number], label=side, **look)
            force.plot(y, 1e-3 * table["normal"][here], MARKERS[number], label=side, **look)
            size.plot(
                y, 1e3 * table["a"][here], MARKERS[number], label=f"{side}, a along the rolling direction", **look
            )
            size.plot(y, 1e3 * table["b"][here], "x+"[number], label=f"{side}, b across it", **look)
        pose.plot(lateral, 1e3 * table["height"], ".", color="black", label="height [mm]")
        pose.plot(lateral, 1e3 * table["roll"], "x", markersize=4, color=COLOURS[2], label="roll [mrad]")
        place.set_ylabel("on the wheel S [mm]")
        force.set_ylabel("normal force [kN]")
        size.set_ylabel("semi-axes [mm]")
        pose.set_ylabel("pose of the wheelset")
        pose.set_xlabel("lateral position of the wheelset [mm], positive to the left")
        title = f"{table.attrs['case']}: {table.attrs['wheelset']} under {1e-3 * table.attrs['load_n']:.4g} kN"
        place.set_title(title, loc="left")
        for axes in (place, size, pose):
            axes.legend(loc="best")
        return figure
