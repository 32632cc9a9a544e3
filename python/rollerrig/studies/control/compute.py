"""Which controller of the roller drives bears what: runs of one case under many variants, and where each first breaks.

Case -> [families] -> variants -> [run_jobs] -> Result per run -> [breaks] -> value at which tracking is lost

Tracking is the wheel's speed less the virtual wheel's, over the train's speed (docs/theory/rig_control.md).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy.signal import butter, sosfiltfilt, welch

from rollerrig.actuators import assemble_with_actuators
from rollerrig.analysis.parallel import run_jobs
from rollerrig.analysis.tracking import slip, tracking
from rollerrig.bench import BenchRun
from rollerrig.config import Case, ConfigError, ConfigProblem, Rig
from rollerrig.config.errors import nearest
from rollerrig.simulation import simulate
from rollerrig.studies.control.families import FAMILIES, REFERENCES, USER, Changes, Family
from rollerrig.studies.control.ring import RingPoint, ring_jobs, ring_run, whole_run

Progress = Callable[[float, str], None]
Array = NDArray[np.float64]

LOST = 0.01
"""Tracking RMS over train speed from which on a variant counts as broken: the project's aim for the shipped cases."""

LOST_RIPPLE = 500.0
"""Ripple of a roller's torque [N m] from which on a variant counts as broken: a tenth of what low adhesion asks for, R T_v."""

OUTPUT_STEP = 2e-3
"""Of the runs compared [s]; ripple is seen up to its Nyquist frequency, 250 Hz."""

RIPPLE_ABOVE = 10.0
"""Slide protection acts at a few hertz; what shakes faster is the loop or its noise [Hz]."""

KEPT = ("axle_speed", "virtual_speed", "train_speed", "real_sliding", "roller_torque", "valve")
"""Variables of a run that a figure over time draws."""


@dataclass(frozen=True)
class Variant:
    """One run to be made.

    Attributes:
        family, curve: where it belongs.
        value: on the family's axis; NaN for a reference.
        case: what is run.
        keep: whether its course over time is kept.
    """

    family: str
    curve: str
    value: float
    case: Case
    keep: bool = False


@dataclass(frozen=True)
class Result:
    """What came out of a run.

    Attributes:
        family, curve, value: of the variant.
        numbers: under the keys of RESULT_KEYS.
        course: KEPT over time; None unless asked for.
    """

    family: str
    curve: str
    value: float
    numbers: dict[str, Any]
    course: xr.Dataset | None = None

    @property
    def cause(self) -> str:
        """What is wrong: the status of a run that ended early, 'tracking', 'ripple', or nothing."""
        if self.numbers["status"] != "ok":
            return str(self.numbers["status"])
        if not self.numbers["tracking_rms"] < LOST:
            return "tracking"
        return "ripple" if self.numbers["ripple_nm"] > LOST_RIPPLE else ""

    @property
    def severity(self) -> tuple[float, float]:
        """Order of results: an ended test before any error, the earlier the worse; then the larger error over its limit.

        A ripple within its limit does not count: it scatters with the switching of valves.
        """
        if self.numbers["status"] != "ok":
            return math.inf, -float(self.numbers["ended_s"])
        ripple, tracking = self.numbers["ripple_nm"] / LOST_RIPPLE, self.numbers["tracking_rms"] / LOST
        return max(tracking, ripple if ripple > 1.0 else 0.0), 0.0


RESULT_KEYS = {
    "status": "how the run ended",
    "ended_s": "when [s]",
    "tracking_rms": "wheel less virtual wheel over train speed, RMS over axles and time [-]",
    "tracking_largest": "largest of the same [-]",
    "largest_slip": "of the wheels against the virtual train, over its speed [-]",
    "real_sliding_rms_mps": "wheel against roller [m/s]",
    "real_sliding_largest_mps": "largest of the same [m/s]",
    "roller_torque_largest_nm": "of a roller drive [N m]",
    "distance_m": "run by the virtual train [m]",
    "distance_relative": "over that of the case as shipped at the same time, less 1 [-]",
    "dump_cycles": "dump cycles of the slide protection, all axles",
    "air_litres": "taken by the cylinders, at ambient pressure [l]",
    "ripple_nm": f"roller torque above {RIPPLE_ABOVE:g} Hz, RMS in the median quarter second: what never ceases [N m]",
    "ripple_hz": "where that ripple has most power [Hz]",
}
"""Column of variants.csv, key in summary.json -> meaning."""


@dataclass(frozen=True)
class Break:
    """Where a curve first breaks on one side of the value that the case has.

    Attributes:
        family, curve: which.
        value: at which tracking or ripple passes its limit, interpolated, or at which the test first ended early.
        good: last value that was well.
        cause: as of Result.
    """

    family: str
    curve: str
    value: float
    good: float
    cause: str


@dataclass(frozen=True)
class Study:
    """Everything `rollerrig control` found.

    Attributes:
        case: with the study's duration.
        families: that were run.
        references: of REFERENCES and, where given, the user's controller.
        results: of the families.
        ring: the loop's limit, computed and measured.
        interrupted: whether Ctrl-C was pressed.
    """

    case: Case
    families: tuple[Family, ...]
    references: list[Result]
    results: list[Result]
    ring: list[RingPoint] = field(default_factory=list)
    interrupted: bool = False

    def curve(self, family: str, curve: str) -> list[Result]:
        """Results of one curve in the order of its axis."""
        return sorted((r for r in self.results if (r.family, r.curve) == (family, curve)), key=lambda r: r.value)


# -------------------------------------------------------------------------------------------------------- what is run


def chosen_families(names: Sequence[str] | None, case: str) -> tuple[Family, ...]:
    """Families by name; None: all.

    Raises:
        ConfigError: there is no such family.
    """
    known = {family.name: family for family in FAMILIES}
    problems = []
    for name in names or ():
        if name not in known:
            guess = nearest(name, tuple(known))
            allowed = f"allowed: {', '.join(known)}" + (f"; did you mean {guess!r}?" if guess else "")
            problems.append(ConfigProblem(case, "families", repr(name), allowed))
    if problems:
        raise ConfigError(problems)
    return FAMILIES if not names else tuple(known[name] for name in dict.fromkeys(names))


def study_case(case: Case, duration: float | None) -> Case:
    """The case as it is compared: shortened, and recorded finely enough to see ripple.

    Raises:
        ConfigError: it has no rig controller, or nothing that it could follow.
    """
    if not isinstance(case.support.data, Rig) or case.rig_control is None:
        needed = "needed: a case on rollers with [rig_control], the controller to be compared"
        raise ConfigError([ConfigProblem(case.name, "rig_control", "missing", needed)])
    if case.rig_control.user is not None:
        needed = "needed: our controller in the case; give your own with --controller, beside ours"
        raise ConfigError([ConfigProblem(case.name, "rig_control.user", repr(case.rig_control.user), needed)])
    if case.brake is None and case.traction is None:
        needed = "needed: [brake] or [traction], the test that the controllers are compared in"
        raise ConfigError([ConfigProblem(case.name, "brake", "missing", needed)])
    length = case.time.duration if duration is None else min(duration, case.time.duration)
    return case.with_changes({"time.duration": length, "time.output_step": max(OUTPUT_STEP, case.bench.step)})


def variants(case: Case, families: Sequence[Family], user: str | None) -> tuple[list[Variant], list[Variant]]:
    """References, and the families' variants.

    Raises:
        ConfigError: the user's controller cannot be used.
    """
    own: Changes = {"rig_control.user": user}
    references = dict(REFERENCES) | ({USER: own} if user else {})
    plain = [Variant("references", label, math.nan, case.with_changes(c), True) for label, c in references.items()]
    if user:
        BenchRun(assemble_with_actuators(plain[-1].case))  # refused now rather than in a worker
    found = []
    for family in families:
        curves = dict(family.curves) | ({USER: own} if user and family.user else {})
        for label, curve in curves.items():
            for value in family.values:
                changed = case.with_changes(family.changes(case, curve, value))
                found.append(Variant(family.name, label, float(value), changed))
    return plain, found


def compare_controllers(
    case: Case,
    *,
    families: Sequence[Family] = FAMILIES,
    user: str | None = None,
    limits: bool = True,
    processes: int = 2,
    progress: Progress | None = None,
) -> Study | None:
    """Run all variants of a case.

    Args:
        case: of `study_case`.
        families: which of FAMILIES.
        user: 'file.py:Class' of a controller to be tried beside ours.
        limits: also find where the loop begins to ring, computed and measured.
        processes: runs at a time.
        progress: called with the fraction done and a text.

    Returns:
        What was found; None where Ctrl-C came before anything was.

    Raises:
        ConfigError, StartError: as `simulate`.
    """
    plain, found = variants(case, families, user)
    rings = ring_jobs(case) if limits else []
    jobs = [*plain, *found, *rings]
    names = [getattr(job, "family", "limit of the loop").replace("_", " ") for job in jobs]
    done = run_jobs(_job, jobs, processes=processes, progress=progress, names=names)
    results = [r for r in done.results if isinstance(r, Result)]
    base = next((r for r in results if r.family == "references"), None)
    if base is None:
        return None
    results = [_against(r, base) for r in results]
    references = [r for r in results if r.family == "references"]
    rest = [r for r in results if r.family != "references"]
    study = Study(
        case=case,
        families=tuple(families),
        references=references,
        results=rest,
        ring=[r for r in done.results if isinstance(r, RingPoint)],
        interrupted=done.interrupted,
    )
    return study if done.interrupted else _with_courses(study, found, progress)


def _job(job: Any, progress: Progress) -> Result | RingPoint:
    return run_variant(job, progress) if isinstance(job, Variant) else ring_run(job, progress)


def run_variant(variant: Variant, progress: Progress | None = None) -> Result:
    """One run and its numbers."""
    run = whole_run(variant.case, progress)
    course = run[list(KEPT)].load() if variant.keep else None
    return Result(variant.family, variant.curve, variant.value, {**numbers(run), "way": _way(run)}, course)


def _way(run: xr.Dataset) -> tuple[Array, Array]:
    return run["time"].to_numpy()[::50], run["train_distance"].to_numpy()[::50]


def _against(result: Result, base: Result) -> Result:
    """With the distance compared to the base's at the same time."""
    time, way = result.numbers["way"]
    others = np.interp(time[-1], *base.numbers["way"]) if time.size else math.nan
    relative = float(way[-1] / others - 1.0) if time.size and others > 0.0 else None
    kept = {key: value for key, value in result.numbers.items() if key != "way"} | {"distance_relative": relative}
    ordered = {key: kept[key] for key in RESULT_KEYS}
    return replace(result, numbers=ordered)


def _with_courses(study: Study, found: Sequence[Variant], progress: Progress | None) -> Study:
    """The worst run of each cause that came to its end is run once more, for its course over time."""
    again: dict[tuple[str, str, float], xr.Dataset] = {}
    for cause in ("tracking", "ripple"):
        worst = max((r for r in study.results if r.cause == cause), key=lambda r: r.severity, default=None)
        if worst is None:
            continue
        key = (worst.family, worst.curve, worst.value)
        case = next(v.case for v in found if (v.family, v.curve, v.value) == key)
        run = simulate(case, progress=lambda _fraction, text: progress(1.0, text) if progress else None)
        again[key] = run[list(KEPT)]
    results = [replace(r, course=again.get((r.family, r.curve, r.value))) for r in study.results]
    return replace(study, results=results)


# ------------------------------------------------------------------------------------------------------------- numbers


def numbers(run: xr.Dataset) -> dict[str, Any]:
    """The numbers of one run, those that need no other run."""
    error, largest = tracking(run)
    sliding = run["real_sliding"].to_numpy()
    last = run.isel(time=-1)
    slips = abs(slip(run)).to_numpy()
    ripple, frequency = ripple_of(run["time"].to_numpy(), run["roller_torque"].to_numpy())
    return {
        "status": run.attrs["status"],
        "ended_s": float(run.attrs["stopped_at_s"]),
        "tracking_rms": error,
        "tracking_largest": largest,
        "largest_slip": float(np.nanmax(slips)) if np.isfinite(slips).any() else math.nan,
        "real_sliding_rms_mps": float(np.sqrt(np.mean(sliding**2))),
        "real_sliding_largest_mps": float(np.abs(sliding).max()),
        "roller_torque_largest_nm": float(np.abs(run["roller_torque"]).max()),
        "distance_m": float(last["train_distance"]),
        "dump_cycles": int(last["dump_cycles"].sum()),
        "air_litres": 1e3 * float(last["air"].sum()),
        "ripple_nm": ripple,
        "ripple_hz": frequency,
    }


def ripple_of(time: Array, torque: Array) -> tuple[float, float]:
    """Ripple that never ceases in the worst axle's torque, and its frequency.

    The RMS above RIPPLE_ABOVE in quarters of a second; the median of them, since a valve's switching is over sooner than
    every second of them.

    Args:
        time: evenly spaced [s], shape (time,).
        torque: [N m], shape (time, axle).

    Returns:
        RMS [N m] and frequency of most power [Hz]; NaN where the run is shorter than half a second.
    """
    if time.size < 2 or time[-1] - time[0] < 0.5 or not np.isfinite(torque).all():
        return math.nan, math.nan
    step = float(time[1] - time[0])
    window = round(0.25 / step)
    high = sosfiltfilt(butter(4, RIPPLE_ABOVE, "highpass", fs=1.0 / step, output="sos"), torque, axis=0)
    count = len(high) // window
    parts = np.sqrt(np.mean(high[: count * window].reshape(count, window, -1) ** 2, axis=1))
    median = np.median(parts, axis=0)
    worst = int(np.argmax(median))
    frequency, power = welch(high[:, worst], fs=1.0 / step, nperseg=min(len(high), 4 * window))
    return float(median[worst]), float(frequency[np.argmax(power)])


# -------------------------------------------------------------------------------------------------- what breaks first


def breaks(family: Family, points: Sequence[Result], base: float | None) -> list[Break]:
    """Where a curve is first lost, going out from the base value to either side.

    Args:
        family: of the curve.
        points: of one curve, in the order of the axis.
        base: value of the case; None: it is gone out from the best point.
    """
    if not points:
        return []
    if base is None:
        start = min(range(len(points)), key=lambda k: points[k].severity)
    else:
        start = int(np.argmin([abs(_along(family, p.value) - _along(family, base)) for p in points]))
    if points[start].cause:
        return [Break(family.name, points[start].curve, points[start].value, math.nan, points[start].cause)]
    found = []
    for way in (-1, 1):
        k = start
        while 0 <= k + way < len(points) and not points[k + way].cause:
            k += way
        if 0 <= k + way < len(points):
            found.append(_crossing(family, points[k], points[k + way]))
    return found


def _along(family: Family, value: float) -> float:
    return math.log(value) if family.scale == "log" else value


def _crossing(family: Family, good: Result, bad: Result) -> Break:
    """Interpolated in the logarithm of the error; of a test that ended early, the first value tried."""
    value = bad.value
    key, limit = {"tracking": ("tracking_rms", LOST), "ripple": ("ripple_nm", LOST_RIPPLE)}.get(bad.cause, ("", 0.0))
    if key:
        low, high = (math.log(r.numbers[key]) for r in (good, bad))
        part = (math.log(limit) - low) / (high - low)
        a, b = _along(family, good.value), _along(family, bad.value)
        value = a + part * (b - a)
        value = math.exp(value) if family.scale == "log" else value
    return Break(family.name, bad.curve, value, good.value, bad.cause)


@dataclass(frozen=True)
class Rank:
    """One curve in the order of how badly it fares.

    Attributes:
        family: of FAMILIES.
        points: its results along the axis.
        worst: the result of most severity.
        breaks: where it is lost, 0 to 2 places.
    """

    family: Family
    points: list[Result]
    worst: Result
    breaks: list[Break]

    @property
    def curve(self) -> str:
        """Its label."""
        return self.worst.curve


def ranking(study: Study) -> list[Rank]:
    """All curves, the most severe result within the range tried first."""
    ranks = []
    for family in study.families:
        for label in dict.fromkeys(r.curve for r in study.results if r.family == family.name):
            points = study.curve(family.name, label)
            base = family.base(study.case) if family.base is not None else None
            worst = max(points, key=lambda r: r.severity)
            ranks.append(Rank(family, points, worst, breaks(family, points, base)))
    return sorted(ranks, key=lambda rank: rank.worst.severity, reverse=True)
