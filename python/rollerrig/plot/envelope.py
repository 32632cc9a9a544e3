"""Figures of an envelope map: regions over torque and adhesion with the closed forms on them, and runs of each over time."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, Rectangle
from matplotlib.tri import Triangulation
from numpy.typing import NDArray

from rollerrig.common.arrays import Array
from rollerrig.plot.control import Curve, Rows, error_curves, runs_beside, speed_curves
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

ERRORS = (0.003, 0.01, 0.03)  # contours of the tracking error


@house_style()
def region_map(found: xr.Dataset, load: float, names: Mapping[str, str]) -> Figure:
    """Regions of one load over torque and adhesion, runs as dots, tracking error as contours, closed forms as lines."""
    here = found.sel(load=load)
    figure, (axes,) = new_figure(1, height=5.0)
    shown = _regions(axes, here)
    _errors(axes, here)
    lines = _closed_forms(axes, here)
    rows, columns = np.nonzero(here["region"].to_numpy() != "")
    torques, adhesions = _map_unit(here)[1] * here["torque"].to_numpy(), here["adhesion"].to_numpy()
    axes.plot(torques[columns], adhesions[rows], ".", markersize=2.0, color="#333333", zorder=4)
    look: dict[str, Any] = {"edgecolor": "#444444", "linewidth": 0.4}
    handles: list[Any] = [
        *(Patch(facecolor=FILLS[n][0], hatch=FILLS[n][1], label=names[n], **look) for n in FILLS if n in shown),
        *lines,
        Line2D([], [], color="#0b3d91", linewidth=0.9, label="tracking error, RMS of train speed"),
        Line2D([], [], color="#333333", marker=".", markersize=3, linestyle="", label="a run"),
    ]
    figure.legend(handles=handles, loc="outside lower center", ncols=2)
    axes.set_title(f"axle load {1e-3 * float(here['axle_load']):.4g} kN ({load:g} of the case's own)", loc="left")
    side = ", negative brakes" if float(found["torque"][0]) < 0 else ""
    axes.set(xlabel=f"torque on each axle [{_map_unit(here)[0]}]{side}", ylabel="adhesion of the reproduced rail [-]")
    axes.grid(False)
    return figure


def _unit(largest: float) -> tuple[str, float]:
    """Unit that suits torques up to the largest [N m], and what multiplies them."""
    return ("kN m", 1e-3) if largest >= 500.0 else ("N m", 1.0)


def _map_unit(found: xr.Dataset) -> tuple[str, float]:
    return _unit(float(np.abs(found["torque"]).max()))


def _nearest(regions: NDArray[np.str_]) -> NDArray[np.str_]:
    """The region of the nearest run where refining saw no need for one."""
    from scipy.ndimage import distance_transform_edt

    missing = regions == ""
    if missing.all() or not missing.any():
        return regions
    places = distance_transform_edt(missing, return_distances=False, return_indices=True)
    return np.asarray(regions[tuple(places)])


def _regions(axes: Axes, here: xr.Dataset) -> set[str]:
    scale = _map_unit(here)[1]
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


def _errors(axes: Axes, here: xr.Dataset) -> None:
    """Contours over the runs there are, joined to triangles on their lattice, whose axes may be uneven."""
    error = here["tracking_rms"].to_numpy()
    rows, columns = np.nonzero(np.isfinite(error))
    if len(rows) < 4 or np.ptp(rows) == 0 or np.ptp(columns) == 0:
        return
    triangles = Triangulation(columns, rows).triangles
    x, y = _map_unit(here)[1] * here["torque"].to_numpy()[columns], here["adhesion"].to_numpy()[rows]
    values = np.log10(np.maximum(error[rows, columns], 1e-6))
    levels = [level for level in np.log10(ERRORS) if values.min() < level < values.max()]
    if not levels:
        return
    drawn = axes.tricontour(
        Triangulation(x, y, triangles), values, levels=levels, colors="#0b3d91", linewidths=0.9, linestyles="solid"
    )
    axes.clabel(drawn, fmt={level: f"{100 * 10**level:.2g} %" for level in levels}, fontsize=7.5)


def _closed_forms(axes: Axes, here: xr.Dataset) -> list[Line2D]:
    shown: dict[str, Line2D] = {}
    low, high = sorted(axes.get_xlim())
    adhesion, scale = here["line_adhesion"].to_numpy(), _map_unit(here)[1]
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


def runs_over_time(runs: Mapping[str, xr.Dataset], radius: float, friction: float) -> Figure:
    """Up to three runs beside each other: speeds, torques, friction used and tracking error of the axle that uses most of it.

    Radius of the wheels [m]; friction between wheel and roller [-].
    """
    unit, scale = _unit(max(float(np.abs(run["roller_torque"]).max()) for run in runs.values()))

    def torques(run: xr.Dataset) -> list[Curve]:
        return [
            (scale * (run["brake_torque"] + run["traction_torque"]), 4, "-", "torque on the axle"),
            (scale * run["roller_torque"], 3, "-", "of the roller drive"),
            (scale * run["roller_command"], 2, ":", "its command"),
        ]

    def used(run: xr.Dataset) -> list[Curve]:
        normal, force = (run[name].sum(("wheel", "patch")) for name in ("patch_normal", "patch_creep_force_x"))
        one = xr.ones_like(run["time"])
        limits = [(limit * one, 5, "--", "") for limit in (-1.0, 1.0)]
        return [(force / np.maximum(friction * normal, 1.0), 0, "-", ""), *limits]

    rows: Rows = {
        "speed [km/h]": lambda run: speed_curves(run, radius),
        f"torque [{unit}]": torques,
        "contact force over\nfriction limit [-]": used,
        "tracking error\n[% of train speed]": lambda run: error_curves(run, radius),
    }
    return runs_beside({title: _one_axle(run) for title, run in runs.items()}, rows, 7.0, sharey="row")


def _one_axle(run: xr.Dataset) -> xr.Dataset:
    """The axle that uses most friction, with its wheels."""
    wheels = run.sizes["wheel"] // run.sizes["axle"]
    force, normal = (run[name].sum("patch").to_numpy() for name in ("patch_creep_force_x", "patch_normal"))
    used = (np.abs(force) / np.maximum(normal, 1.0)).max(axis=0)
    axle = int(np.argmax(used)) // wheels
    return run.isel(axle=axle, wheel=slice(axle * wheels, (axle + 1) * wheels))
