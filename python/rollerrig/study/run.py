"""One simulation: every signal, the numbers, tables and a report.

Case -> [RunStudy] -> run.nc, motion.csv, wheels.csv, running_safety.csv, summary.json, report.html, view.html
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import xarray as xr

from rollerrig.analysis.assessment import Assessment, Row, assess, table
from rollerrig.analysis.hunting import LateralRest, lateral_rest
from rollerrig.analysis.wheel_rail_forces import STATISTICS, curved, irregular
from rollerrig.common.formatting import number
from rollerrig.config import Case
from rollerrig.config.schema.faults import fault_text
from rollerrig.plot.run import energy_over_time, motion_over_time, sliding_over_time
from rollerrig.plot.wheel_rail_forces import line_and_response
from rollerrig.results import motion_table, summarise, wheel_table
from rollerrig.simulation.run import simulate
from rollerrig.study import running_safety
from rollerrig.study.frame import Study
from rollerrig.study.jobs import Done, Round, job
from rollerrig.study.quantities import Numbers, Quantities, Quantity
from rollerrig.study.report import VIEW, Block, Picture, Section, Table

_LIMITED = {
    "derailment_quotient": "Y/Q",
    "guiding_force_sum": "ΣY",
    "guiding_force_sum_rms": "the instability criterion (r.m.s. of ΣY over 100 m)",
}
"""Quantities with a limit."""


def rest_numbers(rest: LateralRest) -> dict[str, Any]:
    """Names and values as in summary.json."""
    final = rest.final
    motion = {"amplitude_mm": 1e3 * final.amplitude, "frequency_hz": final.frequency, "growth_rate_per_s": final.rate}
    return {"body": rest.body, **motion, "decision": rest.decision}


def answer(numbers: Numbers, rest: LateralRest | None, rows: Sequence[Row]) -> list[str]:
    """The findings, the one that the run was made for first."""
    lines = [] if rest is None else [_rest(rest)]
    if safe := _safety(rows):
        lines.append(safe)
    lines.append(f"{numbers['case']}: {numbers['stopped_at_s']:g} s computed. {numbers['status_message']}")
    speeds = ""
    if numbers["samples"]:
        speeds = f"Speed {numbers['speed_start_kmh']:.4g} km/h at the start, {numbers['speed_end_kmh']:.4g} km/h at the end. "
    energy = numbers["energy_turned_over_j"]
    lines.append(
        f"{speeds}Energy balance closed to {number(numbers['energy_relative_residual'], 2)} of the "
        f"{number(energy and energy / 1e3)} kJ turned over."
    )
    return [*lines, *(f"Warning: {line}." for line in numbers["warnings"].splitlines())]


def _rest(rest: LateralRest) -> str:
    body, final = rest.body.replace("_", " "), rest.final
    motion = f"by ±{number(1e3 * final.amplitude, 2)} mm at {number(final.frequency, 2)} Hz"
    if rest.decision == "persists":
        return f"It hunts: in the last third of the run {body} still moves sideways {motion}."
    if rest.decision == "open":
        change = f", which changes by {100.0 * final.rate:+.2g} %/s" if math.isfinite(final.rate) else ""
        return (
            f"Not decided whether it hunts: in the last third of the run {body} still moves sideways {motion}{change}; a "
            "longer run (time.duration) tells."
        )
    was = f"by up to {number(1e3 * rest.largest, 2)} mm"
    if final.amplitude == 0.0:
        return f"The motion decays: {body} moved sideways {was}, and no longer does so in the last third of the run."
    return f"The motion decays: {body} moved sideways {was}, in the last third of the run {motion}, and less and less."


def _safety(rows: Sequence[Row]) -> str:
    """The quantities with a limit, each where it comes nearest to it."""
    known = [row for row in rows if row.quantity in _LIMITED and math.isfinite(row.part_of_limit)]
    nearest = {row.quantity: max((one for one in known if one.quantity == row.quantity), key=lambda one: one.part_of_limit)
               for row in known}  # fmt: skip
    if not nearest:
        return ""
    beyond = any(row.part_of_limit > 1.0 for row in nearest.values())
    parts = (
        f"{_LIMITED[name]} reaches {number(100.0 * row.part_of_limit, 2)} % ({row.place.replace('_', ' ')})"
        for name, row in nearest.items()
    )
    *others, last = parts
    listed = f"{', '.join(others)} and {last}" if others else last
    return f"Running safety: {listed} of the limit{', which it exceeds' if beyond else ''}."


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


SOLVER = {
    "derivative_calls": "evaluations of the right-hand side",
    "jacobian_calls": "evaluations of the Jacobian",
    "smallest_step": "smallest step [s]",
    "largest_step": "largest step [s]",
}
"""Counts of the integrator as the report names them, where the key says too little."""


DRAWINGS = {
    "Motion": (motion_over_time, "Lateral displacement and yaw of the vehicle's bodies, and the running speed."),
    "Sliding": (sliding_over_time, "Longitudinal creep force and sliding, wheel less roller; contact on the wheel S."),
    "Energy": (energy_over_time, "Work put in = change of stored energy + heat + residual."),
}
"""Section of the report -> its figure over time, and caption."""


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
    writes = ("run.nc", "motion.csv", "wheels.csv", "running_safety.csv", VIEW)
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
        for wheel, numbers in running_safety.wheel_numbers(results.assessment).items():
            found["wheels"][wheel] |= numbers
        found["lateral_rest"] = None if results.rest is None else rest_numbers(results.rest)
        return {**found, **running_safety.numbers(results.assessment, results.rows)}

    def summary(self, results: Results, numbers: Numbers) -> list[str]:
        faults = [f"Fault: {fault_text(fault)}." for fault in self.case.fault if fault.kind != "none"]
        return [*faults, *answer(numbers, results.rest, results.rows)]

    def shown(self, results: Results) -> Mapping[str, xr.Dataset]:
        return {self.case.name: results.run}

    def files(self, results: Results, numbers: Numbers) -> Mapping[str, Any]:
        tables = {"motion.csv": motion_table(results.run), "wheels.csv": wheel_table(results.run)}
        return {
            "run.nc": results.run,
            **{name: [names, *rows.tolist()] for name, (names, rows) in tables.items()},
            "running_safety.csv": running_safety.csv_rows(results.rows),
        }

    def sections(self, results: Results, numbers: Numbers) -> list[Section]:
        run, along = results.run, distance_or_time(results.run)
        sections = [
            Section("Numbers", [_entries("bodies", "bodies.*", numbers), _entries("wheels", FIRST, numbers)]),
            *running_safety.sections(results.assessment, results.rows, along),
        ]
        if run.sizes["time"] > 1:
            if curved(run) or irregular(run):
                caption = "Alignment and irregularities of the track, and how the wheelsets follow them."
                sections.insert(1, Section("Track", [Picture("track", line_and_response(run, along), caption)]))
            for title, (draw, text) in DRAWINGS.items():
                sections.append(Section(title, [Picture(title.lower(), draw(run), text)]))
        counts, events = numbers["solver"].items(), numbers["contact"]
        solver = [(SOLVER.get(name, name.replace("_", " ")), "–" if v is None else v) for name, v in counts]
        contact = [(q.name.replace("_", " "), events[q.name], q.meaning) for q in CONTACT if q.name in events]
        tables: list[Block] = [
            _entries("wheels", MORE, numbers),
            Table(("count", "value"), solver, "integration"),
            Table(("count", "value", "meaning"), contact, "contacts, counted over accepted steps and wheels"),
        ]
        return [*sections, Section("All numbers of the wheels, and how they were computed", tables, folded=True)]


def distance_or_time(run: xr.Dataset) -> xr.DataArray:
    """What forces are drawn over: the distance where curves, cant or irregularities lie along it, else time."""
    if curved(run) or irregular(run):
        return run["distance"].assign_attrs(long_name="distance")
    return run["time"].assign_attrs(long_name="time")


def _entries(group: str, names: Sequence[str] | str, numbers: Numbers) -> Table:
    return QUANTITIES.table(numbers[group], names, head={"bodies": "body", "wheels": "wheel"}[group])
