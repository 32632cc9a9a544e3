"""Critical speed by its three definitions, each under its own name in every output.

    linear             lowest speed at which an oscillatory mode of the linearised vehicle begins to grow
    by disturbance     lowest speed at which a perturbation of a given size persists: runs at constant speed, bracketed
    by continuation    lowest speed of a stable limit cycle: speed stepped down, each run begun with the state of the one before

    Case, speeds -> [modes over speed | runs from a disturbance | limit-cycle diagram] -> critical_speed -> Dataset

A limit cycle exists only above the fold of its branch, and above the linear critical speed every perturbation grows: for a
subcritical bifurcation

    by continuation  <=  by disturbance  <=  linear

each within the width to which it was found.

Equations: docs/theory/equilibrium_and_linearisation.md, (L7) and section Limit cycles.
Source: O. Polach, On non-linear methods of bogie stability assessment, Proc. IMechE F 220 (2006).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from rollerrig.analysis.crossings import Crossing, first_onset, growing_at_start, zero_crossings
from rollerrig.analysis.hunting import HuntingRun, HuntingSettings, hunting_run
from rollerrig.analysis.limit_cycle_runs import LimitCycleSettings, limit_cycles
from rollerrig.analysis.linearise import Lineariser
from rollerrig.analysis.parallel import Progress, run_jobs
from rollerrig.analysis.speed_map import SPEEDS_KMH, modes_over_speed
from rollerrig.cases import as_case
from rollerrig.config import Case
from rollerrig.results import variable
from rollerrig.starting_state import StartError

Method = Literal["linear", "disturbance", "continuation"]
HIGHEST_KMH = 600.0
"""Where a linear critical speed is looked for at most, unless higher speeds are asked for [km/h]: no train runs faster."""

FIRST_ROUND = 0.75
"""Fraction of the whole at which the first round of runs ends, for the progress bar."""


def critical_speed(
    case: Case | str,
    *,
    methods: Sequence[Method] = ("linear",),
    speeds_kmh: Sequence[float] = SPEEDS_KMH,
    bracket_kmh: float = 3.0,
    processes: int = 1,
    progress: Progress | None = None,
) -> xr.Dataset:
    """Critical speed of a case by one or several definitions.

    Args:
        case: the case, or its name in the catalogue.
        methods: of 'linear', 'disturbance', 'continuation'.
        speeds_kmh: range of speeds [km/h], rising; runs are made at each of them.
        bracket_kmh: to which those by disturbance and by continuation are found [km/h].
        processes: runs at a time.
        progress: called with the fraction done and a short text.

    Returns:
        `linear_critical_speed`, `critical_speed_by_disturbance`, `critical_speed_by_continuation` [km/h], those asked for. The
        latter two are known between two speeds and have the dimension `end`: 'decays', the highest one below at which the motion
        comes to rest, and 'persists', the lowest at which it does not; NaN where there is none. The linear one is looked for up
        to HIGHEST_KMH where the range has none; the attribute `linear_searched_to_kmh` says how far.

    Raises:
        ConfigError: runs are asked for, and nothing holds the vehicle along the track on its rollers.
        ValueError: an unknown method, or speeds not positive and rising.
        StartError: no rolling equilibrium at one of the speeds.

    Example:
        >>> import rollerrig as rr
        >>> found = rr.critical_speed("bogie_rollers_constant", speeds_kmh=[200, 300])
        >>> round(float(found["linear_critical_speed"]))
        222
    """
    unknown = set(methods) - {"linear", "disturbance", "continuation"}
    if unknown:
        raise ValueError(f"methods: {', '.join(sorted(unknown))}; allowed: linear, disturbance, continuation")
    chosen, searched_to = as_case(case), math.nan
    found: dict[str, float | NDArray[np.float64]] = {}
    report: Progress = progress or (lambda _fraction, _text: None)

    def part(number: int) -> Progress:
        return lambda f, t: report((number + f) / len(methods), t)

    for number, method in enumerate(dict.fromkeys(methods)):
        if method == "linear":
            onset, searched_to = _onset(chosen, speeds_kmh, part(number))
            found["linear_critical_speed"] = math.nan if onset is None else onset.speed
        elif method == "disturbance":
            runs = critical_speeds_by_disturbance({"": chosen}, speeds_kmh, bracket_kmh=bracket_kmh, processes=processes,
                                                  progress=part(number))  # fmt: skip
            found["critical_speed_by_disturbance"] = np.array([runs[""].decays, runs[""].persists])
        else:
            diagram = limit_cycles(chosen, speeds_kmh, math.nan, LimitCycleSettings(tolerance_kmh=bracket_kmh),
                                   processes=min(2, processes), progress=part(number))  # fmt: skip
            found["critical_speed_by_continuation"] = np.array([diagram.decays, diagram.lowest_cycle])
    variables = {
        name: variable(("end",)[: np.ndim(v)], 3.6 * v, "km/h", name.replace("_", " ")) for name, v in found.items()
    }
    ends = {"end": ["decays", "persists"]} if any(np.ndim(v) for v in found.values()) else {}
    attributes = {"case": chosen.name, "title": f"Critical speed of {chosen.name}"}
    return xr.Dataset(variables, ends, attributes | {"linear_searched_to_kmh": searched_to})


def _onset(case: Case, speeds_kmh: Sequence[float], progress: Progress) -> tuple[Crossing | None, float]:
    """Lowest onset of growth at the speeds asked for or above them, and the highest speed looked at [km/h]."""
    modes = modes_over_speed(case, [v / 3.6 for v in speeds_kmh], progress)
    found = first_onset(zero_crossings(modes))
    if found is not None or growing_at_start(modes) or modes.followed.interrupted or speeds_kmh[-1] >= HIGHEST_KMH:
        return found, speeds_kmh[-1]
    above = scan_above(case, speeds_kmh[-1], progress)
    return above.onset, speeds_kmh[-1] if above.problem else HIGHEST_KMH


# ---------------------------------------------------------------------------------------------------------- linear


@dataclass(frozen=True)
class LinearCriticalSpeed:
    """Linear critical speed of one case in a range.

    Attributes:
        onset: the lowest speed above which an oscillation grows; None if there is none in the range.
        crossings: all crossings of zero growth, by speed.
        grows_at_start: names of the modes that grow already at the lowest speed.
        problem: why nothing could be computed; '' if it could.
    """

    onset: Crossing | None = None
    crossings: list[Crossing] = field(default_factory=list)
    grows_at_start: tuple[str, ...] = ()
    problem: str = ""

    @property
    def speed_kmh(self) -> float:
        """The linear critical speed [km/h]; NaN if there is none."""
        return math.nan if self.onset is None else 3.6 * self.onset.speed


def linear_critical_speed(
    case: Case | Lineariser, speeds: Sequence[float], progress: Callable[[float, str], None] | None = None
) -> Crossing | None:
    """The lowest speed at which an oscillatory mode turns from damped to growing.

    Args:
        case: the case, or its lineariser.
        speeds: range of speeds [m/s], rising; where they are far apart, further ones are put between them.
        progress: called with the fraction done and a short text.

    Returns:
        The crossing, to `crossings.SPEED_TOLERANCE`; None if nothing changes from damped to growing in the range.

    Raises:
        ValueError: speeds not rising or not positive.
        StartError: no rolling equilibrium at one of the speeds.
    """
    return first_onset(zero_crossings(modes_over_speed(case, speeds, progress)))


def scan_linear(job: tuple[Case, Sequence[float]], progress: Progress | None = None) -> LinearCriticalSpeed:
    """Linear critical speed of one case between speeds [m/s]; a missing equilibrium is returned as `problem`, not raised.

    Raises:
        KeyboardInterrupt: Ctrl-C came before the end.
    """
    case, speeds = job
    try:
        modes = modes_over_speed(case, speeds, progress)
    except StartError as problem:
        return LinearCriticalSpeed(problem=str(problem))
    if modes.followed.interrupted:
        raise KeyboardInterrupt
    crossings = zero_crossings(modes)
    return LinearCriticalSpeed(first_onset(crossings), crossings, growing_at_start(modes))


def scan_above(case: Case, above_kmh: float, progress: Progress | None = None) -> LinearCriticalSpeed:
    """Linear critical speed of a case between a speed and HIGHEST_KMH [km/h]; a missing equilibrium is its `problem`.

    Raises:
        KeyboardInterrupt: Ctrl-C came before the end.
    """
    return scan_linear((case, [above_kmh / 3.6, HIGHEST_KMH / 3.6]), progress)


def linear_critical_speeds(
    cases: Mapping[str, Case], speeds_kmh: Sequence[float], *, processes: int = 1, progress: Progress | None = None
) -> dict[str, LinearCriticalSpeed]:
    """Linear critical speeds of several cases, such as radii of rollers, vehicles or supports.

    Args:
        cases: label -> case.
        speeds_kmh: range of speeds [km/h], rising; where they are far apart, further ones are put between them.
        processes: cases at a time.
        progress: called with the fraction done and a short text.

    Returns:
        Label -> what was found, in the order of `cases`; after Ctrl-C, those that were done.

    Example:
        >>> from rollerrig import load_case
        >>> rig = load_case("bogie_rollers_constant")
        >>> radii = {f"{r} m": rig.with_changes({"support.roller_radius": r}) for r in (0.5, 1.0)}
        >>> found = linear_critical_speeds(radii, [60, 400])
        >>> found["0.5 m"].speed_kmh < found["1.0 m"].speed_kmh
        True
    """
    labels = list(cases)
    jobs = [(cases[label], [v / 3.6 for v in speeds_kmh]) for label in labels]
    done = run_jobs(scan_linear, jobs, processes=processes, progress=progress, names=labels)
    return {label: scan for label, scan in zip(labels, done.results, strict=True) if scan is not None}


# -------------------------------------------------------------------------------------------------- by disturbance


@dataclass(frozen=True)
class CriticalSpeedByDisturbance:
    """Between which speeds a perturbation of one size begins to persist.

    Attributes:
        decays: highest speed, below the onset, at which it decayed [m/s]; NaN if it never did.
        persists: lowest speed at which it persisted [m/s]; NaN if it never did.
        disturbance: its size, lateral offset of the leading wheelset [m].
        runs: all runs made for it, by speed; those that did not come to their end count neither way.
        interrupted: whether Ctrl-C came before it was narrowed down.
    """

    decays: float
    persists: float
    disturbance: float
    runs: list[HuntingRun]
    interrupted: bool = False

    def further_speeds(self, width: float) -> list[float]:
        """Speeds of the next round of runs, the bracket in thirds [m/s]; none if it is narrower than a width [m/s].

        None either where runs have been made there that did not come to their end.
        """
        if not self.persists - self.decays > width:  # also where one of them is NaN
            return []
        tried = {run.speed for run in self.runs}
        return [float(v) for v in np.linspace(self.decays, self.persists, 4)[1:-1] if float(v) not in tried]

    @property
    def ended_early(self) -> list[HuntingRun]:
        """Runs that did not come to their end: neither decay nor limit cycle."""
        return [run for run in self.runs if not run.valid]


def bracket(runs: Iterable[HuntingRun], disturbance: float) -> CriticalSpeedByDisturbance:
    """The critical speed by disturbance among runs at several speeds."""
    ordered = sorted(runs, key=lambda run: run.speed)
    persists = min((run.speed for run in ordered if run.persists), default=math.nan)
    decays = max((run.speed for run in ordered if run.decays and not run.speed > persists), default=math.nan)
    return CriticalSpeedByDisturbance(decays, persists, disturbance, ordered)


def critical_speeds_by_disturbance(
    cases: Mapping[str, Case],
    speeds_kmh: Sequence[float],
    *,
    bracket_kmh: float = 3.0,
    settings: HuntingSettings | None = None,
    processes: int = 1,
    progress: Progress | None = None,
) -> dict[str, CriticalSpeedByDisturbance]:
    """Critical speeds by disturbance of several cases, narrowed down round by round.

    Args:
        cases: label -> case.
        speeds_kmh: of the first round of runs [km/h].
        bracket_kmh: width to which the brackets are narrowed down [km/h].
        settings: disturbance, length and tolerances of the runs.
        processes: runs at a time.
        progress: called with the fraction done and a short text.

    Returns:
        Label -> what was found; after Ctrl-C what the finished runs say, with `interrupted`.

    Raises:
        ConfigError: nothing holds a vehicle along the track on its rollers.
        StartError: no state was found from which a run can start.
    """
    chosen = settings or HuntingSettings()
    report: Progress = progress or (lambda _fraction, _text: None)
    runs: dict[str, list[HuntingRun]] = {label: [] for label in cases}
    found: dict[str, CriticalSpeedByDisturbance] = {}
    speeds = dict.fromkeys(cases, speeds_kmh)
    for number, wanted in enumerate(rounds_by_disturbance(speeds, bracket_kmh, runs, chosen.disturbance)):
        done = run_jobs(
            hunting_run,
            [(cases[label], speed, chosen) for label, speed in wanted],
            processes=processes,
            progress=lambda f, t, k=number: report(_share_done(k, f), t),  # type: ignore[misc]
            names=[f"{label} at {3.6 * speed:.0f} km/h".strip() for label, speed in wanted],
        )
        for (label, _), run in zip(wanted, done.results, strict=True):
            runs[label] += [run] if run is not None else []
        found = {label: bracket(runs[label], chosen.disturbance) for label in cases}
        if done.interrupted:
            return {label: replace(one, interrupted=True) for label, one in found.items()}
    return found


def rounds_by_disturbance(
    speeds_kmh: Mapping[str, Sequence[float]],
    width_kmh: float,
    runs: Mapping[str, list[HuntingRun]],
    disturbance: float,
) -> Iterator[list[tuple[str, float]]]:
    """Rounds of runs that narrow critical speeds by disturbance down: label and speed [m/s] of each run.

    Args:
        speeds_kmh: label -> speeds of the first round [km/h].
        width_kmh: to which the brackets are narrowed down [km/h].
        runs: label -> finished runs; the caller adds those of a round before it asks for the next one.
        disturbance: lateral offset of the leading wheelset [m].
    """
    first = [(label, v / 3.6) for label, speeds in speeds_kmh.items() for v in speeds]
    yield sorted(first, key=lambda run: -run[1])  # the fastest take longest: no process shall wait for them at the end
    while wanted := [
        (label, v) for label in runs for v in bracket(runs[label], disturbance).further_speeds(width_kmh / 3.6)
    ]:
        yield wanted


def _share_done(finished_rounds: int, fraction: float) -> float:
    """Fraction of the whole: each further round takes half of what is left."""
    if finished_rounds == 0:
        return FIRST_ROUND * fraction
    left = float(0.5 ** (finished_rounds - 1 + fraction))
    return 1.0 - (1.0 - FIRST_ROUND) * left
