"""Ensembles: the same test from slightly different starts, and what a limit cycle's phase leaves certain of its numbers.

Case -> [starts] -> cases that begin a little faster or slower -> TestRecords -> [Estimate] -> mean, standard error, interval

Slide protection and wheel-slip control switch on small differences: a difference that is not larger than its interval means
nothing. Whoever starts a little faster switches one sample earlier or later somewhere, and after some cycles nothing of the
phase is left: the numbers of two such tests are independent, their means are those of the test as it is.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import stdtrit

from rollerrig.analysis.equivalent_dead_time import DeadTime, at_track_of
from rollerrig.analysis.slide_statistics import TestRecord, test_record
from rollerrig.common.formatting import number
from rollerrig.config import Case
from rollerrig.study.assessment import Interval
from rollerrig.study.jobs import Progress, whole_run

SPEED = 3e-3
"""The start is faster or slower by up to this [m/s]: 0.01 % of 120 km/h."""

SEED = 20260713
CONFIDENCE = 0.95


def starts(case: Case, count: int) -> list[Case]:
    """The test as it is and count - 1 others from speeds that differ by up to SPEED, the same ones for every case.

    Speeds are those of a fixed seed, the first of a longer ensemble those of a shorter one.
    """
    shifts = np.random.default_rng(SEED).uniform(-SPEED, SPEED, max(0, count - 1))
    return [case, *(_at_speed(case, case.motion.speed + shift) for shift in shifts.tolist())]


def _at_speed(case: Case, speed: float) -> Case:
    return case.model_copy(update={"motion": case.motion.model_copy(update={"speed": abs(speed)})})


def recorded(case: Case, progress: Progress | None = None) -> TestRecord:
    """Run a test and keep its record: a job.

    Raises:
        KeyboardInterrupt: Ctrl-C cut it short.
    """
    return test_record(whole_run(case, progress=progress), case)


@dataclass(frozen=True)
class Estimate:
    """A number of an ensemble.

    Attributes:
        mean: over the tests; NaN where one of them has no such number.
        standard_error: of that mean; NaN for a single test.
        freedom: degrees of freedom of the standard error.
    """

    mean: float
    standard_error: float
    freedom: float

    @property
    def interval(self) -> Interval:
        """In which the mean of very many tests lies with CONFIDENCE, by Student's distribution."""
        if not (self.freedom > 0.0 and math.isfinite(self.standard_error)):
            return Interval(-math.inf, math.inf)
        reach = float(stdtrit(self.freedom, 0.5 + 0.5 * CONFIDENCE)) * self.standard_error
        return Interval(self.mean - reach, self.mean + reach)

    def as_dict(self) -> dict[str, float]:
        """Dictionary for summary.json."""
        return {"mean": self.mean, "standard_error": self.standard_error}


def estimate(values: Sequence[float]) -> Estimate:
    """Mean and standard error s / sqrt(n) of independent tests, s with n - 1."""
    count = len(values)
    spread = float(np.std(values, ddof=1)) if count > 1 else math.nan
    return Estimate(float(np.mean(values)), spread / math.sqrt(count) if count else math.nan, count - 1.0)


def with_error(one: Mapping[str, float | None], factor: float = 1.0, digits: int = 4, error_digits: int = 2) -> str:
    """A mean of `as_dict` and its standard error as tables show them, times a factor; a dash where there is none."""
    mean, error = one["mean"], one["standard_error"]
    if mean is None or math.isnan(mean):
        return "–"
    known = error is not None and not math.isnan(error)
    return number(factor * mean, digits) + (f" ± {number(factor * (error or 0.0), error_digits)}" if known else "")


def difference(a: Estimate, b: Estimate) -> Estimate:
    """A - b of two ensembles, degrees of freedom by Welch and Satterthwaite."""
    return _combined(a.mean - b.mean, (a.standard_error, a.freedom), (b.standard_error, b.freedom))


def relative(a: Estimate, b: Estimate) -> Estimate:
    """A / b - 1 of two ensembles, to first order in their errors; infinite where b alone is zero, NaN where both are."""
    if not b.mean:
        if not a.mean:
            return Estimate(math.nan, math.nan, 0.0)
        above = a.interval.low > 0.0 or a.interval.high < 0.0
        return Estimate(math.copysign(math.inf, a.mean), 0.0 if above else math.nan, math.inf)
    errors = (a.standard_error / abs(b.mean), a.freedom), (abs(a.mean) * b.standard_error / b.mean**2, b.freedom)
    return _combined(a.mean / b.mean - 1.0, *errors)


def _combined(mean: float, *errors: tuple[float, float]) -> Estimate:
    variance = sum(error**2 for error, _ in errors)
    parts = sum(error**4 / freedom for error, freedom in errors if freedom > 0.0)
    return Estimate(mean, math.sqrt(variance), variance**2 / parts if parts > 0.0 else sum(f for _, f in errors))


def distances(groups: Sequence[Sequence[TestRecord]]) -> list[list[float]]:
    """Distance of the train in each test [m]: to its stop where all tests of all groups stopped, else until the first ended."""
    records = [record for group in groups for record in group]
    if all(record.stopped for record in records):
        return [[float(record.distance[-1]) for record in group] for group in groups]
    end = min(float(record.time[-1]) for record in records)
    return [[float(np.interp(end, record.time, record.distance)) for record in group] for group in groups]


def measure(records: Sequence[TestRecord], name: str) -> Estimate:
    """Estimate of one measure; tests without it leave no mean."""
    return estimate([record.measures.get(name, math.nan) for record in records])


SHARES = (0.5, 1.0, 1.5)
"""Shares of the predicted dead time, at which the track is run."""

LEAST_STEP = 2e-3
"""Between them at least [s]: less is not seen beside the scatter of the distance."""


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

    Args:
        rig: that number of the rig.
        track: additional dead time [s] -> the same on track, 0 among them.

    Returns:
        By linear interpolation between two ensembles; NaN where the rig's number is outside all of the track's.
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
