"""One simulation: every signal, the numbers, tables and a report.

Case -> [RunStudy] -> run, wheel-rail forces and running safety (EN 14363)
    -> run.nc, running_safety.csv, summary.json, report.html, view.html
"""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr

from rollerrig.analysis.assessment import Assessment, Row, assess, table
from rollerrig.analysis.hunting import LateralRest, lateral_rest
from rollerrig.analysis.wheel_rail_forces import QUOTIENT_LIMIT, STATISTICS, curved, irregular, unfiltered
from rollerrig.cases import as_case
from rollerrig.common.arrays import Array
from rollerrig.common.formatting import number
from rollerrig.config import Case
from rollerrig.config.schema.faults import fault_text
from rollerrig.plot import wheel_rail_forces as figures
from rollerrig.plot.run import energy_over_time, motion_over_time, sliding_over_time
from rollerrig.results import summarise
from rollerrig.results.summary import resolved
from rollerrig.simulation.run import simulate
from rollerrig.study.frame import Outcome, Study
from rollerrig.study.jobs import Done, Progress, Round, job
from rollerrig.study.options import command
from rollerrig.study.quantities import Numbers, Quantities, Quantity
from rollerrig.study.report import VIEW, Block, Picture, Section, Table, Text

SAFETY = Quantities("running_safety")

EXPLAINED = (
    "Forces are those of the wheel on the rail or roller: Y outwards, Q downwards, ΣY of a wheelset to the left. Each quantity "
    "is shown where its outer percentiles are largest; running_safety.csv has all wheels, wheelsets and points.",
    "Quasi-static values are medians in sections of constant curvature, cant and speed; a vehicle is in a section while all its "
    "wheelsets are. Test zones are those of EN 14363 by the radius.",
)


def safety_rows(rows: Sequence[Row]) -> list[list[object]]:
    """running_safety.csv, header first."""
    head, end = ("quantity", "place", "section", "unit", "filter"), ("limit", "part_of_limit")
    lines = ([*(getattr(row, n) for n in head), *row.statistics.values(), row.limit, row.part_of_limit] for row in rows)
    return [[*head, *STATISTICS, *end], *lines]


def safety_numbers(assessment: Assessment, rows: Sequence[Row]) -> dict[str, Any]:
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
    }


LARGEST_OF_WHEELS: dict[str, tuple[str, Callable[[Array], float]]] = {
    "wheel_load": ("wheel_load_least_n", np.min),
    "guiding_force": ("guiding_force_largest_n", lambda force: np.abs(force).max()),
    "derailment_quotient": ("derailment_quotient_largest", lambda quotient: np.abs(quotient).max()),
}
"""Quantity -> key of a wheel's number in the summary, and which extreme of the whole run it is."""


def wheel_numbers(assessment: Assessment) -> dict[str, dict[str, float | None]]:
    """Wheel -> extremes of its filtered forces, by the keys of LARGEST_OF_WHEELS; None where they cannot be filtered."""
    found: dict[str, dict[str, float | None]] = {}
    for name, (key, extreme) in LARGEST_OF_WHEELS.items():
        values = assessment.assessed[name]
        for wheel in map(str, values["wheel"].to_numpy()):
            one = values.sel(wheel=wheel).to_numpy()
            known = one[np.isfinite(one)] if "filter" in values.attrs else one[:0]
            number = float(resolved(extreme(known), str(values.attrs["units"]))) if known.size else None
            found.setdefault(wheel, {})[key] = number
    return found


def safety_sections(assessment: Assessment, rows: Sequence[Row], along: xr.DataArray) -> list[Section]:
    """Sections of the report: the most critical place of each quantity, and the quantities along time or distance."""
    texts = [Text(text) for text in (*EXPLAINED, *assessment.notes, *vibrations(assessment))]
    by_section = {row.section: [other for other in rows if other.section == row.section] for row in rows}
    tables = [_most_critical(some, name if len(by_section) > 1 else "") for name, some in by_section.items()]
    found = [Section("Wheel-rail forces and running safety", [*tables, *texts])]
    if along.sizes["time"] < 2:
        return found
    forces = assessment.assessed
    angle = math.degrees(forces.attrs["flange_angle_rad"])
    nadal = f"Nadal, δ = {angle:.1f}°, μ = {forces.attrs['friction']:g}"
    limits = {nadal: float(forces["nadal_limit"]), "EN 14363": QUOTIENT_LIMIT}
    drawn = {
        "Wheel forces": figures.wheel_forces_over_time(forces, along),
        "Y/Q": figures.quotient(forces, along, limits),
        "Sum of guiding forces": figures.track_shifting(forces, along),
        "Wear number": figures.wear(forces, along),
    }
    framed = assessment.points["on_wheelsets"].to_numpy()
    for title, kept in (("Accelerations of the car body", ~framed), ("Accelerations of the frames", framed)):
        if kept.any():
            drawn[title] = figures.accelerations_along(assessment.points.isel(point=kept), along)
    for title, figure in drawn.items():
        name = title.lower().replace("/", "_over_").replace(" ", "_")
        caption = FORCES.get(title, "At the centre of mass, and above the suspension.")
        found.append(Section(title, [Picture(name, figure, caption)]))
    return found


FORCES = {  # section -> caption of its figure
    "Wheel forces": "Wheel loads Q, and guiding forces Y on the rails or rollers.",
    "Y/Q": "Guiding force over wheel load, with its limits.",
    "Sum of guiding forces": "Lateral force of each wheelset on the track.",
    "Wear number": "Work of the creep forces per metre of distance, all patches of a wheel.",
}

VIBRATING = 0.1  # share of the static wheel load: the report speaks of a larger r.m.s. of what the filter takes away


def vibrations(assessment: Assessment) -> list[str]:
    """A sentence on what the filter takes away from the wheel loads, where that is much; else nothing.

    A wheelset on the springs of its contacts vibrates at 100 to 300 Hz, hardly damped on a rigid rail or roller. Jumps of the
    force, as where Hertz patches come and go, and short waves excite it.
    """
    assessed, raw = assessment.assessed["wheel_load"], unfiltered(assessment.forces)["wheel_load"]
    if "filter" not in assessed.attrs:
        return []
    vibration = (raw.std("time") ** 2 - assessed.std("time") ** 2).clip(min=0.0) ** 0.5
    part = vibration / assessment.forces["static_wheel_load"]
    if not bool((part > VIBRATING).any()):
        return []
    unloaded = ", until wheels are unloaded for moments" if float(raw.min()) <= 0.0 else ""
    return [
        f"Above the filter the wheel loads vibrate by up to {number(100 * float(part.max()), 2)} % of the static load (r.m.s., "
        f"{_words(part.idxmax().item())}){unloaded}: wheelsets on the springs of their contacts, which nothing damps on rigid "
        "rails or rollers, struck by irregularities and by jumps between patches. The filtered forces are free of it."
    ]


def _words(name: object) -> str:
    return str(name).replace("_", " ")


def _most_critical(rows: Sequence[Row], caption: str = "") -> Table:
    """The place with the largest outer percentile, of each quantity and filter."""
    lines = []
    for key in dict.fromkeys((row.quantity, row.filter) for row in rows):
        row = max((one for one in rows if (one.quantity, one.filter) == key), key=_outer)
        quantity = SAFETY[row.quantity]
        cells = [quantity.cell(value) for value in (*(row.statistics[name] for name in SHOWN), row.limit)]
        lines.append([quantity.heading, row.filter, _words(row.place), *cells, number(100.0 * row.part_of_limit, 3)])
    return Table(("", "filter", "at", *SHOWN.values(), "limit", "of it [%]"), lines, caption)


SHOWN = {"quasi_static": "quasi-static", "percentile_0_15": "0.15 %", "percentile_99_85": "99.85 %", "rms": "r.m.s."}
"""Statistics in the report -> heading."""


def _outer(row: Row) -> float:
    """Largest magnitude of the two outer percentiles, of unloading its upper one; below all others if there is none."""
    low, high = (row.statistics[name] for name in ("percentile_0_15", "percentile_99_85"))
    values = [high] if row.quantity == "wheel_unloading" else [abs(low), abs(high)]
    return max((v for v in values if math.isfinite(v)), default=-math.inf)


_LIMITED = {  # quantities with a limit
    "derailment_quotient": "Y/Q",
    "guiding_force_sum": "ΣY",
    "guiding_force_sum_rms": "the instability criterion (r.m.s. of ΣY over 100 m)",
}


def rest_numbers(rest: LateralRest) -> dict[str, Any]:
    """Names and values as in summary.json."""
    final = rest.final
    motion = {"amplitude_mm": 1e3 * final.amplitude, "frequency_hz": final.frequency, "growth_rate_per_s": final.rate}
    return {"body": rest.body, **motion, "decision": rest.decision}


def answer(numbers: Numbers, rest: LateralRest | None, rows: Sequence[Row]) -> list[str]:
    """The findings, the one that the run was made for first."""
    energy = numbers["energy_turned_over_j"]
    speeds = (number(numbers[f"speed_{end}_kmh"]) for end in ("start", "end"))
    return [
        *([] if rest is None else [_rest(rest)]),
        *_safety(rows),
        f"{numbers['case']}: {numbers['stopped_at_s']:g} s computed. {numbers['status_message']}",
        f"Speed at the start and at the end {' and '.join(speeds)} km/h. Energy balance closed to "
        f"{number(numbers['energy_relative_residual'], 2)} of the {number(energy and energy / 1e3)} kJ turned over.",
        *(f"Warning: {line}." for line in numbers["warnings"].splitlines()),
    ]


DECISIONS = {"persists": "It hunts", "open": "Not decided whether it hunts", "decays": "The motion decays"}


def _rest(rest: LateralRest) -> str:
    final, largest = rest.final, number(1e3 * rest.largest, 2)
    text = f"{DECISIONS[rest.decision]}: {_words(rest.body)} moved sideways by up to {largest} mm"
    if final.amplitude == 0.0:
        return f"{text}, and no longer does so in the last third of the run."
    change = f", which changes by {100.0 * final.rate:+.2g} %/s" if math.isfinite(final.rate) else ""
    longer = " A longer run (time.duration) tells." if rest.decision == "open" else ""
    motion = f"±{number(1e3 * final.amplitude, 2)} mm at {number(final.frequency, 2)} Hz"
    return f"{text}, in the last third of the run by {motion}{change}.{longer}"


def _safety(rows: Sequence[Row]) -> Iterator[str]:
    """The quantities with a limit, each where it comes nearest to it."""
    known = sorted((row for row in rows if math.isfinite(row.part_of_limit)), key=lambda row: row.part_of_limit)
    nearest = {row.quantity: row for row in known if row.quantity in _LIMITED}
    if nearest:
        limited = {name: nearest[key] for key, name in _LIMITED.items() if key in nearest}
        parts = [
            f"{n} reaches {number(100.0 * one.part_of_limit, 2)} % ({_words(one.place)})" for n, one in limited.items()
        ]
        beyond = ", which it exceeds" if any(row.part_of_limit > 1.0 for row in nearest.values()) else ""
        yield f"Running safety: {', '.join(parts)} of the limit{beyond}."


QUANTITIES = Quantities(
    "run", (Quantity(f"running_safety.*.*.sections.*.{name}", meaning) for name, meaning in STATISTICS.items())
)
FIRST = (
    "vertical_force_start_n", "wheel_load_least_n", "guiding_force_largest_n", "derailment_quotient_largest",
    "longitudinal_sliding_largest_mps", "without_contact_s",
)  # fmt: skip
"""Numbers of the wheels that a reader sees first; the others stand with how they were computed."""

MORE = tuple(q.name for q in QUANTITIES.below("wheels.*") if q.name not in FIRST)

CONTACT = QUANTITIES.below("contact")


SOLVER = {  # counts of the integrator as the report names them, where the key says too little
    "derivative_calls": "evaluations of the right-hand side",
    "jacobian_calls": "evaluations of the Jacobian",
    "smallest_step": "smallest step [s]",
    "largest_step": "largest step [s]",
}


DRAWINGS = {  # section of the report -> its figure over time, and caption
    "Motion": (
        motion_over_time,
        "Lateral displacement and yaw of the vehicle's bodies, and the running speed where it changes.",
    ),
    "Sliding": (sliding_over_time, "Longitudinal creep force and sliding, wheel less roller; contact on the wheel S."),
    "Energy": (energy_over_time, "Work put in = change of stored energy + heat + residual."),
}


@dataclass(frozen=True)
class Results:
    """A run, its wheel-rail forces and accelerations assessed, and what is left of its sideways motion."""

    run: xr.Dataset
    assessment: Assessment
    rows: Sequence[Row]
    rest: LateralRest | None = None


@dataclass(frozen=True)
class RunStudy(Study[Results]):
    """One simulation."""

    case: Case

    command = "run"
    heading = "{case.name}: {case.description}"
    quantities = QUANTITIES
    writes = ("run.nc", "running_safety.csv", VIEW)
    resumable = False

    def rounds(self, done: Done) -> Iterator[Round]:
        yield {self.case.name: job(simulate, self.case)}

    def collect(self, done: Done) -> Results | None:
        if self.case.name not in done:
            return None
        run = done[self.case.name]
        assessment = assess(run)
        return Results(run, assessment, table(assessment), lateral_rest(run))

    def statuses(self, results: Results) -> Sequence[str]:
        return [results.run.attrs["status"]]

    def numbers(self, results: Results) -> dict[str, Any]:
        found = summarise(results.run)
        for wheel, numbers in wheel_numbers(results.assessment).items():
            found["wheels"][wheel] |= numbers
        found["lateral_rest"] = None if results.rest is None else rest_numbers(results.rest)
        return {**found, **safety_numbers(results.assessment, results.rows)}

    def summary(self, results: Results, numbers: Numbers) -> list[str]:
        faults = [f"Fault: {fault_text(fault)}." for fault in self.case.fault if fault.kind != "none"]
        return [*faults, *answer(numbers, results.rest, results.rows)]

    def shown(self, results: Results) -> Mapping[str, xr.Dataset]:
        return {self.case.name: results.run}

    def files(self, results: Results, numbers: Numbers) -> Mapping[str, Any]:
        return {"run.nc": results.run, "running_safety.csv": safety_rows(results.rows)}

    def sections(self, results: Results, numbers: Numbers) -> list[Section]:
        run, along = results.run, distance_or_time(results.run)
        bodies = QUANTITIES.table(numbers["bodies"], "bodies.*", head="body")
        wheels, more = (QUANTITIES.table(numbers["wheels"], names, head="wheel") for names in (FIRST, MORE))
        sections = [
            Section("Numbers", [bodies, wheels]),
            *safety_sections(results.assessment, results.rows, along),
        ]
        if run.sizes["time"] > 1:
            if along.name == "distance":
                caption = "Alignment and irregularities of the track, and how the wheelsets follow them."
                sections.insert(1, Section("Track", [Picture("track", figures.line_and_response(run, along), caption)]))
            drawn = {title: Picture(title.lower(), draw(run), text) for title, (draw, text) in DRAWINGS.items()}
            sections += [Section(title, [picture]) for title, picture in drawn.items()]
        counts, events = numbers["solver"].items(), numbers["contact"]
        solver = [(SOLVER.get(name, name.replace("_", " ")), "–" if v is None else v) for name, v in counts]
        contact = [(q.name.replace("_", " "), events[q.name], q.meaning) for q in CONTACT if q.name in events]
        tables: list[Block] = [
            more,
            Table(("count", "value"), solver, "integration"),
            Table(("count", "value", "meaning"), contact, "contacts, counted over accepted steps and wheels"),
        ]
        return [*sections, Section("All numbers of the wheels, and how they were computed", tables, folded=True)]


def distance_or_time(run: xr.Dataset) -> xr.DataArray:
    """What forces are drawn over: the distance where curves, cant or irregularities lie along it, else time."""
    name = "distance" if curved(run) or irregular(run) else "time"
    return run[name].assign_attrs(long_name=name)


@command
def run(case: Case | str, *, progress: Progress | None = None) -> Outcome[Results]:
    """Simulate one case: run.nc (every signal), summary.json, running_safety.csv, report.html, view.html (in motion).

    Args:
        case: case: a name of the catalogue or a TOML file.
        progress: called with the fraction done and a short text.

    Example:
        >>> import rollerrig as rr
        >>> rr.run(rr.load_case("wheelset_rollers").with_changes({"time.duration": "0.1 s"})).statuses
        ['ok']
    """
    return RunStudy(as_case(case)).outcome(progress=progress)
