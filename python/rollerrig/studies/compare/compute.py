"""Everything the comparison needs, computed; Ctrl-C keeps what is done.

ComparePlan -> [linear part, runs from a disturbance, the narrowing down, one disturbed run per support] -> CompareResults
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import xarray as xr

from rollerrig.analysis import (
    CriticalScan,
    HuntingRun,
    HuntingSettings,
    NonlinearCriticalSpeed,
    filtered,
    hunting_run,
    stability,
    wheel_forces,
)
from rollerrig.analysis.contact_state import RollingState, rolling_state
from rollerrig.analysis.critical import scan_case
from rollerrig.analysis.hunting import bracket, hunting_case
from rollerrig.analysis.parallel import Progress, run_jobs
from rollerrig.cases import leading_wheelset, on_rig
from rollerrig.characteristics import conicity_table, shift_table
from rollerrig.config import Case, Rig
from rollerrig.simulation import simulate
from rollerrig.studies.compare.critical import (
    RADII,
    RANGE_KMH,
    Causes,
    CriticalTable,
    Place,
    cause_cases,
    critical_table,
    table_cases,
)

LEAST_RUN_STEP = 20.0
"""Runs are made at speeds at least this far apart [km/h]; the narrowing down does the rest."""

DISTURBED_DURATION = 2.0
"""Length of the run whose wheel forces are compared [s]."""

DISTURBED_SHARE = 0.7
"""It runs at the speed of the range nearest to this share of the lowest critical speed: stable on all supports."""

SHIFT, AMPLITUDES = 8e-3, tuple(1e-4 * k for k in range(5, 71))
"""Lateral shift and amplitudes of the contact characteristics [m]."""

Job = tuple[str, Any, Any]


@dataclass(frozen=True)
class ComparePlan:
    """What is compared.

    Attributes:
        cases: label -> case at a constant speed.
        speeds_kmh: of the modes [km/h], rising; runs are made at those at least LEAST_RUN_STEP apart.
        parts: cuts of the vehicle in the table of critical speeds.
        radii: of its rollers [m].
        bracket_kmh: width to which the nonlinear critical speeds are narrowed down [km/h].
        hunting: disturbance, length and tolerances of the runs.
    """

    cases: dict[str, Case]
    speeds_kmh: tuple[float, ...]
    parts: tuple[str, ...] = ()
    radii: tuple[float, ...] = RADII
    bracket_kmh: float = 3.0
    hunting: HuntingSettings = field(default_factory=HuntingSettings)

    @property
    def rig(self) -> Case:
        """The first case on rollers; else the first case on the catalogue's rig with rollers of its rail's head."""
        first = next(iter(self.cases.values()))
        return next((c for c in self.cases.values() if isinstance(c.support.data, Rig)), None) or on_rig(first)


@dataclass
class CompareResults:
    """What was computed; parts that Ctrl-C cut off are missing.

    Attributes:
        plan: what was asked for.
        modes: label -> Dataset of `stability`.
        critical: label -> linear critical speeds from 30 to 600 km/h, whatever the range of the modes.
        states: label -> steady rolling at the lowest speed.
        shifts: label -> Dataset of `shift_table`.
        conicity: label -> Dataset of `conicity_table`.
        table: critical speeds over the rollers' radius.
        causes: of the difference between track and rig.
        runs: label -> bracket of the nonlinear critical speed, with its runs.
        disturbed: label -> readings of the disturbed run, filtered, with the motion of the leading wheelset.
        disturbed_kmh: its speed [km/h]; NaN if it was not run.
        interrupted: whether Ctrl-C was pressed.
    """

    plan: ComparePlan
    modes: dict[str, xr.Dataset] = field(default_factory=dict)
    critical: dict[str, CriticalScan] = field(default_factory=dict)
    states: dict[str, RollingState] = field(default_factory=dict)
    shifts: dict[str, xr.Dataset] = field(default_factory=dict)
    conicity: dict[str, xr.Dataset] = field(default_factory=dict)
    table: CriticalTable | None = None
    causes: Causes | None = None
    runs: dict[str, NonlinearCriticalSpeed] = field(default_factory=dict)
    disturbed: dict[str, xr.Dataset] = field(default_factory=dict)
    disturbed_kmh: float = math.nan
    interrupted: bool = False

    def linear_kmh(self, label: str) -> float:
        """Linear critical speed [km/h]; NaN if there is none or it was not computed."""
        scan = self.critical.get(label)
        return math.nan if scan is None else scan.speed_kmh

    def nonlinear_kmh(self, label: str) -> float:
        """Nonlinear critical speed [km/h]; NaN likewise."""
        found = self.runs.get(label)
        return math.nan if found is None else 3.6 * found.speed


def compute(plan: ComparePlan, *, processes: int = 2, progress: Progress | None = None) -> CompareResults:
    """Compute the comparison.

    Args:
        plan: what is compared.
        processes: jobs at a time.
        progress: called with the fraction done and a short text.

    Raises:
        StartError: a case finds no rolling equilibrium.
    """
    report: Progress = progress or (lambda _fraction, _text: None)
    results = CompareResults(plan)
    phases: list[tuple[float, Callable[[CompareResults, int, Progress], None]]] = [
        (0.25, _linear_part),
        (0.75, _first_runs),
        (0.93, _narrow_down),
        (1.0, _disturbed_runs),
    ]
    start = 0.0
    for end, phase in phases:
        if not results.interrupted:
            phase(results, processes, lambda f, t, a=start, b=end: report(a + (b - a) * f, t))  # type: ignore[misc]
        start = end
    return results


def compare_job(job: Job, progress: Progress) -> Any:
    """One part of the comparison, on any process.

    Raises:
        KeyboardInterrupt: Ctrl-C came before the end.
        StartError: no rolling equilibrium.
    """
    kind, _, argument = job
    match kind:
        case "modes":
            case, speeds = argument
            modes = stability(case, speeds, progress=progress)
            if modes.attrs["interrupted"]:
                raise KeyboardInterrupt
            return modes
        case "scan":
            return scan_case(argument, progress)
        case "state":
            return rolling_state(*argument)
        case "shift":
            return shift_table(argument, SHIFT)
        case "run":
            return hunting_run(argument, progress)
        case _:
            return _disturbed(argument, progress)


def _disturbed(argument: tuple[Case, float, HuntingSettings], progress: Progress) -> xr.Dataset:
    case, speed, settings = argument
    run = simulate(hunting_case(case, speed, settings), progress=progress)
    if run.attrs["status"] == "interrupted":
        raise KeyboardInterrupt
    leading = leading_wheelset(case).name
    read = filtered(wheel_forces(run))
    motion = run["lateral"].sel(body=leading, drop=True)
    creep = run["longitudinal_force"]
    return read.assign(lateral=motion, longitudinal_force=creep).assign_attrs(
        status=run.attrs["status"], leading=leading, config_toml=run.attrs["config_toml"]
    )


def _do(results: CompareResults, jobs: list[Job], names: list[str], processes: int, progress: Progress) -> list[Any]:
    done = run_jobs(compare_job, jobs, processes=processes, progress=progress, names=names)
    results.interrupted = results.interrupted or done.interrupted
    return done.results


def _linear_part(results: CompareResults, processes: int, progress: Progress) -> None:
    plan = results.plan
    places, on = table_cases(plan.rig, plan.parts, plan.radii), cause_cases(plan.rig)
    speeds = [v / 3.6 for v in RANGE_KMH]
    jobs: list[Job] = []
    for label, case in plan.cases.items():
        jobs += [
            ("modes", label, (case, plan.speeds_kmh)),
            ("state", label, (case, plan.speeds_kmh[0] / 3.6)),
            ("shift", label, case),
        ]
    jobs += [("scan", key, (case, speeds)) for key, case in (*plan.cases.items(), *on.items(), *places.items())]
    names = [f"{kind} {key if isinstance(key, str) else ''}".strip() for kind, key, _ in jobs]
    scans: dict[Any, CriticalScan] = {}
    for (kind, key, _), result in zip(jobs, _do(results, jobs, names, processes, progress), strict=True):
        if result is None:
            continue
        match kind:
            case "modes":
                results.modes[key] = result
            case "state":
                results.states[key] = result
            case "shift":
                results.shifts[key] = result
                reached = float(result["lateral"][-1])
                results.conicity[key] = conicity_table(result, [a for a in AMPLITUDES if a <= reached])
            case _:
                scans[key] = result
    results.critical = {label: scans[label] for label in plan.cases if label in scans}
    results.causes = Causes({key: scan for key, scan in scans.items() if isinstance(key, frozenset)})
    found: dict[Place, CriticalScan] = {key: scan for key, scan in scans.items() if isinstance(key, tuple)}
    results.table = critical_table(places, found)


def run_speeds(speeds_kmh: tuple[float, ...]) -> list[float]:
    """Speeds of the runs: at least LEAST_RUN_STEP apart [km/h]."""
    chosen = [speeds_kmh[0]]
    for speed in speeds_kmh[1:]:
        if speed - chosen[-1] >= LEAST_RUN_STEP - 1e-9:
            chosen.append(speed)
    return chosen


def _runs(results: CompareResults, wanted: list[tuple[str, float]], processes: int, progress: Progress) -> None:
    """Runs of (label, speed [m/s]), added to what is known."""
    plan = results.plan
    jobs: list[Job] = [("run", label, (plan.cases[label], speed, plan.hunting)) for label, speed in wanted]
    names = [f"{label} at {3.6 * speed:.0f} km/h" for label, speed in wanted]
    done = _do(results, jobs, names, processes, progress)
    known: dict[str, list[HuntingRun]] = {label: found.runs for label, found in results.runs.items()}
    for (label, _), run in zip(wanted, done, strict=True):
        if run is not None:
            known[label] = [*known.get(label, []), run]
    results.runs = {label: bracket(runs, plan.hunting.disturbance) for label, runs in known.items()}


def _first_runs(results: CompareResults, processes: int, progress: Progress) -> None:
    # The fastest take longest and come first, so that no process waits at the end.
    speeds = run_speeds(results.plan.speeds_kmh)[::-1]
    _runs(results, [(label, v / 3.6) for v in speeds for label in results.plan.cases], processes, progress)


def _narrow_down(results: CompareResults, processes: int, progress: Progress) -> None:
    rounds = 0
    while not results.interrupted:
        wide = [
            (label, found)
            for label, found in results.runs.items()
            if 3.6 * (found.goes_on - found.dies_out) > results.plan.bracket_kmh
        ]
        if not wide:
            return
        between = [(label, float(v)) for label, f in wide for v in np.linspace(f.dies_out, f.goes_on, 4)[1:-1]]
        _runs(results, between, processes, lambda f, t, r=rounds: progress(1 - 0.5 ** (r + f), t))  # type: ignore[misc]
        rounds += 1


def _disturbed_runs(results: CompareResults, processes: int, progress: Progress) -> None:
    plan = results.plan
    critical = [v for label in plan.cases for v in (results.linear_kmh(label), results.nonlinear_kmh(label))]
    lowest = min((v for v in critical if math.isfinite(v)), default=plan.speeds_kmh[-1])
    speed = min(plan.speeds_kmh, key=lambda v: abs(v - DISTURBED_SHARE * lowest))
    settings = HuntingSettings(plan.hunting.disturbance, DISTURBED_DURATION, 2e-3, 1e-5, 1e-8)
    jobs: list[Job] = [("disturbed", label, (case, speed / 3.6, settings)) for label, case in plan.cases.items()]
    names = [f"{label}, disturbed" for label in plan.cases]
    done = _do(results, jobs, names, processes, progress)
    results.disturbed_kmh = speed
    results.disturbed = {label: run for label, run in zip(plan.cases, done, strict=True) if run is not None}
