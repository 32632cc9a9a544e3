"""Everything the report needs, computed; Ctrl-C keeps what is done.

PaperPlan -> [linear part, then jobs on a few processes, then the narrowing down] -> PaperResults
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import xarray as xr

from rollerrig.analysis import (
    HuntingRun,
    NonlinearCriticalSpeed,
    hunting_run,
    linear_critical_speed,
    ramp_run,
    stability,
)
from rollerrig.analysis.contact_state import ContactState, contact_state
from rollerrig.analysis.hunting import bracket
from rollerrig.analysis.parallel import run_jobs
from rollerrig.analysis.traction import with_theory
from rollerrig.run import simulate
from rollerrig.studies.paper.plan import MATERIALS, VARIANTS, PaperPlan, case_of, rig_case, traction_case

Progress = Callable[[float, str], None]
Job = tuple[str, str, Any]

LINEAR_SHARE, FIRST_SHARE = 0.1, 0.75
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
        runs: material -> bracket of the nonlinear critical speed, with its runs.
        traction: the traction run, all signals; None if it was cut off.
        traction_theory: the same wheels beside the closed forms.
        interrupted: whether Ctrl-C was pressed.
    """

    plan: PaperPlan
    modes: dict[str, dict[str, xr.Dataset]] = field(default_factory=dict)
    barriers: dict[str, dict[float, float]] = field(default_factory=dict)
    contact: dict[str, ContactState] = field(default_factory=dict)
    ramps: dict[str, xr.Dataset] = field(default_factory=dict)
    runs: dict[str, NonlinearCriticalSpeed] = field(default_factory=dict)
    traction: xr.Dataset | None = None
    traction_theory: xr.Dataset | None = None
    interrupted: bool = False

    def linear_kmh(self, material: str, variant: str = "bogie on the rig") -> float:
        """Linear critical speed [km/h]; NaN if there is none or it was not computed."""
        modes = self.modes.get(material, {}).get(variant)
        return math.nan if modes is None else float(modes.attrs["linear_critical_speed_kmh"])

    def nonlinear_kmh(self, material: str) -> float:
        """Nonlinear critical speed on the rig [km/h]; NaN if there is none or it was not computed."""
        found = self.runs.get(material)
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
    try:
        _linear_part(results, lambda f, t: report(LINEAR_SHARE * f, t))
    except KeyboardInterrupt:
        results.interrupted = True
        return results
    _first_round(results, processes, lambda f, t: report(LINEAR_SHARE + (FIRST_SHARE - LINEAR_SHARE) * f, t))
    for number in range(MOST_ROUNDS):
        if results.interrupted or not _narrow_down(results, processes):
            break
        if not results.interrupted:
            report(FIRST_SHARE + (1 - FIRST_SHARE) * (number + 1) / MOST_ROUNDS, "nonlinear critical speed")
    if not results.interrupted:
        report(1.0, "done")
    return results


def _linear_part(results: PaperResults, report: Progress) -> None:
    steps = [(material, variant) for material in MATERIALS for variant in VARIANTS]
    for number, (material, variant) in enumerate(steps):
        report(number / len(steps), f"modes: {variant}, {material}")
        modes = stability(case_of(variant, material), results.plan.linear_kmh)
        if modes.attrs["interrupted"]:
            raise KeyboardInterrupt
        results.modes.setdefault(material, {})[variant] = modes
    scan = np.array(results.plan.linear_kmh) / 3.6
    for material in MATERIALS:
        case = rig_case(material)
        results.contact[material] = contact_state(case)
        found = {
            barrier: linear_critical_speed(case.with_changes({"contact.merge_barrier": barrier}), scan.tolist())
            for barrier in results.plan.barriers
        }
        results.barriers[material] = {barrier: math.nan if c is None else c.speed for barrier, c in found.items()}


def _first_round(results: PaperResults, processes: int, report: Progress) -> None:
    plan = results.plan
    jobs: list[Job] = [("ramp", m, (rig_case(m), plan.ramps[m], plan.hunting)) for m in MATERIALS]
    jobs.append(("traction", "", traction_case(plan)))
    for material in MATERIALS:
        fastest_first = sorted(plan.runs_kmh[material], reverse=True)
        jobs += [("run", material, (rig_case(material), v / 3.6, plan.hunting)) for v in fastest_first]
    done = run_jobs(paper_job, jobs, processes=processes, progress=report, names=[_label(job) for job in jobs])
    results.interrupted = done.interrupted
    runs: dict[str, list[HuntingRun]] = {}
    for (kind, material, _), result in zip(jobs, done.results, strict=True):
        if result is None:
            continue
        if kind == "ramp":
            results.ramps[material] = result
        elif kind == "run":
            runs.setdefault(material, []).append(result)
        else:
            results.traction = result
            results.traction_theory = with_theory(result, traction_case(plan))
    results.runs = {m: bracket(found, plan.hunting.disturbance) for m, found in runs.items()}


def _narrow_down(results: PaperResults, processes: int) -> bool:
    """One round of further runs within the brackets; False if none is wide enough."""
    plan = results.plan
    jobs: list[Job] = []
    for material, found in results.runs.items():
        if 3.6 * (found.goes_on - found.dies_out) > plan.bracket_kmh:
            between = np.linspace(found.dies_out, found.goes_on, 4)[1:-1]
            jobs += [("run", material, (rig_case(material), float(v), plan.hunting)) for v in between]
    if not jobs:
        return False
    done = run_jobs(paper_job, jobs, processes=processes, names=[_label(job) for job in jobs])
    results.interrupted = done.interrupted
    for (_, material, _), run in zip(jobs, done.results, strict=True):
        if run is not None:
            known = results.runs[material]
            results.runs[material] = bracket([*known.runs, run], known.disturbance)
    return True


def _label(job: Job) -> str:
    kind, material, argument = job
    if kind == "run":
        return f"run at {3.6 * argument[1]:.0f} km/h, {material}"
    return f"{kind} {material}".strip()


def paper_job(job: Job, progress: Progress) -> Any:
    """One run of the study, on any process.

    Raises:
        KeyboardInterrupt: Ctrl-C came before the end.
    """
    kind, _, argument = job
    if kind == "run":
        return hunting_run(argument, progress)
    if kind == "ramp":
        return ramp_run(argument, progress)
    run = simulate(argument, progress=progress)
    if run.attrs["status"] == "interrupted":
        raise KeyboardInterrupt
    return run
