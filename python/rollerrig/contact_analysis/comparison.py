"""The normal contacts side by side: one wheelset at the same positions, by every model there is.

    Case, positions -> contact_table with each `contact.normal` -> per wheel: patches, centre, width, approach, pressure, cost

Left of the running direction is positive. What each model is: `docs/theory/contact_forces.md`, `non_elliptic_contact.md`.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr

from rollerrig.assembly.model import assemble
from rollerrig.common.formatting import number
from rollerrig.config import Case
from rollerrig.config.schema.contact_law import NORMAL_LAWS
from rollerrig.contact_analysis.static_contact import contact_table, leading_wheelset
from rollerrig.results import variable

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


CSV_HEAD = "normal_contact,lateral_mm,yaw_mrad,side,patches,normal_n,centre_s_mm,width_mm,area_mm2,approach_mm,peak_pressure_mpa"
"""First line of a table of normal contacts."""


def comparison_csv(comparison: xr.Dataset) -> str:
    """The comparison as CSV text, one row per model, position and wheel, in mm, mrad, N and MPa."""
    factors = {"patches": 1.0, "normal": 1.0, "centre": 1e3, "width": 1e3, "area": 1e6, "approach": 1e3}
    lines = [CSV_HEAD]
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
