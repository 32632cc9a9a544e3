"""Where a loaded wheelset touches: quasi-static contact over lateral position and yaw.

    Case, positions -> [static contact of the core] -> xarray.Dataset, one row per contact patch

The leading wheelset is in equilibrium under its static axle load with elastic normal forces only. Left of the running
direction is positive. Height and roll count from the unloaded, centred wheelset that touches both sides.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from rollerrig import _core
from rollerrig.assembly.model import AssembledModel, assemble
from rollerrig.config import Case
from rollerrig.results import variable

_VARIABLES = {
    "lateral": ("m", "lateral position of the wheelset, positive to the left"),
    "yaw": ("rad", "yaw angle of the wheelset"),
    "side": ("", "wheel"),
    "patch": ("1", "number of the patch on its wheel, from the flange outwards"),
    "wheel_abscissa": ("m", "EN abscissa S on the wheel profile, negative towards the flange"),
    "angle": ("rad", "slope of the wheel profile at the contact, as an angle"),
    "a": ("m", "semi-axis along the rolling direction; of the equivalent ellipse of a non-elliptical contact patch"),
    "b": ("m", "semi-axis across the rolling direction"),
    "approach": ("m", "elastic approach of the surfaces"),
    "normal": ("N", "normal force"),
    "roll": ("rad", "roll angle of the wheelset"),
    "height": ("m", "height of the wheelset"),
    "peak_pressure": ("Pa", "largest pressure"),
    "weight": ("1", "blending weight of the patch where two patches merge"),
    "rolling_radius": ("m", "wheel radius at the contact"),
    "width": ("m", "loaded width across the rolling direction"),
    "area": ("m^2", "loaded area"),
    "rail_abscissa": ("m", "abscissa on rail or roller, 0 at the highest point, negative towards the gauge side"),
}

# Column of the CSV -> variable and factor from SI.
_COLUMNS = {
    "lateral_mm": ("lateral", 1e3),
    "yaw_mrad": ("yaw", 1e3),
    "side": ("side", None),
    "patch": ("patch", None),
    "wheel_s_mm": ("wheel_abscissa", 1e3),
    "angle_rad": ("angle", 1.0),
    "a_mm": ("a", 1e3),
    "b_mm": ("b", 1e3),
    "approach_mm": ("approach", 1e3),
    "normal_n": ("normal", 1.0),
    "roll_mrad": ("roll", 1e3),
    "height_mm": ("height", 1e3),
    "peak_pressure_mpa": ("peak_pressure", 1e-6),
    "weight": ("weight", 1.0),
    "rolling_radius_mm": ("rolling_radius", 1e3),
    "width_mm": ("width", 1e3),
    "area_mm2": ("area", 1e6),
    "rail_y_mm": ("rail_abscissa", 1e3),
}


def contact_table(case: Case, positions: Iterable[tuple[float, float]], *, roll: float | None = None) -> xr.Dataset:
    """Contact patches of the leading wheelset at each position.

    Args:
        case: vehicle, support and contact; its motion does not matter.
        positions: lateral position [m] and yaw [rad] of the wheelset.
        roll: roll angle to hold [rad]; None: free to roll.

    Returns:
        One entry per contact patch along dimension `row`. The attribute `failed_positions` lists those without a
        result, as a sentence each; empty if all went well.

    Example:
        >>> from rollerrig import load_case
        >>> table = contact_table(load_case("contact_benchmark_track"), [(0.0, 0.0)])
        >>> round(float(table["normal"].sum()), -2)
        20000.0
    """
    model = assemble(case)
    wheelset, _, contact, unloaded = leading_wheelset(model)
    load = model.axle_loads[wheelset]
    rows: list[tuple[Any, ...]] = []
    failed: list[str] = []
    for lateral, yaw in positions:
        found = contact.solve(0.0, lateral, yaw, roll or 0.0, load, roll is None)
        if not found.converged:
            failed.append(
                f"lateral {1e3 * lateral:g} mm, yaw {1e3 * yaw:g} mrad: {load / 1e3:.4g} kN find no balance on the "
                "profiles; choose a position nearer to the middle, or let the wheelset roll"
            )
            continue
        for side in ("left", "right"):
            patches = [patch for patch in found.patches if patch.right == (side == "right") and patch.normal > 0.0]
            for number, patch in enumerate(sorted(patches, key=lambda p: p.wheel_s), start=1):
                shape = (patch.wheel_s, patch.angle, patch.a, patch.b, patch.approach, patch.normal)
                pose = (found.roll, found.z - unloaded)
                rest = (patch.peak_pressure, patch.weight, patch.wheel_radius, patch.width, patch.area, patch.rail_y)
                rows.append((lateral, yaw, side, number, *shape, *pose, *rest))
    columns = list(zip(*rows, strict=True)) if rows else [()] * len(_VARIABLES)
    variables: dict[str, Any] = {
        name: variable("row", np.array(column, dtype=_dtype(name)), unit, meaning)
        for (name, (unit, meaning)), column in zip(_VARIABLES.items(), columns, strict=True)
    }
    attributes = {"title": case.description or case.name, "case": case.name, "wheelset": wheelset, "load_n": load}
    return xr.Dataset(variables, attrs={**attributes, "failed_positions": "\n".join(failed)})


CSV_HEAD = ",".join(_COLUMNS)
"""First line of a table of contacts."""


def contact_csv(table: xr.Dataset) -> str:
    """The table as CSV text in mm, mrad, N and MPa; lengths, angles and forces with twelve digits."""
    columns = []
    for name, factor in _COLUMNS.values():
        values = table[name].to_numpy()
        columns.append([str(v) for v in values] if factor is None else [f"{factor * v + 0.0:.12g}" for v in values])
    lines = [CSV_HEAD, *(",".join(row) for row in zip(*columns, strict=True))]
    return "\n".join(lines) + "\n"


class LeadingWheelset(NamedTuple):
    """The foremost wheelset of a model.

    Attributes:
        name: of the wheelset.
        contacts: indices of its left and right contact.
        contact: static contact of the core.
        unloaded: height at which the centred wheelset touches on both sides [m].
    """

    name: str
    contacts: tuple[int, int]
    contact: _core.StaticWheelsetContact
    unloaded: float


def leading_wheelset(model: AssembledModel) -> LeadingWheelset:
    """The foremost wheelset and its static contact."""
    name = max(model.wheelsets, key=lambda wheelset: model.positions[wheelset][0])
    of_side = {wheel.side: wheel.contact for wheel in model.wheels if wheel.wheelset == name}
    contacts = (of_side["left"], of_side["right"])
    contact = _core.StaticWheelsetContact(model.core, *contacts)
    unloaded = max(contact.touch_height(0.0, 0.0, 0.0, 0.0, side) for side in (False, True))
    return LeadingWheelset(name, contacts, contact, unloaded)


def _dtype(name: str) -> type:
    return {"side": str, "patch": int}.get(name, float)
