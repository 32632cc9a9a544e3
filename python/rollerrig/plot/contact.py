"""Figure of a contact table: where a loaded wheelset touches, and how hard, over its lateral position."""

from __future__ import annotations

import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

_COLOURS = {"left": "#1f5fa8", "right": "#c2571a"}


def contact_figure(table: xr.Dataset) -> Figure:
    """Position on the wheel, normal force, size of the patches and pose of the wheelset.

    Args:
        table: what `contact_table` returns; one entry per patch along `row`.
    """
    figure = Figure(figsize=(10, 7), layout="constrained")
    position, force, size, pose = figure.subplots(2, 2, sharex=True).flat
    lateral = 1e3 * table["lateral"]
    for side, colour in _COLOURS.items():
        here = table["side"] == side
        y = lateral[here]
        position.plot(y, 1e3 * table["wheel_abscissa"][here], "o", ms=4, color=colour, label=side)
        force.plot(y, 1e-3 * table["normal"][here], "o", ms=4, color=colour)
        size.plot(y, 1e3 * table["a"][here], "o", ms=4, color=colour)
        size.plot(y, 1e3 * table["b"][here], "x", ms=4, color=colour)
    pose.plot(lateral, 1e3 * table["height"], ".", color="black", label="height [mm]")
    pose.plot(lateral, 1e3 * table["roll"], ".", color="#777777", label="roll [mrad]")
    _finish(position, "contact on the wheel S [mm]", "flange is negative")
    _finish(force, "normal force [kN]", "")
    _finish(size, "semi-axes [mm]", "o along, x across the rolling direction")
    _finish(pose, "pose of the wheelset", "")
    position.legend(frameon=False)
    pose.legend(frameon=False)
    for axes in (size, pose):
        axes.set_xlabel("lateral position [mm], positive to the left")
    figure.suptitle(f"{table.attrs['case']}: {table.attrs['wheelset']} under {1e-3 * table.attrs['load_n']:.4g} kN")
    return figure


def _finish(axes: Axes, label: str, note: str) -> None:
    axes.set_ylabel(label)
    axes.set_title(note, fontsize="small", loc="left")
    axes.grid(alpha=0.3)
