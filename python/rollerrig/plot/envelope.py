"""Figures of an envelope map: regions over torque and adhesion with the closed forms on them."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, Rectangle
from numpy.typing import NDArray

from rollerrig.common.arrays import Array
from rollerrig.plot.style import cell_edges, house_style, new_figure

FILLS: Mapping[str, tuple[str, str]] = {
    "grip": ("#e3f1e3", ""),
    "slide": ("#b9dcba", "..."),
    "held": ("#7fb98b", "ooo"),
    "drive_grip": ("#f6c8a0", "///"),
    "drive_slide": ("#ef9a64", "\\\\\\"),
    "drive_recovery": ("#f4dd8f", "|||"),
    "drive_power": ("#c9b3dc", "---"),
    "contact": ("#c9504a", "xxx"),
    "tracking": ("#a9c4e4", "++"),
    "failed": ("#555555", ""),
}
"""Region -> colour and hatching: distinguished without colour too."""

LINES: Mapping[str, tuple[str, Any]] = {
    "line_grip": ("#1b5e20", "-"),
    "line_contact": ("#7f0000", "-"),
    "line_drive_grip": ("#8a4500", "-."),
    "line_drive_slide": ("#8a4500", "--"),
    "line_drive_recovery": ("#6b5b00", ":"),
    "line_vehicle": ("#000000", (0, (1, 1))),
}
"""Closed form -> colour, style."""


@house_style()
def region_map(found: xr.Dataset, load: float, names: Mapping[str, str]) -> Figure:
    """Regions of one load over torque and adhesion, runs as dots, closed forms as lines."""
    here = found.sel(load=load)
    figure, (axes,) = new_figure(1, height=5.0)
    shown = _regions(axes, here)
    lines = _closed_forms(axes, here)
    rows, columns = np.nonzero(here["region"].to_numpy() != "")
    torques, adhesions = _unit(here)[1] * here["torque"].to_numpy(), here["adhesion"].to_numpy()
    axes.plot(torques[columns], adhesions[rows], ".", markersize=2.0, color="#333333", zorder=4)
    look: dict[str, Any] = {"edgecolor": "#444444", "linewidth": 0.4}
    handles: list[Any] = [
        *(Patch(facecolor=FILLS[n][0], hatch=FILLS[n][1], label=names[n], **look) for n in FILLS if n in shown),
        *lines,
        Line2D([], [], color="#333333", marker=".", markersize=3, linestyle="", label="a run"),
    ]
    figure.legend(handles=handles, loc="outside lower center", ncols=2)
    axes.set_title(f"axle load {1e-3 * float(here['axle_load']):.4g} kN ({load:g} of the case's own)", loc="left")
    side = ", negative brakes" if float(found["torque"][0]) < 0 else ""
    axes.set(xlabel=f"torque on each axle [{_unit(here)[0]}]{side}", ylabel="adhesion of the reproduced rail [-]")
    axes.grid(False)
    return figure


def _unit(found: xr.Dataset) -> tuple[str, float]:
    """Unit that suits the torques of a map, and what multiplies them."""
    return ("kN m", 1e-3) if float(np.abs(found["torque"]).max()) >= 500.0 else ("N m", 1.0)


def _nearest(regions: NDArray[np.str_]) -> NDArray[np.str_]:
    """The region of the nearest run where refining saw no need for one."""
    from scipy.ndimage import distance_transform_edt

    missing = regions == ""
    if missing.all() or not missing.any():
        return regions
    places = distance_transform_edt(missing, return_distances=False, return_indices=True)
    return np.asarray(regions[tuple(places)])


def _regions(axes: Axes, here: xr.Dataset) -> set[str]:
    scale = _unit(here)[1]
    x, y = scale * cell_edges(here["torque"].to_numpy()), cell_edges(here["adhesion"].to_numpy())
    regions = _nearest(here["region"].to_numpy())
    for j, row in enumerate(regions):
        ends = [0, *(np.flatnonzero(row[1:] != row[:-1]) + 1), len(row)]
        for a, b in ((a, b) for a, b in zip(ends, ends[1:], strict=False) if str(row[a]) in FILLS):
            colour, hatch = FILLS[str(row[a])]
            place: Any = ((x[a], y[j]), x[b] - x[a], y[j + 1] - y[j])
            axes.add_patch(Rectangle(*place, facecolor=colour, edgecolor="none", linewidth=0))
            if hatch:
                axes.add_patch(Rectangle(*place, fill=False, hatch=hatch, edgecolor="#00000055", linewidth=0))
    axes.set(xlim=(x[0], x[-1]), ylim=(max(0.0, y[0]), y[-1]))
    if here["torque"][-1] <= 0:
        axes.invert_xaxis()  # more torque to the right
    return {str(name) for name in np.unique(regions)}


def _closed_forms(axes: Axes, here: xr.Dataset) -> list[Line2D]:
    shown: dict[str, Line2D] = {}
    low, high = sorted(axes.get_xlim())
    adhesion, scale = here["line_adhesion"].to_numpy(), _unit(here)[1]
    for side in here["side"].to_numpy():
        sign = -1.0 if side == "brake" else 1.0
        for name in LINES:
            torque = sign * scale * here[name].sel(side=side).to_numpy()
            if np.any(np.isfinite(torque) & (torque > low) & (torque < high)):
                shown[name] = _highlighted(axes, torque, adhesion, name, here[name].attrs["long_name"])
        contact = scale * here["line_contact"].sel(side=side).to_numpy()
        end = max(abs(limit) for limit in axes.get_xlim())
        if np.isfinite(contact).any() and end > np.nanmin(contact):
            # Where the wheel slides on the rail, sliding on the roller begins at a level of adhesion.
            level = float(here["contact_adhesion"].sel(side=side))
            _highlighted(axes, sign * np.array([np.nanmin(contact), end]), np.array([level, level]), "line_contact")
    return [shown[name] for name in LINES if name in shown]


def _highlighted(axes: Axes, x: Array, y: Array, name: str, label: str = "") -> Line2D:
    """A line of LINES on a light ground, to stand out from the regions."""
    axes.plot(x, y, color="white", linewidth=3.0, alpha=0.8)
    return axes.plot(x, y, color=LINES[name][0], linestyle=LINES[name][1], linewidth=1.6, label=label)[0]
