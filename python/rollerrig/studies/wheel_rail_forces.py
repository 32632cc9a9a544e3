"""What engineers read off a run, as files: a table of numbers, keys of summary.json, sections of the report.

run -> assessment -> [readings study] -> readings.csv, summary.json, tables and figures
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import xarray as xr

from rollerrig.analysis.assessment import Assessment, Row
from rollerrig.analysis.wheel_rail_forces import QUOTIENT_LIMIT, STATISTICS
from rollerrig.plot import figure_bytes
from rollerrig.plot.wheel_rail_forces import accelerations_along, quotient, track_shifting, wear, wheel_forces
from rollerrig.report import Figure, Section, Table, Text
from rollerrig.studies.output import finite

READINGS_KEYS = {
    "readings": "what engineers read off the run: quantity, then wheel, wheelset or point, then the numbers below",
    "readings.*.*.unit": "unit of the numbers; 1: none",
    "readings.*.*.filter": "what was done to the signal before: low or band pass, mean over 2 m of way; 'none': nothing",
    **{f"readings.*.*.{name}": meaning for name, meaning in STATISTICS.items()},
    "readings.*.*.limit": "limit of the magnitude: Prud'homme's of ΣY, the lower one of Nadal's and 0.8 of Y/Q; null: none",
    "readings.*.*.part_of_limit": "the larger of the two percentiles' magnitudes over the limit [-]; null: no limit",
    "readings_notes": "why something is not filtered, a sentence each",
    "nadal_limit": "(tan δ - μ) / (1 + μ tan δ) of the wheel profile's steepest flange angle and the friction [-]; null: "
    "friction alone holds the wheel",
    "flange_angle_deg": "steepest slope of the wheel profile towards the flange [°]",
    "distance_m": "way run, on a rig that of the rollers' surface [m]; null: no output time was reached",
    "weighted_acceleration": "per point of the car body, r.m.s. weighted after EN 12299 [m/s^2]: lateral with W_d, vertical "
    "with W_b; null: the run cannot be filtered",
}
"""Key of summary.json -> meaning and unit; `*` stands for a name."""

TITLES = {
    "guiding_force": ("guiding force Y", "kN", 1e-3),
    "wheel_load": ("wheel load Q", "kN", 1e-3),
    "derailment_quotient": ("Y/Q", "–", 1.0),
    "wheel_unloading": ("wheel unloading (Q0 − Q)/Q0", "–", 1.0),
    "guiding_force_sum": ("sum of guiding forces ΣY", "kN", 1e-3),
    "wear_number": ("wear number Tγ", "N", 1.0),
    "lateral_acceleration": ("lateral acceleration", "m/s²", 1.0),
    "vertical_acceleration": ("vertical acceleration", "m/s²", 1.0),
}
"""Quantity -> its words, and unit and factor in which the report shows it."""

SIGNS = (
    "Forces are those of the wheel on the rail or roller: Y outwards, Q downwards, ΣY of a wheelset to the left. The worst "
    "place of each quantity is shown, by its outer percentiles; readings.csv has all of them."
)


def readings_rows(rows: Sequence[Row]) -> list[list[object]]:
    """readings.csv, header first."""
    header: list[object] = ["quantity", "place", "unit", "filter", *STATISTICS, "limit", "part_of_limit"]
    body: list[list[object]] = [
        [row.quantity, row.place, row.unit, row.filter, *row.statistics.values(), row.limit, row.part_of_limit]
        for row in rows
    ]
    return [header, *body]


def readings_summary(assessment: Assessment, rows: Sequence[Row]) -> dict[str, Any]:
    """The numbers under the keys of READINGS_KEYS."""
    numbers: dict[str, dict[str, dict[str, object]]] = {}
    for row in rows:
        numbers.setdefault(row.quantity, {})[row.place] = {
            "unit": row.unit,
            "filter": row.filter,
            **{name: finite(value) for name, value in row.statistics.items()},
            "limit": finite(row.limit),
            "part_of_limit": finite(row.part_of_limit),
        }
    read = assessment.readings
    way = read["distance"].to_numpy()
    return {
        "readings": numbers,
        "readings_notes": list(assessment.notes),
        "nadal_limit": finite(float(read["nadal_limit"])),
        "flange_angle_deg": math.degrees(read.attrs["flange_angle_rad"]),
        "distance_m": float(way[-1]) if len(way) else None,
        "weighted_acceleration": _weighted(assessment),
    }


def _weighted(assessment: Assessment) -> dict[str, dict[str, float]] | None:
    """Of points in the car body; frames carry no passengers."""
    if assessment.weighted is None:
        return None
    passengers = assessment.weighted[~assessment.points["on_wheelsets"].to_numpy()]
    directions = [str(d) for d in passengers["direction"].to_numpy()]
    return {
        str(point): dict(zip(directions, map(float, values), strict=True))
        for point, values in zip(passengers["point"].to_numpy(), passengers.to_numpy(), strict=True)
    }


def readings_sections(assessment: Assessment, rows: Sequence[Row], along: xr.DataArray) -> list[Section]:
    """Sections of the report: the worst of each quantity, and how the quantities went.

    Args:
        assessment: what `assess` returns.
        rows: its table.
        along: time or distance to draw over; with fewer than two samples nothing is drawn.
    """
    notes = [Text(note) for note in assessment.notes]
    sections = [Section("Readings", [_worst(rows), Text(SIGNS), *notes])]
    if along.sizes["time"] < 2:
        return sections
    read = assessment.assessed
    limits = {_nadal_words(read): float(read["nadal_limit"]), "EN 14363": QUOTIENT_LIMIT}
    drawings = [
        ("Wheel forces", wheel_forces(read, along), "Wheel loads Q, and guiding forces Y on the rails or rollers."),
        ("Y/Q", quotient(read, along, limits), "Guiding force over wheel load, and what the flange may bear."),
        ("Sum of guiding forces", track_shifting(read, along), "What each wheelset shifts the track with."),
        ("Wear number", wear(read, along), "Heat of the creep forces per metre of way, all patches of a wheel."),
    ]
    framed = assessment.points["on_wheelsets"].to_numpy()
    for title, kept in (("Accelerations of the car body", ~framed), ("Accelerations of the frames", framed)):
        if kept.any():
            figure = accelerations_along(assessment.points.isel(point=kept), along)
            drawings.append((title, figure, "At the centre of mass, and over what carries the body."))
    sections += [Section(title, [Figure(figure_bytes(figure, "png"), text)]) for title, figure, text in drawings]
    return sections


def _nadal_words(read: xr.Dataset) -> str:
    return f"Nadal, δ = {math.degrees(read.attrs['flange_angle_rad']):.1f}°, μ = {read.attrs['friction']:g}"


def _worst(rows: Sequence[Row]) -> Table:
    """The place with the largest outer percentile, of each quantity and filter."""
    worst: dict[tuple[str, str], Row] = {}
    for row in rows:
        key = (row.quantity, row.filter)
        if key not in worst or _outer(row) > _outer(worst[key]):
            worst[key] = row
    header = ("", "filter", "worst place", "unit", "quasi-static", "0.15 %", "99.85 %", "r.m.s.", "limit", "of it [%]")
    lines = []
    for row in worst.values():
        title, unit, factor = TITLES[row.quantity]
        shown = ("quasi_static", "percentile_0_15", "percentile_99_85", "rms")
        numbers = [_cell(factor * row.statistics[name]) for name in shown]
        limit = [_cell(factor * row.limit), _cell(100 * row.part_of_limit)]
        lines.append([title, row.filter, row.place.replace("_", " "), unit, *numbers, *limit])
    return Table(header, lines)


def _outer(row: Row) -> float:
    """Largest magnitude of the two outer percentiles, of unloading its upper one; below all others if there is none."""
    low, high = (row.statistics[name] for name in ("percentile_0_15", "percentile_99_85"))
    values = [high] if row.quantity == "wheel_unloading" else [abs(low), abs(high)]
    return max((v for v in values if math.isfinite(v)), default=-math.inf)


def _cell(value: float) -> object:
    return float(f"{value:.3g}") if math.isfinite(value) else "–"
