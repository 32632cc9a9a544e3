"""Everything the report needs, computed; Ctrl-C keeps what is done.

PaperPlan -> [jobs on a few processes, then the narrowing down] -> PaperResults
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import xarray as xr

from rollerrig.analysis import CriticalSpeedByDisturbance, LinearCriticalSpeed, hunting_run, ramp_run, stability
from rollerrig.analysis.contact_state import ContactState, contact_state
from rollerrig.analysis.critical_speed import bracket, scan_linear
from rollerrig.analysis.parallel import run_jobs
from rollerrig.analysis.traction import with_theory
from rollerrig.simulation import simulate
from rollerrig.studies.compare.critical import Causes, CriticalTable, cause_cases, critical_table, table_cases
from rollerrig.studies.paper.plan import (
    MATERIALS,
    TABLE_PARTS,
    VARIANTS,
    VEHICLE,
    PaperPlan,
    case_of,
    rig_case,
    traction_case,
)

Progress = Callable[[float, str], None]
Job = tuple[str, str, Any]

LINEAR_SHARE, FIRST_SHARE = 0.2, 0.8
"""Fractions of the whole at which the linear part and the first round of runs end, for the progress bar."""

MOST_ROUNDS = 6


@dataclass
class PaperResults:
    """What was computed; parts that Ctrl-C cut off are missing.

    Attributes:
        plan: what was asked for.
        modes: material -> variant -> Dataset of `stability`.
        barriers: material -> merge barrier -> linear critical speed on the rig [m/s], NaN if none.
        contact: material -> the wheels' contact in steady rolling on the rig.
        ramps: material -> Dataset of `ramp_run`.
        runs: material -> critical speed by disturbance on the rig, with its runs.
        vehicle_runs: the same of the whole vehicle on track.
        tables: material -> critical speeds over the rollers' radius.
        causes: material -> what takes the bogie's critical speed from that on track to that on the rig.
        traction: the traction run, all signals; None if it was cut off.
        traction_theory: the same wheels beside the closed forms.
        interrupted: whether Ctrl-C was pressed.
    """

    plan: PaperPlan
    modes: dict[str, dict[str, xr.Dataset]] = field(default_factory=dict)
    barriers: dict[str, dict[float, float]] = field(default_factory=dict)
    contact: dict[str, ContactState] = field(default_factory=dict)
    ramps: dict[str, xr.Dataset] = field(default_factory=dict)
    runs: dict[str, CriticalSpeedByDisturbance] = field(default_factory=dict)
    vehicle_runs: dict[str, CriticalSpeedByDisturbance] = field(default_factory=dict)
    tables: dict[str, CriticalTable] = field(default_factory=dict)
    causes: dict[str, Causes] = field(default_factory=dict)
    traction: xr.Dataset | None = None
    traction_theory: xr.Dataset | None = None
    interrupted: bool = False

    def linear_kmh(self, material: str, variant: str = "bogie on the rig") -> float:
        """Linear critical speed [km/h]; NaN if there is none or it was not computed."""
        modes = self.modes.get(material, {}).get(variant)
        return math.nan if modes is None else float(modes.attrs["linear_critical_speed_kmh"])

    def by_disturbance_kmh(self, material: str) -> float:
        """Critical speed by disturbance on the rig [km/h]; NaN if there is none or it was not computed."""
        found = self.runs.get(material)
        return math.nan if found is None else 3.6 * found.speed

    def vehicle_by_disturbance_kmh(self, material: str) -> float:
        """Critical speed by disturbance of the whole vehicle on track [km/h]; NaN likewise."""
        found = self.vehicle_runs.get(material)
        return math.nan if found is None else 3.6 * found.speed


def compute(plan: PaperPlan, *, processes: int = 2, progress: Progress | None = None) -> PaperResults:
    """Compute both studies.

    Args:
        plan: FULL, QUICK or one's own.
        processes: runs at a time.
        progress: called with the fraction done and a short text.
    """
    report = progress or (lambda _fraction, _text: None)
    results = PaperResults(plan)
    _do(results, _linear_jobs(plan), processes, lambda f, t: report(LINEAR_SHARE * f, t))
    if not results.interrupted:
        share = FIRST_SHARE - LINEAR_SHARE
        _do(results, _first_runs(plan), processes, lambda f, t: report(LINEAR_SHARE + share * f, t))
    for number in range(MOST_ROUNDS):
        if results.interrupted or not _narrow_down(results, processes):
            break
        if not results.interrupted:
            report(FIRST_SHARE + (1 - FIRST_SHARE) * (number + 1) / MOST_ROUNDS, "critical speed by disturbance")
    if not results.interrupted:
        report(1.0, "done")
    return results


def _linear_jobs(plan: PaperPlan) -> list[Job]:
    scan = [v / 3.6 for v in plan.linear_kmh]
    jobs: list[Job] = []
    for material in MATERIALS:
        jobs += [("modes", material, (v, case_of(v, material), plan.linear_kmh)) for v in VARIANTS]
        case = rig_case(material)
        jobs.append(("contact", material, case))
        jobs += [
            ("barrier", material, (b, case.with_changes({"contact.merging_criterion": b}), scan)) for b in plan.barriers
        ]
        jobs += [("effects", material, (on, c, scan)) for on, c in cause_cases(case).items()]
        jobs += [("radius", material, (p, c, scan)) for p, c in table_cases(case, TABLE_PARTS, plan.radii).items()]
    return jobs


def _first_runs(plan: PaperPlan) -> list[Job]:
    """All runs but those of the narrowing down, the longest first."""
    jobs: list[Job] = [("ramp", m, (rig_case(m), plan.ramps[m], plan.hunting)) for m in MATERIALS]
    jobs.append(("traction", "", traction_case(plan)))
    for kind, case in (("vehicle", lambda m: case_of(VEHICLE, m)), ("run", rig_case)):
        for material in MATERIALS:
            fastest_first = sorted(plan.runs_kmh[material], reverse=True)
            jobs += [(kind, material, (case(material), v / 3.6, plan.hunting)) for v in fastest_first]
    return jobs


def _do(results: PaperResults, jobs: list[Job], processes: int, report: Progress | None = None) -> None:
    """Jobs done and their results kept."""
    done = run_jobs(paper_job, jobs, processes=processes, progress=report, names=[_label(job) for job in jobs])
    results.interrupted = done.interrupted
    pairs = [(job, result) for job, result in zip(jobs, done.results, strict=True) if result is not None]
    _keep_linear(results, pairs)
    for (kind, material, _), result in pairs:
        if kind == "ramp":
            results.ramps[material] = result
        elif kind == "traction":
            results.traction = result
            results.traction_theory = with_theory(result, traction_case(results.plan))
    _keep_runs(results, pairs)


def _keep_linear(results: PaperResults, pairs: list[tuple[Job, Any]]) -> None:
    scans: dict[str, dict[str, dict[Any, LinearCriticalSpeed]]] = {}
    for (kind, material, argument), result in pairs:
        if kind == "modes":
            results.modes.setdefault(material, {})[argument[0]] = result
        elif kind == "contact":
            results.contact[material] = result
        elif kind in ("barrier", "effects", "radius"):
            scans.setdefault(kind, {}).setdefault(material, {})[argument[0]] = result
    for material, found in scans.get("barrier", {}).items():
        results.barriers[material] = {barrier: scan.speed_kmh / 3.6 for barrier, scan in found.items()}
    results.causes |= {material: Causes(found) for material, found in scans.get("effects", {}).items()}
    results.tables |= {material: critical_table(found, found) for material, found in scans.get("radius", {}).items()}


def _keep_runs(results: PaperResults, pairs: list[tuple[Job, Any]]) -> None:
    """Adds runs to the brackets they belong to."""
    size = results.plan.hunting.disturbance
    for kind, brackets in (("run", results.runs), ("vehicle", results.vehicle_runs)):
        for (job_kind, material, _), run in pairs:
            if job_kind == kind:
                known = brackets[material].runs if material in brackets else []
                brackets[material] = bracket([*known, run], size)


def _narrow_down(results: PaperResults, processes: int) -> bool:
    """One round of further runs within the brackets; False if none is wide enough."""
    plan = results.plan
    jobs: list[Job] = []
    for kind, brackets in (("vehicle", results.vehicle_runs), ("run", results.runs)):
        for material, found in brackets.items():
            case = rig_case(material) if kind == "run" else case_of(VEHICLE, material)
            between = found.further_speeds(plan.bracket_kmh / 3.6)
            jobs += [(kind, material, (case, v, plan.hunting)) for v in between]
    if not jobs:
        return False
    _do(results, jobs, processes)
    return True


def _label(job: Job) -> str:
    kind, material, argument = job
    if kind in ("run", "vehicle"):
        return f"{kind} at {3.6 * argument[1]:.0f} km/h, {material}"
    return f"{kind} {material}".strip()


def paper_job(job: Job, progress: Progress) -> Any:
    """One run of the study, on any process.

    Raises:
        KeyboardInterrupt: Ctrl-C came before the end.
    """
    kind, _, argument = job
    match kind:
        case "run" | "vehicle":
            return hunting_run(argument, progress)
        case "ramp":
            return ramp_run(argument, progress)
        case "modes":
            modes = stability(argument[1], argument[2], progress=progress)
            if modes.attrs["interrupted"]:
                raise KeyboardInterrupt
            return modes
        case "contact":
            return contact_state(argument)
        case "barrier" | "effects" | "radius":
            return scan_linear(argument[1:], progress)
    run = simulate(argument, progress=progress)
    if run.attrs["status"] == "interrupted":
        raise KeyboardInterrupt
    return run
