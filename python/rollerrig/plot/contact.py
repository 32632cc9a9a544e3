"""Figure of a contact table: where a loaded wheelset touches, and how hard, over its lateral position."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from rollerrig.plot.into import into_axes
from rollerrig.plot.style import (
    COLOURS,
    MARKERS,
    STYLES,
    headline,
    house_style,
    legend_above,
    legend_below,
    new_figure,
    new_grid,
)


@into_axes
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


COMPARED = {
    "centre": ("centre on the\nwheel S [mm]", 1e3),
    "width": ("width [mm]", 1e3),
    "approach": ("approach [µm]", 1e6),
    "peak_pressure": ("peak pressure\n[MPa]", 1e-6),
    "patches": ("patches", 1.0),
}


@into_axes
def comparison_figure(comparison: xr.Dataset, side: str = "left") -> Figure:
    """Normal contacts side by side over the lateral position, one wheel.

    Args:
        comparison: what `compare_contacts` returns.
        side: wheel to show.
    """
    with house_style():
        figure, panels = new_figure(len(COMPARED), height=8.5, sharex=True)
        shown = comparison.sel(side=side)
        lateral = 1e3 * shown["lateral"]
        for axes, (name, (label, factor)) in zip(panels, COMPARED.items(), strict=True):
            for number, model in enumerate(shown["model"].to_numpy()):
                look: dict[str, Any] = {"markersize": 3, "linewidth": 1.0}
                axes.plot(
                    lateral,
                    factor * shown[name].sel(model=model),
                    MARKERS[number] + STYLES[number],
                    color=COLOURS[number],
                    label=str(model),
                    **look,
                )
            axes.set_ylabel(label)
            if name == "patches":
                axes.yaxis.set_major_locator(MaxNLocator(integer=True))
        panels[-1].set_xlabel("lateral position of the wheelset [mm], positive to the left")
        load = 1e-3 * comparison.attrs["load_n"]
        what = f"{comparison.attrs['case']}: {comparison.attrs['wheelset']} under {load:.4g} kN, {side} wheel"
        panels[0].set_title(what, loc="left")
        legend_above(figure, panels[0])
        return figure


@into_axes
def creep_comparison_figure(comparison: xr.Dataset, side: str = "left") -> Figure:
    """Creep laws side by side over the lateral position, one wheel: a column per normal contact; points: exact solver.

    Args:
        comparison: what `compare_creep` returns.
        side: wheel to show.
    """
    with house_style():
        normals = [str(name) for name in comparison["normal"].to_numpy()]
        figure, grid = new_grid(2, len(normals), 8.4, 6.2, sharex=True, sharey="row")
        lateral = 1e3 * comparison["lateral"].to_numpy()
        for column, normal in enumerate(normals):
            shown = comparison.sel(normal=normal, side=side)
            for axes, name in zip(grid[:, column], ("x", "y"), strict=True):
                for number, law in enumerate(shown["law"].to_numpy()):
                    axes.plot(lateral, 100 * shown[f"force_{name}"].sel(law=law), STYLES[number % len(STYLES)],
                              color=COLOURS[number], label=str(law))  # fmt: skip
                axes.plot(
                    lateral, 100 * shown[f"exact_{name}"], "o", color="black", ms=3.5, label="exact solver", zorder=5
                )
                axes.set_ylim(-115.0, 115.0)  # a law without saturation leaves the picture
            grid[0][column].set_title(f"contact.normal = {normal}")
            grid[1][column].set_xlabel("lateral position [mm], positive to the left")
        grid[0][0].set_ylabel("longitudinal force\non the wheel [% of μN]")
        grid[1][0].set_ylabel("lateral force\non the wheel [% of μN]")
        yaw = 1e3 * comparison["yaw"].to_numpy()
        turned = f"yaw {yaw[0]:g} mrad" if np.all(yaw == yaw[0]) else f"yaw {yaw.min():g} to {yaw.max():g} mrad"
        load = 1e-3 * comparison.attrs["load_n"]
        headline(
            figure,
            f"{comparison.attrs['case']}: {load:.4g} kN, {turned}, friction {comparison.attrs['friction']:g}, {side} wheel",
        )
        legend_below(figure, grid[0][0])
        return figure
