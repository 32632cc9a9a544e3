"""A run's wheel-rail forces and accelerations as a table: every quantity with its statistics, its filter and its limit.

run -> wheel-rail forces, accelerations -> [assessment] -> rows -> running_safety.csv, summary.json, report
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import xarray as xr

from rollerrig.analysis.ride import accelerations, ride, weighted_rms
from rollerrig.analysis.track_sections import WHOLE_RUN, TrackSection, track_sections
from rollerrig.analysis.wheel_rail_forces import (
    INSTABILITY_LENGTH,
    QUOTIENT_LIMIT,
    STATISTICS,
    at_output_times,
    filtered,
    statistics,
    wheel_forces,
)
from rollerrig.results.resolution import resolved

QUANTITIES = (
    "guiding_force",
    "wheel_load",
    "derailment_quotient",
    "wheel_unloading",
    "guiding_force_sum",
    "guiding_force_sum_rms",
    "wear_number",
)
"""Quantities of wheels and wheelsets, in the order of the tables."""

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
        sections: of the run, in their order.
        notes: why something is not filtered, a sentence each.
    """

    forces: xr.Dataset
    assessed: xr.Dataset
    points: xr.Dataset
    unfiltered: xr.Dataset
    weighted: xr.DataArray | None
    sections: tuple[TrackSection, ...]
    notes: tuple[str, ...]


@dataclass(frozen=True)
class Row:
    """One quantity at one place, in a section of the run or in all of it.

    Attributes:
        quantity: name of the variable; accelerations with their direction.
        place: wheel, wheelset or point.
        section: name of the section, or WHOLE_RUN where a run has several.
        unit: of the statistics and the limit.
        filter: what was done to the signal before.
        statistics: by the names of STATISTICS; NaN where none exists, as the quasi-static value of what is not constant.
        limit: of the quantity's magnitude; NaN if there is none.
    """

    quantity: str
    place: str
    section: str
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
    points, assessed, weighted = unfiltered, at_output_times(read), None
    try:
        assessed = filtered(read)
        if "guiding_force_sum_rms" not in assessed:
            notes.append(
                f"The instability criterion, an r.m.s. of ΣY over {INSTABILITY_LENGTH:g} m, is not assessed: the run has "
                f"{float(np.ptp(read['distance'].to_numpy())):.0f} m."
            )
    except ValueError as cause:
        notes.append(f"Wheel forces are not filtered: {cause}.")
    if unfiltered.sizes["point"]:
        try:
            points, weighted = ride(unfiltered), weighted_rms(unfiltered)
        except ValueError as cause:
            notes.append(f"Accelerations are not filtered: {cause}.")
    return Assessment(read, assessed, points, unfiltered, weighted, tuple(track_sections(run)), tuple(notes))


def table(assessment: Assessment) -> list[Row]:
    """All rows, section by section; of each wheels first, then wheelsets, then points of the bodies.

    A run of several sections comes first as a whole.
    """
    sections = list(assessment.sections)
    if len(sections) > 1:
        everywhere = np.ones(assessment.assessed.sizes["time"], dtype=bool)
        sections.insert(0, TrackSection(WHOLE_RUN, False, everywhere))
    return [row for section in sections for row in _rows(assessment, section)]


def _rows(assessment: Assessment, section: TrackSection) -> list[Row]:
    rows = []
    within = {"time": section.within}
    for name in (name for name in QUANTITIES if name in assessment.assessed):
        values = assessment.assessed[name]
        done = values.attrs.get("filter", UNFILTERED)
        for place, numbers, limit in _places(values.isel(within), limits(assessment.assessed, name)):
            numbers = numbers if section.constant else numbers | {"quasi_static": math.nan}
            rows.append(Row(name, place, section.name, str(values.attrs["units"]), done, numbers, limit))
    for direction in assessment.points["direction"].to_numpy():
        rows += _acceleration_rows(assessment, str(direction), section)
    return rows


def _acceleration_rows(assessment: Assessment, direction: str, section: TrackSection) -> list[Row]:
    """One direction at all points; a band pass takes the quasi-static value away, so that is the unfiltered signal's."""
    values, unfiltered = (
        points["acceleration"].sel(direction=direction, drop=True).isel(time=section.within)
        for points in (assessment.points, assessment.unfiltered)
    )
    filters = values.coords["filter"].to_numpy() if "filter" in values.coords else None
    rows = []
    for k, ((place, numbers, limit), (_, before, _)) in enumerate(
        zip(_places(values, {}), _places(unfiltered, {}), strict=True)
    ):
        done = UNFILTERED if filters is None else str(filters[k])
        numbers = numbers | {"quasi_static": before["quasi_static"] if section.constant else math.nan}
        unit = str(values.attrs["units"])
        rows.append(Row(f"{direction}_acceleration", place, section.name, unit, done, numbers, limit))
    return rows


def limits(assessed: xr.Dataset, name: str) -> dict[str, float]:
    """Limit of a quantity by wheel or wheelset; nothing where it has none.

    Of Y/Q the lower one of Nadal's and EN 14363's 0.8; of the r.m.s. of ΣY half of that of ΣY.
    """
    if name in ("guiding_force_sum", "guiding_force_sum_rms"):
        part = 0.5 if name.endswith("rms") else 1.0
        by_wheelset = zip(assessed["wheelset"].to_numpy(), assessed["guiding_force_sum_limit"].to_numpy(), strict=True)
        return {str(wheelset): part * float(limit) for wheelset, limit in by_wheelset}
    if name == "derailment_quotient":
        lowest = float(np.fmin(assessed["nadal_limit"], QUOTIENT_LIMIT))
        return {str(w): lowest for w in assessed["wheel"].to_numpy()}
    return {}


def _places(values: xr.DataArray, limit: dict[str, float]) -> list[tuple[str, dict[str, float], float]]:
    """Place, statistics and limit of a quantity over time and one other dimension."""
    numbers = resolved(statistics(values), str(values.attrs["units"]))
    (dim,) = (d for d in values.dims if d != "time")
    names = [str(name) for name in values[dim].to_numpy()]
    return [
        (name, dict(zip(STATISTICS, map(float, row), strict=True)), limit.get(name, math.nan))
        for name, row in zip(names, numbers, strict=True)
    ]
