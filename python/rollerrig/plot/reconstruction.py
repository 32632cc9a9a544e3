"""Figures of a reconstructed rail: its friction over distance, and the measured stop beside the computed one."""

import xarray as xr
from matplotlib.figure import Figure

from rollerrig.plot.adhesion import per_axle
from rollerrig.plot.style import line, panels


def friction_over_distance(rail: xr.Dataset) -> Figure:
    """Friction at no slip of a reconstructed rail, of each axle alone, and adhesion used [-]."""
    along = rail["distance"].to_numpy()
    with panels(("friction\nand adhesion [-]",), "distance [m]", 3.2) as (figure, (axes,)):
        for k, axle in enumerate(rail["axle"].to_numpy()):
            one = rail.sel(axle=axle)
            line(axes, along, one["friction_of_axle"], k + 1, "none", f"friction, {axle}", marker="o", markersize=3.0)
            line(axes, along, one["used_adhesion"], k + 1, ":", f"used, {axle}")
        line(axes, along, rail["friction"], 0, "-", "friction", linewidth=1.6)
        axes.set_ylim(bottom=0.0)
        return figure


def stop_over_time(log: xr.Dataset, run: xr.Dataset, radius: float) -> Figure:
    """Speeds of train and wheels, measured and computed; radius of the wheels [m]."""
    both = ((log, "measured", 0, "-"), (run, "computed", 1, "--"))
    wheels = [(3.6 * radius * one["axle_speed"], k, style, f"wheel, {label}") for one, label, k, style in both]
    return per_axle(
        "{}\nspeed [km/h]",
        [*wheels, *((3.6 * one["train_speed"], k + 4, style, f"train, {label}") for one, label, k, style in both)],
    )


def pressures_over_time(log: xr.Dataset, run: xr.Dataset) -> Figure:
    """Pressures of the brake cylinders, measured and computed."""
    measured, computed = (1e-5 * one["cylinder_pressure"] for one in (log, run))
    return per_axle("cylinder\n{} [bar]", [(measured, 0, "-", "measured"), (computed, 1, "--", "computed")])
