"""Where a loaded wheelset touches: quasi-static contact over lateral position and yaw, by every normal contact there is.

    Case, positions -> [static contact of the core] -> xarray.Dataset, one row per contact patch
                    -> contact_table with each `contact.normal` -> per wheel: patches, centre, width, approach, pressure, cost

The leading wheelset is in equilibrium under its static axle load with elastic normal forces only. Left of the running
direction is positive. Height and roll count from the unloaded, centred wheelset that touches both sides.

What each model is: `docs/theory/contact_forces.md`, `non_elliptic_contact.md`.
"""

from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from rollerrig import _core
from rollerrig.assembly.model import AssembledModel, assemble
from rollerrig.common.formatting import number
from rollerrig.config import Case, load_case, load_profile
from rollerrig.config.schema.contact import NORMAL_LAWS
from rollerrig.results import variable

DEFAULT_GAUGE = 1.435
DEFAULT_GAUGE_DEPTH = 14e-3
DEFAULT_BACK_TO_BACK = 1.360
DEFAULT_RADIUS = 0.460


def pair_case(
    wheel: str,
    rail: str,
    *,
    gauge: float = DEFAULT_GAUGE,
    gauge_depth: float = DEFAULT_GAUGE_DEPTH,
    back_to_back: float = DEFAULT_BACK_TO_BACK,
    radius: float = DEFAULT_RADIUS,
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
            for count, patch in enumerate(sorted(patches, key=lambda p: p.wheel_s), start=1):
                shape = (patch.wheel_s, patch.angle, patch.a, patch.b, patch.approach, patch.normal)
                pose = (found.roll, found.z - unloaded)
                rest = (patch.peak_pressure, patch.weight, patch.wheel_radius, patch.width, patch.area, patch.rail_y)
                rows.append((lateral, yaw, side, count, *shape, *pose, *rest))
    columns = list(zip(*rows, strict=True)) if rows else [()] * len(_VARIABLES)
    variables: dict[str, Any] = {
        name: variable("row", np.array(column, dtype=DTYPES.get(name, float)), unit, meaning)
        for (name, (unit, _, _, meaning)), column in zip(_VARIABLES.items(), columns, strict=True)
    }
    attributes = {"title": case.description or case.name, "case": case.name, "wheelset": wheelset, "load_n": load}
    return xr.Dataset(variables, attrs={**attributes, "failed_positions": "\n".join(failed)})


CSV_HEAD = ",".join(column for _, column, _, _ in _VARIABLES.values())
"""First line of a table of contacts."""


def contact_csv(table: xr.Dataset) -> str:
    """The table as CSV text in mm, mrad, N and MPa; lengths, angles and forces with twelve digits."""
    columns = []
    for name, (_, _, factor, _) in _VARIABLES.items():
        values = table[name].to_numpy()
        columns.append([str(v) for v in values] if factor is None else [f"{factor * v + 0.0:.12g}" for v in values])
    lines = [CSV_HEAD, *(",".join(row) for row in zip(*columns, strict=True))]
    return "\n".join(lines) + "\n"


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


DTYPES = {"side": str, "patch": int}


QUANTITIES = {
    "patches": ("1", "patches under load, each counted with its weight"),
    "normal": ("N", "sum of the normal forces"),
    "centre": ("m", "EN abscissa S of the centre of the pressures on the wheel, negative towards the flange"),
    "width": ("m", "loaded width across the rolling direction"),
    "area": ("m^2", "loaded area"),
    "approach": ("m", "largest elastic approach"),
    "peak_pressure": ("Pa", "largest pressure"),
}
REPEATS = 2000  # of one evaluation, to time it


def compare_contacts(
    case: Case, positions: Sequence[tuple[float, float]], *, roll: float | None = None, timed: bool = True
) -> xr.Dataset:
    """Normal contact of the leading wheelset under its axle load, at each position with each model.

    Args:
        case: vehicle, support and contact; `contact.normal` is what varies.
        positions: lateral position [m] and yaw [rad] of the wheelset.
        roll: roll angle to hold [rad]; None: free to roll.
        timed: measure `cost` too; a figure of this machine and this moment.

    Returns:
        Dataset over `model`, `position` and `side`: the quantities of QUANTITIES, NaN where there is no contact or no
        balance; `lateral` [m] and `yaw` [rad] over `position`; `cost` [s] over `model`: search and normal contact of one
        wheel, mean over the positions. The attribute `failed_positions` as of `contact_table`, named by model.
    """
    shape = (len(NORMAL_LAWS), len(positions), 2)
    data = {name: np.full(shape, np.nan) for name in QUANTITIES}
    cost = np.full(len(NORMAL_LAWS), np.nan)
    failed: list[str] = []
    title: dict[str, Any] = {}
    for i, model in enumerate(NORMAL_LAWS):
        chosen = case.with_changes({"contact.normal": model})
        table = contact_table(chosen, positions, roll=roll)
        title = {key: table.attrs[key] for key in ("title", "case", "wheelset", "load_n")}
        failed += [f"{model}: {line}" for line in table.attrs["failed_positions"].splitlines()]
        for j, (lateral, yaw) in enumerate(positions):
            here = (table["lateral"] == lateral) & (table["yaw"] == yaw)
            for k, side in enumerate(("left", "right")):
                rows = table.isel(row=(here & (table["side"] == side)).to_numpy())
                if rows.sizes["row"]:
                    for name, value in _of_wheel(rows).items():
                        data[name][i, j, k] = value
        if timed:
            cost[i] = _cost(chosen, table, positions)
    coordinates = {
        "model": list(NORMAL_LAWS),
        "side": ["left", "right"],
        "lateral": ("position", [lateral for lateral, _ in positions], {"units": "m"}),
        "yaw": ("position", [yaw for _, yaw in positions], {"units": "rad"}),
    }
    variables: dict[str, Any] = {
        name: variable(("model", "position", "side"), data[name], unit, meaning)
        for name, (unit, meaning) in QUANTITIES.items()
    }
    variables["cost"] = variable("model", cost, "s", "search and normal contact of one wheel")
    return xr.Dataset(variables, coordinates, {**title, "failed_positions": "\n".join(failed)})


NORMALS_HEAD = (
    "normal_contact,lateral_mm,yaw_mrad,side,patches,normal_n,"
    "centre_s_mm,width_mm,area_mm2,approach_mm,peak_pressure_mpa"
)
"""First line of a table of normal contacts."""


def comparison_csv(comparison: xr.Dataset) -> str:
    """The comparison as CSV text, one row per model, position and wheel, in mm, mrad, N and MPa."""
    factors = {"patches": 1.0, "normal": 1.0, "centre": 1e3, "width": 1e3, "area": 1e6, "approach": 1e3}
    lines = [NORMALS_HEAD]
    for model in comparison["model"].to_numpy():
        for j in range(comparison.sizes["position"]):
            for side in ("left", "right"):
                here = comparison.sel(model=model, side=side).isel(position=j)
                if not here["normal"] > 0.0:
                    continue
                values = [factor * float(here[name]) for name, factor in {**factors, "peak_pressure": 1e-6}.items()]
                place = [1e3 * float(here["lateral"]), 1e3 * float(here["yaw"])]
                numbers = [f"{v + 0.0:.9g}" for v in (*place, *values)]
                lines.append(",".join([str(model), *numbers[:2], side, *numbers[2:]]))
    return "\n".join(lines) + "\n"


def comparison_text(comparison: xr.Dataset) -> str:
    """A few lines for the terminal: per model its cost and the range of what it finds."""
    lines = []
    for model in comparison["model"].to_numpy():
        here = comparison.sel(model=model)

        def span(name: str, factor: float, of: xr.Dataset = here) -> str:
            low, high = factor * float(of[name].min()), factor * float(of[name].max())
            return f"{number(low, 3)} to {number(high, 3)}"

        step = float(np.abs(here["centre"].diff("position")).max()) if comparison.sizes["position"] > 1 else 0.0
        cost = "" if np.isnan(here["cost"]) else f", {number(1e6 * float(here['cost']), 2)} µs per wheel and evaluation"
        lines.append(
            f"{model}: {span('patches', 1.0)} patches, approach {span('approach', 1e6)} µm, peak pressure "
            f"{span('peak_pressure', 1e-6)} MPa, width {span('width', 1e3)} mm; the centre moves by up to "
            f"{number(1e3 * step, 3)} mm from one position to the next{cost}"
        )
    return "\n".join(lines)


def _of_wheel(rows: xr.Dataset) -> dict[str, float]:
    """All patches of one wheel as one: sums with their weights, the centre weighted with force, the largest pressure."""
    normal, weight = rows["normal"].to_numpy(), rows["weight"].to_numpy()
    return {
        "patches": float(weight.sum()),
        "normal": float(normal.sum()),
        "centre": float(rows["wheel_abscissa"].to_numpy() @ normal / normal.sum()),
        "width": float(rows["width"].to_numpy() @ weight),
        "area": float(rows["area"].to_numpy() @ weight),
        "approach": float(rows["approach"].max()),
        "peak_pressure": float(rows["peak_pressure"].max()),
    }


def _cost(case: Case, table: xr.Dataset, positions: Sequence[tuple[float, float]]) -> float:
    """Seconds for search and normal contact of one wheel, at the loaded positions."""
    model = assemble(case)
    _, _, contact, unloaded = leading_wheelset(model)
    times = []
    for lateral, yaw in positions:
        rows = table.isel(row=((table["lateral"] == lateral) & (table["yaw"] == yaw)).to_numpy())
        if rows.sizes["row"]:
            z, roll = float(rows["height"][0]) + unloaded, float(rows["roll"][0])
            times += [
                contact.seconds_per_contact(0.0, lateral, z, yaw, roll, side == "right", 1, REPEATS)
                for side in np.unique(rows["side"])
            ]
    return float(np.mean(times)) if times else float("nan")
