"""Wheel-rail forces and running safety (EN 14363) of a run: reported quantities, CSV rows, sections of the report.

run -> assessment -> [running_safety] -> running_safety.csv, part of summary.json, tables and figures
"""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr

from rollerrig.analysis.assessment import Assessment, Row
from rollerrig.analysis.wheel_rail_forces import QUOTIENT_LIMIT, STATISTICS, unfiltered
from rollerrig.common.formatting import number
from rollerrig.plot.wheel_rail_forces import accelerations_along, quotient, track_shifting, wear, wheel_forces
from rollerrig.results.summary import resolved
from rollerrig.study.quantities import Quantities, Quantity
from rollerrig.study.report import Picture, Section, Table, Text

SHOWN = Quantities("running_safety")

SIGNS = (
    "Forces are those of the wheel on the rail or roller: Y outwards, Q downwards, ΣY of a wheelset to the left. Each quantity "
    "is shown where its outer percentiles are largest; running_safety.csv has all wheels, wheelsets and points."
)


QUASI_STATIC = (
    "Quasi-static values are medians in sections of constant curvature, cant and speed; a vehicle is in a section while all its "
    "wheelsets are. Test zones are those of EN 14363 by the radius."
)


def csv_rows(rows: Sequence[Row]) -> list[list[object]]:
    """running_safety.csv, header first."""
    head, end = ("quantity", "place", "section", "unit", "filter"), ("limit", "part_of_limit")
    lines = ([*(getattr(row, n) for n in head), *row.statistics.values(), row.limit, row.part_of_limit] for row in rows)
    return [[*head, *STATISTICS, *end], *lines]


def numbers(assessment: Assessment, rows: Sequence[Row]) -> dict[str, Any]:
    """The numbers under the keys of QUANTITIES."""
    found: dict[str, dict[str, dict[str, Any]]] = {}
    for row in rows:
        general = {"unit": row.unit, "filter": row.filter, "limit": row.limit, "sections": {}}
        place = found.setdefault(row.quantity, {}).setdefault(row.place, general)
        place["sections"][row.section] = {**row.statistics, "part_of_limit": row.part_of_limit}
    forces = assessment.forces
    distance = forces["distance"].to_numpy()
    return {
        "running_safety": found,
        "running_safety_notes": list(assessment.notes),
        "nadal_limit": float(forces["nadal_limit"]),
        "flange_angle_deg": math.degrees(forces.attrs["flange_angle_rad"]),
        "distance_m": float(distance[-1]) if len(distance) else None,
        "weighted_acceleration": _weighted(assessment),
    }


LARGEST_OF_WHEELS = {
    "wheel_load": ("wheel_load_least_n", "smallest"),
    "guiding_force": ("guiding_force_largest_n", "largest"),
    "derailment_quotient": ("derailment_quotient_largest", "largest"),
}
"""Quantity -> key of a wheel's number in the summary, and which extreme of the whole run it is."""


def wheel_numbers(assessment: Assessment) -> dict[str, dict[str, float | None]]:
    """Wheel -> extremes of its filtered forces, by the keys of LARGEST_OF_WHEELS; None where they cannot be filtered."""
    found: dict[str, dict[str, float | None]] = {}
    for name, (key, which) in LARGEST_OF_WHEELS.items():
        values = assessment.assessed[name]
        for wheel in map(str, values["wheel"].to_numpy()):
            one = values.sel(wheel=wheel).to_numpy()
            known = one[np.isfinite(one)] if "filter" in values.attrs else one[:0]
            extreme = (known.min() if which == "smallest" else np.abs(known).max()) if known.size else None
            number = None if extreme is None else float(resolved(extreme, str(values.attrs["units"])))
            found.setdefault(wheel, {})[key] = number
    return found


def _weighted(assessment: Assessment) -> dict[str, dict[str, float]] | None:
    """Weighted values of points in the car body; frames carry no passengers."""
    if assessment.weighted is None:
        return None
    passengers = assessment.weighted[~assessment.points["on_wheelsets"].to_numpy()]
    directions, points = (passengers[name].to_numpy().tolist() for name in ("direction", "point"))
    return dict(
        zip(points, (dict(zip(directions, v, strict=True)) for v in passengers.to_numpy().tolist()), strict=True)
    )


def sections(assessment: Assessment, rows: Sequence[Row], along: xr.DataArray) -> list[Section]:
    """Sections of the report: the most critical place of each quantity, and the quantities along time or distance."""
    notes = [Text(note) for note in (*assessment.notes, *vibrations(assessment))]
    by_section = {row.section: [other for other in rows if other.section == row.section] for row in rows}
    tables = [_most_critical(some, name if len(by_section) > 1 else "") for name, some in by_section.items()]
    texts = [Text(SIGNS), Text(QUASI_STATIC), *notes]
    found = [Section("Wheel-rail forces and running safety", [*tables, *texts])]
    if along.sizes["time"] < 2:
        return found
    forces = assessment.assessed
    angle = math.degrees(forces.attrs["flange_angle_rad"])
    nadal = f"Nadal, δ = {angle:.1f}°, μ = {forces.attrs['friction']:g}"
    limits = {nadal: float(forces["nadal_limit"]), "EN 14363": QUOTIENT_LIMIT}
    drawings = [
        ("Wheel forces", wheel_forces(forces, along), "Wheel loads Q, and guiding forces Y on the rails or rollers."),
        ("Y/Q", quotient(forces, along, limits), "Guiding force over wheel load, with its limits."),
        ("Sum of guiding forces", track_shifting(forces, along), "Lateral force of each wheelset on the track."),
        ("Wear number", wear(forces, along), "Work of the creep forces per metre of distance, all patches of a wheel."),
    ]
    framed = assessment.points["on_wheelsets"].to_numpy()
    for title, kept in (("Accelerations of the car body", ~framed), ("Accelerations of the frames", framed)):
        if kept.any():
            figure = accelerations_along(assessment.points.isel(point=kept), along)
            drawings.append((title, figure, "At the centre of mass, and above the suspension."))
    for title, figure, text in drawings:
        found.append(Section(title, [Picture(title.lower().replace("/", "_over_").replace(" ", "_"), figure, text)]))
    return found


VIBRATING = 0.1
"""Share of the static wheel load: the report speaks of a larger r.m.s. of what the filter takes away."""


def vibrations(assessment: Assessment) -> list[str]:
    """A sentence on what the filter takes away from the wheel loads, where that is much; else nothing.

    A wheelset on the springs of its contacts vibrates at 100 to 300 Hz, hardly damped on a rigid rail or roller. Jumps of the
    force, as where Hertz patches come and go, and short waves excite it.
    """
    assessed, raw = assessment.assessed["wheel_load"], unfiltered(assessment.forces)["wheel_load"]
    if "filter" not in assessed.attrs:
        return []
    part = ((raw.std("time") ** 2 - assessed.std("time") ** 2).clip(min=0.0) ** 0.5) / assessment.forces[
        "static_wheel_load"
    ]
    if not bool((part > VIBRATING).any()):
        return []
    wheel = str(part["wheel"].to_numpy()[int(part.to_numpy().argmax())])
    unloaded = ", until wheels are unloaded for moments" if float(raw.min()) <= 0.0 else ""
    return [
        f"Above the filter the wheel loads vibrate by up to {number(100 * float(part.max()), 2)} % of the static load (r.m.s., "
        f"{wheel.replace('_', ' ')}){unloaded}: wheelsets on the springs of their contacts, which nothing damps on rigid rails "
        "or rollers, struck by irregularities and by jumps between contact patches. The filtered forces are free of it."
    ]


def _most_critical(rows: Sequence[Row], caption: str = "") -> Table:
    """The place with the largest outer percentile, of each quantity and filter."""
    lines = []
    for key in dict.fromkeys((row.quantity, row.filter) for row in rows):
        row = max((one for one in rows if (one.quantity, one.filter) == key), key=_outer)
        quantity = SHOWN[row.quantity]
        statistics = ("quasi_static", "percentile_0_15", "percentile_99_85", "rms")
        cells = [quantity.cell(value) for value in (*(row.statistics[name] for name in statistics), row.limit)]
        part = Quantity("", "", digits=3).cell(100.0 * row.part_of_limit)
        lines.append([quantity.heading, row.filter, row.place.replace("_", " "), *cells, part])
    header = ("", "filter", "at", "quasi-static", "0.15 %", "99.85 %", "r.m.s.", "limit", "of it [%]")
    return Table(header, lines, caption)


def _outer(row: Row) -> float:
    """Largest magnitude of the two outer percentiles, of unloading its upper one; below all others if there is none."""
    low, high = (row.statistics[name] for name in ("percentile_0_15", "percentile_99_85"))
    values = [high] if row.quantity == "wheel_unloading" else [abs(low), abs(high)]
    return max((v for v in values if math.isfinite(v)), default=-math.inf)
