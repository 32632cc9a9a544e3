"""Where a loaded wheelset touches: quasi-static contact over lateral position and yaw.

    Case, positions -> [static contact of the core] -> xarray.Dataset, one row per contact patch

The leading wheelset is in equilibrium under its static axle load with elastic normal forces only. Left of the running
direction is positive. Height and roll count from the unloaded, centred wheelset that touches both sides.
"""

from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from rollerrig import _core
from rollerrig.assembly.model import AssembledModel, assemble
from rollerrig.cases import as_case
from rollerrig.config import Case, load_case, load_profile
from rollerrig.results import variable


def pair_case(
    wheel: str,
    rail: str,
    *,
    gauge: float = 1.435,
    gauge_depth: float = 14e-3,
    back_to_back: float = 1.360,
    radius: float = 0.460,
    roller_radius: float | None = None,
) -> Case:
    """A lone wheelset on a track or, with a roller radius, on a pair of rollers whose generatrix is the rail's head.

    Args:
        wheel: wheel profile: a name of the catalogue, a TOML file or a file of points.
        rail: rail profile, likewise.
        gauge: distance between the gauge sides [m].
        gauge_depth: depth below the highest point at which the gauge is taken [m].
        back_to_back: distance between the flange backs [m].
        radius: wheel radius at the tape circle [m].
        roller_radius: radius at the crown of the rollers [m]; None: rails.

    Raises:
        ConfigError: all mistakes found; also where the wheels would miss the rails.
    """
    titles = [load_profile(wheel, "wheel").name or wheel, load_profile(rail, "rail").name or rail]
    changes: dict[str, object] = {
        "description": " on ".join(titles),
        "vehicle.wheel.profile": wheel,
        "vehicle.wheel.radius": radius,
        "vehicle.wheel.back_to_back": back_to_back,
        "vehicle.body.wheelset_1.position": [0.0, 0.0, radius],
        "support.profile": rail,
        "support.gauge": gauge,
        "support.gauge_depth": gauge_depth,
    }
    if roller_radius is not None:
        changes["support.roller_radius"] = f"{roller_radius} m"
    base = load_case("contact_benchmark_track" if roller_radius is None else "contact_benchmark_rollers")
    return base.with_changes({"name": "conicity"}).with_changes(changes)


_VARIABLES = {
    "lateral": ("m", "lateral_mm", 1e3, "lateral position of the wheelset, positive to the left"),
    "yaw": ("rad", "yaw_mrad", 1e3, "yaw angle of the wheelset"),
    "side": ("", "side", None, "wheel"),
    "patch": ("1", "patch", None, "number of the patch on its wheel, from the flange outwards"),
    "wheel_abscissa": ("m", "wheel_s_mm", 1e3, "EN abscissa S on the wheel profile, negative towards the flange"),
    "angle": ("rad", "angle_rad", 1.0, "slope of the wheel profile at the contact, as an angle"),
    "a": ("m", "a_mm", 1e3,
          "semi-axis along the rolling direction; of the equivalent ellipse of a non-elliptical contact patch"),
    "b": ("m", "b_mm", 1e3, "semi-axis across the rolling direction"),
    "approach": ("m", "approach_mm", 1e3, "elastic approach of the surfaces"),
    "normal": ("N", "normal_n", 1.0, "normal force"),
    "roll": ("rad", "roll_mrad", 1e3, "roll angle of the wheelset"),
    "height": ("m", "height_mm", 1e3, "height of the wheelset"),
    "peak_pressure": ("Pa", "peak_pressure_mpa", 1e-6, "largest pressure"),
    "weight": ("1", "weight", 1.0, "blending weight of the patch where two patches merge"),
    "rolling_radius": ("m", "rolling_radius_mm", 1e3, "wheel radius at the contact"),
    "width": ("m", "width_mm", 1e3, "loaded width across the rolling direction"),
    "area": ("m^2", "area_mm2", 1e6, "loaded area"),
    "rail_abscissa": ("m", "rail_y_mm", 1e3,
                      "abscissa on rail or roller, 0 at the highest point, negative towards the gauge side"),
}  # fmt: skip
"""Variable -> unit, its column of the CSV file, factor from SI (None: as it is), meaning."""


def contact(
    case: Case | str, positions: Iterable[tuple[float, float]] | None = None, *, roll: float | None = None
) -> xr.Dataset:
    """Contact patches of the leading wheelset under its static axle load.

    Args:
        case: vehicle, support and contact; its motion does not matter.
        positions: lateral position [m] and yaw [rad] of the wheelset; by default from -8 to 8 mm without yaw.
        roll: roll angle to hold [rad]; None: free to roll.

    Returns:
        One entry per contact patch along dimension `row`. The attribute `failed_positions` lists those without a
        result, as a sentence each; empty if all went well.

    Example:
        >>> import rollerrig as rr
        >>> table = rr.contact("contact_benchmark_track", [(0.0, 0.0)])
        >>> round(float(table["normal"].sum()), -2)
        20000.0
    """
    case = as_case(case)
    positions = [(float(y), 0.0) for y in np.linspace(-8e-3, 8e-3, 33)] if positions is None else positions
    model = assemble(case)
    wheelset, _, wheels, unloaded = leading_wheelset(model)
    load = model.axle_loads[wheelset]
    rows: list[tuple[Any, ...]] = []
    failed: list[str] = []
    for lateral, yaw in positions:
        found = wheels.solve(0.0, lateral, yaw, roll or 0.0, load, roll is None)
        if not found.converged:
            failed.append(
                f"lateral {1e3 * lateral:g} mm, yaw {1e3 * yaw:g} mrad: {load / 1e3:.4g} kN find no balance on the "
                "profiles; choose a position nearer to the middle, or let the wheelset roll"
            )
            continue
        for side in ("left", "right"):
            patches = [patch for patch in found.patches if patch.right == (side == "right") and patch.normal > 0.0]
            for count, patch in enumerate(sorted(patches, key=lambda p: p.wheel_s), start=1):
                shape = (patch.wheel_s, patch.angle, patch.a, patch.b, patch.approach, patch.normal)
                pose = (found.roll, found.z - unloaded)
                rest = (patch.peak_pressure, patch.weight, patch.wheel_radius, patch.width, patch.area, patch.rail_y)
                rows.append((lateral, yaw, side, count, *shape, *pose, *rest))
    columns = list(zip(*rows, strict=True)) if rows else [()] * len(_VARIABLES)
    kinds = {"side": str, "patch": int}
    variables: dict[str, Any] = {
        name: variable("row", np.array(column, dtype=kinds.get(name, float)), unit, meaning)
        for (name, (unit, _, _, meaning)), column in zip(_VARIABLES.items(), columns, strict=True)
    }
    attributes = {"title": case.description or case.name, "case": case.name, "wheelset": wheelset, "load_n": load}
    return xr.Dataset(variables, attrs={**attributes, "failed_positions": "\n".join(failed)})


COLUMNS = {column: (name, factor) for name, (_, column, factor, _) in _VARIABLES.items()}
"""Columns of the table of contacts: what they show, factor from SI."""


def contact_rows(data: xr.Dataset, columns: Mapping[str, tuple[str, float | None]]) -> list[list[object]]:
    """Variables over `row` as rows of a table, header first."""
    cells = (data[name] if factor is None else factor * data[name] for name, factor in columns.values())
    return [list(columns), *map(list, zip(*(cell.to_numpy().tolist() for cell in cells), strict=True))]


class LeadingWheelset(NamedTuple):
    """The foremost wheelset of a model."""

    name: str  # of the wheelset
    contacts: tuple[int, int]  # indices of its left and right contact
    contact: _core.StaticWheelsetContact  # static contact of the core
    unloaded: float  # height at which the centred wheelset touches on both sides [m]


def leading_wheelset(model: AssembledModel) -> LeadingWheelset:
    """The foremost wheelset and its static contact."""
    name = max(model.wheelsets, key=lambda wheelset: model.positions[wheelset][0])
    of_side = {wheel.side: wheel.contact for wheel in model.wheels if wheel.wheelset == name}
    contacts = (of_side["left"], of_side["right"])
    contact = _core.StaticWheelsetContact(model.core, *contacts)
    unloaded = max(contact.touch_height(0.0, 0.0, 0.0, 0.0, side) for side in (False, True))
    return LeadingWheelset(name, contacts, contact, unloaded)
