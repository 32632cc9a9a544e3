"""Ensembles: the same test again with what nobody knows drawn anew, and what is then certain of its numbers.

Case, its [ensemble] -> [starts] -> cases with other adhesion, pads, load, speed, demand -> TestRecords -> [Estimate] -> interval
name -> Case, starting points -> [start_jobs] -> jobs -> [started] -> results by name -> [means] -> means with errors

Rig and track draw the same numbers: they are compared test by test, by `difference` and `relative`, and what both depend on
alike cancels. An interval has two parts: the scatter of the draws, and what the results change by when step and samples are a
quarter of those of the case (`finer`).
"""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.special import ndtr, ndtri, stdtrit

from rollerrig.analysis.equivalent_dead_time import DeadTime, at_track_of
from rollerrig.analysis.slide_statistics import TestRecord, test_record
from rollerrig.config import Case, ConfigError, ConfigProblem
from rollerrig.config.schema.ensemble import Ensemble
from rollerrig.study.assessment import Interval
from rollerrig.study.jobs import Done, Job, Progress, Round, whole_run

DRAWN = tuple(name for name in Ensemble.model_fields if name != "distribution")
SEED = 20260713
CONFIDENCE = 0.95
MANY = 1000  # tests that nobody makes to decide one number
FINER, FINER_STARTS = 0.25, 3  # part of step and samples that the finer tests have, and how many of them are made


def starts(case: Case, count: int) -> list[Case]:
    """The test as it is and count - 1 others drawn by its [ensemble], with the same numbers for every case.

    Draws are those of a fixed seed, the first of a longer ensemble those of a shorter one.
    """
    shares = np.random.default_rng(SEED).uniform(size=(max(0, count - 1), len(DRAWN)))
    if case.ensemble.distribution == "normal":
        shares = 0.5 + 0.25 * ndtri(ndtr(-2.0) + shares * (ndtr(2.0) - ndtr(-2.0)))
    return [case, *(drawn(case, dict(zip(DRAWN, row, strict=True))) for row in shares.tolist())]


def drawn(case: Case, shares: Mapping[str, float]) -> Case:
    """One test of an ensemble, by name in [ensemble] where in its distribution, 0 to 1; what is missing keeps its value."""
    spread, changes = case.ensemble, dict[str, object]()
    factors = {name: 1.0 + (2.0 * share - 1.0) * getattr(spread, name) for name, share in shares.items()}
    if case.adhesion is not None and "adhesion" in factors:
        rails = {"rail": case.adhesion.rail, "recovered": case.adhesion.recovered}
        rails |= {f"piece.{k}.rail": piece.rail for k, piece in enumerate(case.adhesion.piece)}
        changes |= {f"adhesion.{k}.friction.mu_0": factors["adhesion"] * r.friction.mu_0 for k, r in rails.items()}
    if case.brake is not None and "pad_friction" in factors:
        changes["brake.friction"] = [[v, factors["pad_friction"] * mu] for v, mu in case.brake.friction]
    loads = [body for body in case.vehicle.data.body if body.kind != "wheelset"]
    if "load" in factors and loads:
        heaviest = max(loads, key=lambda body: body.mass)
        changes[f"vehicle.body.{heaviest.name}.mass"] = f"{factors['load'] * heaviest.mass!r} kg"
    if "speed" in factors:
        changes["motion.speed"] = f"{factors['speed'] * case.motion.speed!r} m/s"
    if "demand_time" in shares:
        late = shares["demand_time"] * spread.demand_time
        for name in ("brake", "traction"):
            if (table := getattr(case, name)) is not None:
                changes[f"{name}.demand"] = _later(table.demand, late)
    return case.with_changes(changes)


def _later(demand: Sequence[tuple[float, float]], delay: float) -> list[list[float]]:
    """All of a demand later, until then its first value."""
    rows = [[t + delay, value] for t, value in demand]
    return [[*demand[0]], *rows] if delay > 0.0 else rows


def check_ensemble(case: Case) -> None:
    """Refuse distributions at whose ends a case has no such value, or is no test, with a ConfigError of a line for each."""
    problems = []
    for name in DRAWN:
        for share in (0.0, 1.0):
            try:
                drawn(case, {name: share})
            except ConfigError as error:
                first = error.problems[0]
                end = f"{getattr(case.ensemble, name):g}, which draws {first.key} = {first.value}"
                problems.append(ConfigProblem(case.name, f"ensemble.{name}", end, first.allowed))
    problems += [ConfigProblem(case.name, key, end, f"allowed: {more}") for key, end, more in _no_tests(case)]
    if problems:
        raise ConfigError(problems)


def _no_tests(case: Case) -> Iterator[tuple[str, str, str]]:
    """Key, its end, and what is allowed, where the case may have such a value but tests nothing with it."""
    spread, duration = case.ensemble, case.time.duration
    speed, stop = case.motion.speed, case.motion.stop_speed
    if case.brake is not None and not (slowest := (1.0 - spread.speed) * speed) > stop:
        key, end = "ensemble.speed", f"{spread.speed:g}, which draws motion.speed = {3.6 * slowest:g} km/h"
        if not speed > stop:  # whatever is drawn
            key, end = "motion.speed", f"{3.6 * speed:g} km/h"
        yield key, end, f"more than motion.stop_speed, {3.6 * stop:g} km/h"
    if case.adhesion is not None and not spread.adhesion < 1.0:
        yield "ensemble.adhesion", f"{spread.adhesion:g}, which draws rails without friction", "less than 1"
    for name in ("brake", "traction"):
        rows = () if getattr(case, name) is None else getattr(case, name).demand
        last = max((t for t, _ in rows if t < duration), default=-math.inf) + spread.demand_time
        if not last < duration:
            end = f"{spread.demand_time:g} s, which draws a row of {name}.demand at {last:g} s"
            yield "ensemble.demand_time", end, f"before time.duration, {duration:g} s"


def finer(case: Case) -> Case:
    """The same test with FINER of its steps and samples: the integration's, and those of the rig's controller."""
    changes: dict[str, object] = {"time.sampling_step": FINER * case.time.sampling_step}
    if case.time.step is not None:
        changes["time.step"] = FINER * case.time.step
    if case.rig_control is not None:
        changes["rig_control.sample_time"] = FINER * case.rig_control.sample_time
    return case.with_changes(changes)


def recorded(case: Case, progress: Progress | None = None) -> TestRecord:
    """Run a test and keep its record: a job, which a KeyboardInterrupt leaves without a result."""
    return test_record(whole_run(case, progress=progress), case)


@dataclass(frozen=True)
class Estimate:
    """Mean over the tests of an ensemble, NaN where one of them has no such number, with its standard error."""

    mean: float
    standard_error: float
    freedom: float  # degrees of freedom of the error; 0: unknown
    # by how much the mean may be off beside that, however many tests are made: step and samples
    systematic: float = 0.0

    @property
    def interval(self) -> Interval:
        """In which the true mean lies with CONFIDENCE, by Student's distribution, and by `systematic` on either side."""
        if not (self.freedom > 0.0 and math.isfinite(self.standard_error)):
            return Interval(-math.inf, math.inf)
        reach = float(stdtrit(self.freedom, 0.5 + 0.5 * CONFIDENCE)) * self.standard_error + self.systematic
        return Interval(self.mean - reach, self.mean + reach)

    def tests_within(self, distance: float) -> float:
        """Number of tests, if mean and scatter stay, whose interval ends at this distance from the mean; inf: above MANY."""
        if not 0.0 < self.freedom < math.inf:
            return math.inf
        tests = np.arange(2.0, MANY + 1.0)
        scatter = self.standard_error * math.sqrt(self.freedom + 1.0)
        reach = stdtrit(tests - 1.0, 0.5 + 0.5 * CONFIDENCE) * scatter / np.sqrt(tests) + self.systematic
        return float(np.min(tests[reach <= distance], initial=math.inf))

    def times(self, factor: float) -> "Estimate":
        """The same in another unit."""
        scaled = {name: factor * getattr(self, name) for name in ("mean", "standard_error", "systematic")}
        return replace(self, **scaled)

    def as_dict(self) -> dict[str, float]:
        """Dictionary for summary.json."""
        return {"mean": self.mean, "standard_error": self.standard_error, **vars(self.interval)}


def estimate(values: Sequence[float]) -> Estimate:
    """Mean and standard error s / sqrt(n) of independent tests, s with n - 1."""
    count = len(values)
    spread = float(np.std(values, ddof=1)) if count > 1 else math.nan
    return Estimate(float(np.mean(values)), spread / math.sqrt(count) if count else math.nan, count - 1.0)


def stepped(found: Estimate, coarse: Estimate | None, fine: Estimate | None) -> Estimate:
    """An estimate whose interval also has what it changes by from coarse to fine steps of the same draws.

    Without bounds where one of them has no number: nobody knows then what the steps change.
    """
    a, b = (math.nan if one is None else one.mean for one in (coarse, fine))
    change = 0.0 if a == b else abs(b - a)  # also where both are infinite: not zero, against zero
    return replace(found, systematic=math.inf if math.isnan(change) else change)


def difference(a: Sequence[float], b: Sequence[float]) -> Estimate:
    """A - b of two ensembles that share their draws, test by test as far as both go."""
    return estimate([x - y for x, y in zip(a, b, strict=False)])


def relative(a: Sequence[float], b: Sequence[float]) -> Estimate:
    """Mean of a over that of b, less 1, of two ensembles that share their draws, test by test as far as both go.

    To first order in the scatter. Infinite where b alone is zero; NaN where both are, and where a test has no number.
    """
    pairs = np.array(list(zip(a, b, strict=False)), dtype=float).reshape(-1, 2)
    pairs[~np.isfinite(pairs)] = math.nan
    mean, base = pairs.mean(axis=0) if len(pairs) else (math.nan, math.nan)
    if not base:
        interval = estimate(pairs[:, 0].tolist()).interval
        if not mean:
            return Estimate(math.nan, math.nan, 0.0)
        apart = interval.low > 0.0 or interval.high < 0.0
        return Estimate(math.copysign(math.inf, mean), 0.0 if apart else math.nan, math.inf)
    ratio = mean / base
    return replace(estimate(((pairs[:, 0] - ratio * pairs[:, 1]) / base).tolist()), mean=float(ratio - 1.0))


def distances(groups: Sequence[Sequence[TestRecord]]) -> list[list[float]]:
    """Distance of the train in each test [m]: to its stop where all tests of all groups stopped, else until the first ended."""
    records = [record for group in groups for record in group]
    if all(record.stopped for record in records):
        return [[float(record.distance[-1]) for record in group] for group in groups]
    end = min(float(record.time[-1]) for record in records)
    return [[float(np.interp(end, record.time, record.distance)) for record in group] for group in groups]


def values_of(records: Sequence[TestRecord], name: str) -> list[float]:
    """One measure of each test; NaN where it has none."""
    return [record.measures.get(name, math.nan) for record in records]


def measure(records: Sequence[TestRecord], name: str) -> Estimate:
    """Estimate of one measure; tests without it leave no mean."""
    return estimate(values_of(records, name))


SHARES = (0.5, 1.0, 1.5)  # shares of the predicted dead time, at which the track is run
LEAST_STEP = 2e-3  # between them at least [s]: less is not seen beside the scatter of the distance


def protection_of(case: Case) -> str | None:
    """Table of what protects the axles of this test, whose `delay` is the dead time; None: nothing of ours does."""
    name = "slide_protection" if case.brake is not None else "wheel_slip_control"
    table = getattr(case, name)
    return name if table is not None and table.is_ours else None


def later_protection(case: Case, dead_time: float) -> Case:
    """The same test with so much more dead time of the protection [s], a multiple of the sampling step."""
    name = protection_of(case)
    assert name is not None
    table = getattr(case, name)
    return case.model_copy(update={name: table.model_copy(update={"delay": table.delay + dead_time})})


def dead_times(case: Case, predicted: DeadTime | None) -> tuple[float, ...]:
    """Additional dead times at which to run the track [s], ascending, multiples of the sampling step."""
    if predicted is None or protection_of(case) is None:
        return ()
    step, reach = case.time.sampling_step, max(predicted.total, LEAST_STEP / SHARES[0])
    return tuple(sorted({max(1, round(share * reach / step)) * step for share in SHARES}))


def measured_dead_time(rig: Estimate, track: Mapping[float, Estimate]) -> Estimate:
    """Additional dead time [s] with which the track has the rig's mean number: its distance, or its dump cycles.

    By linear interpolation between two ensembles on track, by additional dead time [s], 0 among them; NaN where the rig's number
    is outside all of the track's.
    """
    found, slope = at_track_of(rig.mean, {delay: one.mean for delay, one in track.items()})
    if not math.isfinite(found):
        return Estimate(math.nan, math.nan, 0.0)
    delays = sorted(track)
    k = next((k for k, delay in enumerate(delays[1:]) if found <= delay), 0)
    low, high = delays[k], delays[k + 1]
    part = (found - low) / (high - low)
    errors = (rig.standard_error, (1.0 - part) * track[low].standard_error, part * track[high].standard_error)
    return Estimate(found, math.hypot(*errors) / abs(slope), min(rig.freedom, track[low].freedom, track[high].freedom))


Starting = Callable[[Case, int], Sequence[Case]]
"""Case, number -> so many cases that differ in their start alone, the case itself first."""


def start_name(name: str, number: int) -> str:
    """Name of the job of a variant from one of its starts, counted from 0."""
    return f"{name}, start {number + 1}"


def start_jobs(
    cases: Mapping[str, Case], make: Callable[[Case, int], Job], end: int, begin: int = 0, starting: Starting = starts
) -> Round:
    """A job for each variant and start, made of its case and number; `begin` of the `end` starts are done already."""
    return {
        start_name(name, k): make(one, k)
        for name, case in cases.items()
        for k, one in enumerate(starting(case, end))
        if k >= begin
    }


def started(done: Done, name: str, first: Sequence[Any] = ()) -> list[Any]:
    """What there is of a variant after its `first` starts, which other jobs had, up to the first one that is missing."""
    found = list(first)
    while (job := done.get(start_name(name, len(found)))) is not None:
        found.append(job)
    return found


def means(runs: Sequence[Mapping[str, float]], names: Sequence[str]) -> dict[str, float]:
    """Mean of each of these numbers over the runs of a variant, and its standard error as `NAME_standard_error`."""
    found: dict[str, float] = {}
    for name in names:
        one = estimate([run[name] for run in runs])
        found |= {name: one.mean, f"{name}_standard_error": one.standard_error}
    return found
