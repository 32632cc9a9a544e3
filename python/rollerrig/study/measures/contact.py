"""Of the contact of the leading wheelset under its static axle load, at one position."""

from __future__ import annotations

import numpy as np

from rollerrig.config import Case
from rollerrig.config.schema.plan import ContactMeasure
from rollerrig.contact_analysis.static_contact import contact_table

QUANTITIES = {
    "patches": ("1", "number of contact patches of both wheels"),
    "peak_pressure": ("Pa", "largest pressure"),
    "contact_area": ("m^2", "loaded area of both wheels"),
    "normal_largest": ("N", "largest normal force of a patch"),
    "contact_angle_largest": ("rad", "largest |slope of the wheel profile| at a contact"),
    "rolling_radius_difference": ("m", "left less right: of the patch with the largest normal force of each wheel"),
}


def measure(case: Case, options: ContactMeasure) -> dict[str, float]:
    """Static contact at a lateral position and yaw angle; the numbers of QUANTITIES.

    Raises:
        ValueError: a wheel does not touch.
    """
    table = contact_table(case, [(options.lateral, options.yaw)])
    radii = {}
    for side in ("left", "right"):
        own = table.isel(row=(table["side"] == side).to_numpy())
        if not own.sizes["row"]:
            raise ValueError(f"the {side} wheel does not touch")
        radii[side] = float(own["rolling_radius"][int(np.argmax(own["normal"].to_numpy()))])
    return {
        "patches": float(table.sizes["row"]),
        "peak_pressure": float(table["peak_pressure"].max()),
        "contact_area": float(table["area"].sum()),
        "normal_largest": float(table["normal"].max()),
        "contact_angle_largest": float(abs(table["angle"]).max()),
        "rolling_radius_difference": radii["left"] - radii["right"],
    }
