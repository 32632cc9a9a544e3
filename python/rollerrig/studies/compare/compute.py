"""Everything the comparison needs, computed; Ctrl-C keeps what is done.

ComparePlan -> [linear part, runs from a disturbance, one disturbed run per support] -> CompareResults
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import xarray as xr

from rollerrig.analysis import (
    CriticalSpeedByDisturbance,
    HuntingSettings,
    LinearCriticalSpeed,
    filtered,
    stability,
    wheel_forces,
)
from rollerrig.analysis.contact_state import RollingState, rolling_state
from rollerrig.analysis.critical_speed import critical_speeds_by_disturbance, scan_linear
from rollerrig.analysis.hunting import hunting_case
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
"""Runs are made at speeds at least this far apart [km/h]; further runs narrow the critical speeds down."""

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
        bracket_kmh: width to which the critical speeds by disturbance are narrowed down [km/h].
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
        runs: label -> critical speed by disturbance, with its runs.
        disturbed: label -> readings of the disturbed run, filtered, with the motion of the leading wheelset.
        disturbed_kmh: its speed [km/h]; NaN if it was not run.
        interrupted: whether Ctrl-C was pressed.
    """

    plan: ComparePlan
    modes: dict[str, xr.Dataset] = field(default_factory=dict)
    critical: dict[str, LinearCriticalSpeed] = field(default_factory=dict)
    states: dict[str, RollingState] = field(default_factory=dict)
    shifts: dict[str, xr.Dataset] = field(default_factory=dict)
    conicity: dict[str, xr.Dataset] = field(default_factory=dict)
    table: CriticalTable | None = None
    causes: Causes | None = None
    runs: dict[str, CriticalSpeedByDisturbance] = field(default_factory=dict)
    disturbed: dict[str, xr.Dataset] = field(default_factory=dict)
    disturbed_kmh: float = math.nan
    interrupted: bool = False

    def linear_kmh(self, label: str) -> float:
        """Linear critical speed [km/h]; NaN if there is none or it was not computed."""
        scan = self.critical.get(label)
        return math.nan if scan is None else scan.speed_kmh

    def by_disturbance_kmh(self, label: str) -> float:
        """Critical speed by disturbance [km/h]; NaN likewise."""
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
        (0.93, _by_disturbance),
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
            return scan_linear(argument, progress)
        case "state":
            return rolling_state(*argument)
        case "shift":
            return shift_table(argument, SHIFT)
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
    scans: dict[Any, LinearCriticalSpeed] = {}
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
    found: dict[Place, LinearCriticalSpeed] = {key: scan for key, scan in scans.items() if isinstance(key, tuple)}
    results.table = critical_table(places, found)


def run_speeds(speeds_kmh: tuple[float, ...]) -> list[float]:
    """Speeds of the runs: at least LEAST_RUN_STEP apart [km/h]."""
    chosen = [speeds_kmh[0]]
    for speed in speeds_kmh[1:]:
        if speed - chosen[-1] >= LEAST_RUN_STEP - 1e-9:
            chosen.append(speed)
    return chosen


def _by_disturbance(results: CompareResults, processes: int, progress: Progress) -> None:
    plan = results.plan
    results.runs = critical_speeds_by_disturbance(
        plan.cases,
        run_speeds(plan.speeds_kmh),
        bracket_kmh=plan.bracket_kmh,
        settings=plan.hunting,
        processes=processes,
        progress=progress,
    )
    results.interrupted = any(found.interrupted for found in results.runs.values())


def _disturbed_runs(results: CompareResults, processes: int, progress: Progress) -> None:
    plan = results.plan
    critical = [v for label in plan.cases for v in (results.linear_kmh(label), results.by_disturbance_kmh(label))]
    lowest = min((v for v in critical if math.isfinite(v)), default=plan.speeds_kmh[-1])
    speed = min(plan.speeds_kmh, key=lambda v: abs(v - DISTURBED_SHARE * lowest))
    settings = HuntingSettings(plan.hunting.disturbance, DISTURBED_DURATION, 2e-3, 1e-5, 1e-8)
    jobs: list[Job] = [("disturbed", label, (case, speed / 3.6, settings)) for label, case in plan.cases.items()]
    names = [f"{label}, disturbed" for label in plan.cases]
    done = _do(results, jobs, names, processes, progress)
    results.disturbed_kmh = speed
    results.disturbed = {label: run for label, run in zip(plan.cases, done, strict=True) if run is not None}
