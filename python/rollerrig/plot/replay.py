"""Figures of a replay: what the controller of a rig makes of a log, beside what was measured."""

import xarray as xr
from matplotlib.figure import Figure

from rollerrig.plot.adhesion import per_axle


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
