"""A run's wheel-rail forces and accelerations as a table: every quantity with its statistics, its filter and its limit.

run -> wheel-rail forces, accelerations -> [assessment] -> rows -> running_safety.csv, summary.json, report
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import xarray as xr

from rollerrig.analysis.ride import accelerations, ride, weighted_rms
from rollerrig.analysis.wheel_rail_forces import QUOTIENT_LIMIT, STATISTICS, filtered, statistics, wheel_forces

QUANTITIES = (
    "guiding_force",
    "wheel_load",
    "derailment_quotient",
    "wheel_unloading",
    "guiding_force_sum",
    "wear_number",
)
"""Of wheels and wheelsets, in the order of the tables."""

UNFILTERED = "none"


@dataclass(frozen=True)
class Assessment:
    """What was read off a run.

    Attributes:
        forces: what `wheel_forces` returns.
        assessed: what `filtered` makes of it, or the unfiltered forces where the run cannot be filtered.
        points: accelerations at points of the bodies, filtered where the run can be.
        unfiltered: the same, unfiltered.
        weighted: weighted r.m.s. accelerations; None where the run cannot be filtered.
        notes: why something is not filtered, a sentence each.
    """

    forces: xr.Dataset
    assessed: xr.Dataset
    points: xr.Dataset
    unfiltered: xr.Dataset
    weighted: xr.DataArray | None
    notes: tuple[str, ...]


@dataclass(frozen=True)
class Row:
    """One quantity at one place.

    Attributes:
        quantity: name of the variable; accelerations with their direction.
        place: wheel, wheelset or point.
        unit: of the statistics and the limit.
        filter: what was done to the signal before.
        statistics: by the names of STATISTICS; NaN where none exists.
        limit: of the quantity's magnitude; NaN if there is none.
    """

    quantity: str
    place: str
    unit: str
    filter: str
    statistics: dict[str, float]
    limit: float = math.nan

    @property
    def part_of_limit(self) -> float:
        """The larger of the two outer percentiles' magnitudes over the limit [-]; NaN without a limit."""
        outer = [abs(self.statistics[name]) for name in ("percentile_0_15", "percentile_99_85")]
        return max(outer) / self.limit


def assess(run: xr.Dataset) -> Assessment:
    """Read a run off, filtered as EN 14363 does where the run's output_step and length allow.

    Args:
        run: results of `simulate` or `load_run`.
    """
    notes: list[str] = []
    read, unfiltered = wheel_forces(run), accelerations(run)
    points, assessed, weighted = unfiltered, read.drop_vars("patch_wear_number"), None
    try:
        assessed = filtered(read)
    except ValueError as cause:
        notes.append(f"Wheel forces are not filtered: {cause}.")
    if unfiltered.sizes["point"]:
        try:
            points, weighted = ride(unfiltered), weighted_rms(unfiltered)
        except ValueError as cause:
            notes.append(f"Accelerations are not filtered: {cause}.")
    return Assessment(read, assessed, points, unfiltered, weighted, tuple(notes))


def table(assessment: Assessment) -> list[Row]:
    """All rows, wheels first, then wheelsets, then points of the bodies."""
    rows = []
    for name in QUANTITIES:
        values = assessment.assessed[name]
        rows += [
            Row(name, place, str(values.attrs["units"]), values.attrs.get("filter", UNFILTERED), numbers, limit)
            for place, numbers, limit in _places(values, limits(assessment.assessed, name))
        ]
    for direction in assessment.points["direction"].to_numpy():
        rows += _acceleration_rows(assessment, str(direction))
    return rows


def _acceleration_rows(assessment: Assessment, direction: str) -> list[Row]:
    """One direction at all points; a band pass takes the quasi-static value away, so that is the unfiltered signal's."""
    values, unfiltered = (
        points["acceleration"].sel(direction=direction, drop=True)
        for points in (assessment.points, assessment.unfiltered)
    )
    filters = values.coords["filter"].to_numpy() if "filter" in values.coords else None
    rows = []
    for k, ((place, numbers, limit), (_, before, _)) in enumerate(
        zip(_places(values, {}), _places(unfiltered, {}), strict=True)
    ):
        done = UNFILTERED if filters is None else str(filters[k])
        numbers = numbers | {"quasi_static": before["quasi_static"]}
        rows.append(Row(f"{direction}_acceleration", place, str(values.attrs["units"]), done, numbers, limit))
    return rows


def limits(assessed: xr.Dataset, name: str) -> dict[str, float]:
    """Limit of a quantity by wheel or wheelset; nothing where it has none.

    Of Y/Q the lower one of Nadal's and EN 14363's 0.8.
    """
    if name == "guiding_force_sum":
        return {str(w): float(v) for w, v in zip(assessed["wheelset"], assessed[f"{name}_limit"], strict=True)}
    if name == "derailment_quotient":
        lowest = float(np.fmin(assessed["nadal_limit"], QUOTIENT_LIMIT))
        return {str(w): lowest for w in assessed["wheel"].to_numpy()}
    return {}


def _places(values: xr.DataArray, limit: dict[str, float]) -> list[tuple[str, dict[str, float], float]]:
    """Place, statistics and limit of a quantity over time and one other dimension."""
    numbers = statistics(values).to_numpy()
    (dim,) = (d for d in values.dims if d != "time")
    names = [str(name) for name in values[dim].to_numpy()]
    return [
        (name, dict(zip(STATISTICS, map(float, row), strict=True)), limit.get(name, math.nan))
        for name, row in zip(names, numbers, strict=True)
    ]
