"""Figures of measured logs: a reconstructed rail and the stop on it, and what the controller of a rig makes of a log."""

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


def forces_over_time(found: xr.Dataset) -> Figure:
    """Contact force of each axle over its static load: as estimated at the instant, without the delay, with its band [-]."""
    force, load, band = found["force"], found["axle_load"], found["force_band"]
    ends = ((force - band, 5, ":", ""), (force + band, 5, ":", "95 %")) if found.attrs["force_noise"] > 0.0 else ()
    known = ((found["creep_force"], 2, "-.", "reference of the log"),) if "creep_force" in found else ()
    at_once, later = (
        (found["force_at_once"], 1, "--", "as estimated at the instant"),
        (force, 0, "-", "without the delay"),
    )
    return per_axle("force over load\n{} [-]", [(one / load, *look) for one, *look in (*ends, at_once, later, *known)])


def torques_over_time(found: xr.Dataset) -> Figure:
    """Torque of each axle as drive and speeds say, and as brake and motor say [kN m]."""
    by_drive, by_brake = 1e-3 * found["torque"], 1e-3 * found["torque_expected"]
    return per_axle(
        "torque\n{} [kN m]", [(by_drive, 0, "-", "by drive and speeds"), (by_brake, 1, "--", "by brake and motor")]
    )


def speeds_over_time(found: xr.Dataset, radius: float) -> Figure:
    """Circumference of measured and virtual wheels, and the virtual train [km/h]; radius of the wheels [m]."""
    return per_axle("speed\n{} [km/h]", [
        (3.6 * radius * found["axle_speed"], 0, "-", "wheel, measured"),
        (3.6 * radius * found["virtual_axle_speed"], 1, "--", "wheel of the virtual train"),
        (3.6 * found["train_speed"], 5, "-.", "virtual train"),
    ])  # fmt: skip
