"""What is run and assessed in a test programme: a case per stop and its dry reference, a record per test, criteria.

Case of a rig with brake and slide protection, Programme -> [stop_case, dry_case] -> [stop_record] -> StopTests of track and rig
    -> [assessments] -> value with interval, limit, outcome, reasons -> [outcome_of] -> of each stop

A criterion is met where the whole interval of its mean is within the limit, and, where each test must keep it, each test too.
Nothing is decided, neither met nor not met, from a bad run: fewer tests than asked, a test that ended early, lost contact or did
not stop, wheels that hardly passed the peak of the creep curve, an open energy balance, starts that do not differ, a test with
finer steps that is none, a dry reference that is none, and on the rig a drive at its limit or a contact force that is not the
virtual one.
"""

import math
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np
import xarray as xr

from rollerrig.analysis import slide_statistics as slides
from rollerrig.analysis.slide_statistics import SLIP_EDGES, TestRecord
from rollerrig.analysis.virtual_rail import available_adhesion, patch_of
from rollerrig.assembly.model import assemble
from rollerrig.cases import wheelsets
from rollerrig.common.formatting import percent
from rollerrig.config import CRITERIA, Case, ConfigError, ConfigProblem, Limit, Piece, Programme
from rollerrig.config.schema.programme import BrakedRun, FlatWear, PatchStop
from rollerrig.config.write.toml import plain
from rollerrig.results.run_info import RunInfo
from rollerrig.study.assessment import NOT_DECIDED, Outcome, outcome
from rollerrig.study.ensemble import Estimate, check_ensemble, estimate, stepped, values_of
from rollerrig.study.jobs import Progress, whole_run
from rollerrig.study.runs.adhesion import GATES, assessment_rows, is_whole, track_case

RISE = 0.1  # in which the demand rises; the brake is slower anyhow [s]


def check_case(case: Case, programme: Programme) -> None:
    """Refuse with a ConfigError a case that has nothing to test, and stops that this vehicle cannot do."""
    track_case(case)
    for name in ("brake", "slide_protection"):
        if getattr(case, name) is None:
            needed = f"needed: [{name}]; a programme for wheel slide protection tests what it does to a braked axle"
            raise ConfigError.of(case.name, name, "missing", needed)
    train = case.train.axles
    along = train.positions if train else sorted(body.position[0] for body in wheelsets(case))
    least = min((b - a for a, b in zip(along, along[1:], strict=False)), default=0.0)
    for stop in programme.stop:
        if not stop.speed > case.motion.stop_speed:
            allowed = f"allowed: more than motion.stop_speed of {case.name}, {3.6 * case.motion.stop_speed:g} km/h"
            problem = ConfigProblem(programme.name, f"stop.{stop.name}.speed", f"{3.6 * stop.speed:g} km/h", allowed)
            raise ConfigError([problem])
        if isinstance(stop, PatchStop) and not stop.length < least:
            allowed = f"allowed: less than the least spacing of the axles, {least:g} m, so that one axle at a time is on a patch"
            raise ConfigError.of(programme.name, f"stop.{stop.name}.length", f"{stop.length:g}", allowed)
        check_ensemble(stop_case(case, programme, stop))


def stop_case(case: Case, programme: Programme, stop: BrakedRun) -> Case:
    """A stop of the programme on the rig: the case with this speed, rail and demand, all else its own.

    The demand begins at the start: the distance run is that since the demand. What cannot be run so is a ConfigError.
    """
    rail = _plain(stop.rail)
    pieces = [_plain(piece) for piece in stop.pieces()]
    return _changed(case, programme, stop, f"{case.name}_{stop.name}", rail, pieces)


def dry_case(case: Case, programme: Programme, stop: BrakedRun) -> Case:
    """The same stop on a dry rail."""
    return _changed(case, programme, stop, f"{case.name}_{stop.name}_dry", "dry", [])


def dry_name(case: Case, stop: BrakedRun) -> str:
    """The dry stops of one speed and demand are one."""
    return f"dry {3.6 * stop.speed:.6g} at {1e-5 * _demanded(case, stop):.6g} bar"


def _demanded(case: Case, stop: BrakedRun) -> float:
    """Cylinder pressure over the ambient [Pa]."""
    assert case.brake is not None
    return stop.pressure if stop.pressure is not None else max(pressure for _, pressure in case.brake.demand)


def _changed(
    case: Case, programme: Programme, stop: BrakedRun, name: str, rail: Any, pieces: Sequence[Mapping[str, Any]]
) -> Case:
    blend = getattr(stop, "blend", 0.0) if pieces else 0.0
    changes: dict[str, object] = {
        "motion.speed": f"{stop.speed!r} m/s",
        "brake.demand": [[0.0, 0.0], [RISE, _demanded(case, stop)]],
        "train.gradient": stop.falls,
        "time.duration": stop.duration,
    }
    if case.adhesion is None:
        changes["adhesion"] = {"rail": rail, "piece": list(pieces), "blend": blend}
    else:
        changes |= {"adhesion.piece": list(pieces), "adhesion.rail": rail, "adhesion.blend": blend}
    try:
        changed = case.with_changes(changes)
    except ConfigError as error:
        raise ConfigError(
            replace(problem, file=programme.name, key=f"stop.{stop.name}: {problem.key}") for problem in error.problems
        ) from None
    return changed.model_copy(update={"name": name[:60]})


def _plain(table: Any) -> Any:
    """As a file would give it."""
    found = plain(table.model_dump(exclude_none=True))
    if isinstance(table, Piece):
        found["rail"] = _plain(table.rail)
    return found


LARGE_SLIP = 0.30  # beyond it slip is large [-]

SIGNALS, SIGNAL_STEP = ("train_speed", "axle_speed", "cylinder_pressure"), 0.05
"""Signals that are kept, and their step [s]."""


@dataclass(frozen=True)
class StopRecord:
    """What is kept of a test: record, SIGNALS over time (of first tests alone), processor time [s]."""

    test: TestRecord
    signals: xr.Dataset | None
    seconds: float


def stop_record(case: Case, flat: FlatWear, keep: bool, progress: Progress | None = None) -> StopRecord:
    """Run a test of a stop and keep its record: a job; with numbers of the estimate of flats, and its signals if to `keep`."""
    begun = time.process_time()
    run = whole_run(case, progress=progress)
    record = slides.test_record(run, case)
    own = {
        "large_slip_share": float(record.slip_shares[np.flatnonzero(SLIP_EDGES[:-1] > LARGE_SLIP - 1e-9)].sum()),
        "adhesion_utilisation": adhesion_utilisation(run, case),
        "flat_length_m": slides.longest_flat(slides.under_test(run), flat.wear, flat.width),
        "build_up_s": build_up(run),
    }
    test = replace(record, measures={**record.measures, **own})
    every = max(1, round(SIGNAL_STEP / float(run["time"][1] - run["time"][0]))) if run.sizes["time"] > 1 else 1
    kept = run[list(SIGNALS)].isel(time=slice(None, None, every)) if keep else None
    return StopRecord(test, kept, time.process_time() - begun)


def adhesion_utilisation(run: xr.Dataset, case: Case) -> float:
    """Sum of the creep forces over the largest that the rail gives at any slip [-].

    Of all braked axles that are bodies, and all instants. The rail is that under each axle, which nothing has cleaned yet: where
    sliding cleans it, the value may pass 1. NaN where no axle is braked.
    """
    if case.adhesion is None:
        return math.nan
    places = {body.name: body.position[0] for body in RunInfo.of(run).wheelsets}
    way, clock, speed = (run[name].to_numpy() for name in ("train_distance", "time", "train_speed"))
    patch, used, offered = patch_of(assemble(case)), 0.0, 0.0
    for axle, place in places.items():
        one = run[["brake_torque", "creep_force"]].sel(axle=axle)
        at = clock if case.adhesion.over_time else way + place
        braked = (abs(one["brake_torque"]).to_numpy() > 1.0) & (speed > slides.LEAST_SPEED)
        if braked.any():
            used += float(np.abs(one["creep_force"].to_numpy()[braked]).sum())
            offered += float(available_adhesion(case, patch, at[braked], speed[braked]).sum()) * slides.axle_load(run)
    return used / offered if offered > 0.0 else math.nan


def build_up(run: xr.Dataset) -> float:
    """Equivalent time of the brake's build-up in a stop without a slide [s]: without any brake, and then all of it at once.

    The integral of 1 - p / p_max over time, p the mean pressure of the cylinders.
    """
    pressure = run["cylinder_pressure"].mean("axle").to_numpy()
    full = float(pressure.max(initial=0.0))
    return float(np.trapezoid(1.0 - pressure / full, run["time"].to_numpy())) if full > 0.0 else math.nan


Support = Literal["track", "rig"]
SUPPORTS: tuple[Support, ...] = ("track", "rig")

POWER_LIMITED = 0.01
"""Part of the time at the power limit of a roller drive from which the rig is no track, as at its torque limit [-]."""

OVER_DRY = ("increase_over_dry", "k_wet")


@dataclass(frozen=True)
class StopTests:
    """The tests of one stop of the programme on one support, of the rig's case."""

    stop: BrakedRun
    support: Support
    case: Case
    asked: int  # number of tests without which nothing is decided
    tests: Sequence[TestRecord]
    dry: TestRecord | None  # the same stop on a dry rail; None: not made
    fine: Sequence[TestRecord] = ()  # the first of the tests again with finer steps and samples

    def values(self, name: str, tests: Sequence[TestRecord] | None = None) -> list[float]:
        """A measure of all tests; NaN where there is none. What is over the dry stop leaves out the way of its build-up."""
        tests = self.tests if tests is None else tests
        if name in OVER_DRY:
            dry = {} if self.dry is None else self.dry.measures
            way = self.stop.speed * dry.get("build_up_s", math.nan)
            ratios = [
                (one.measures["distance_m"] - way) / (dry["distance_m"] - way) if dry else math.nan for one in tests
            ]
            return [ratio - 1.0 if name == "increase_over_dry" else 1.0 / ratio for ratio in ratios]
        return values_of(tests, name)

    def estimate(self, name: str) -> Estimate:
        """The same as a mean, in whose interval is what finer steps change."""
        found = estimate(self.values(name))
        count = min(len(self.fine), len(self.tests))
        if not count:
            return found
        coarse, close = (estimate(self.values(name, one[:count])) for one in (self.tests, self.fine))
        return stepped(found, coarse, close)


@dataclass(frozen=True)
class Assessment:
    """A criterion of a stop on one support: its limit, mean and worst of all tests in its SI unit, why nothing is decided."""

    stop: str
    support: Support
    limit: Limit
    mean: Estimate
    worst: float
    reasons: tuple[str, ...]

    @property
    def outcome(self) -> Outcome:
        """'met', 'not met' or 'not decided'."""
        if self.reasons or not (math.isfinite(self.mean.mean) and math.isfinite(self.worst)):
            return NOT_DECIDED
        criterion = CRITERIA[self.limit.criterion]
        low, high = (self.limit.value, math.inf) if criterion.least else (-math.inf, self.limit.value)
        if criterion.every and not low <= self.worst <= high:
            return "not met"
        return outcome(self.mean.interval, low, high)

    @property
    def why(self) -> str:
        """Why nothing is decided; "" where something is."""
        if self.outcome != NOT_DECIDED:
            return ""
        return "; ".join(self.reasons) or "the limit lies within the interval"


def assessments(programme: Programme, found: StopTests, other: StopTests) -> list[Assessment]:
    """All criteria of a stop on one support; `other` are the tests on the other one."""
    common = (*faults(found), *(rig_faults(found, other) if found.support == "rig" else ()))
    assessed = []
    for limit in (limit for limit in programme.limit if limit.holds_for(found.stop)):
        criterion = CRITERIA[limit.criterion]
        name, factor = criterion.measure, criterion.factor
        values = [factor * value for value in found.values(name)]
        own = tuple(dry_faults(found)) if name in OVER_DRY else ()
        worst = (min if criterion.least else max)(values) if np.isfinite(values).all() else math.nan
        if not math.isfinite(worst):
            own = (*own, "not every test has such a number")
        mean = found.estimate(name).times(factor)
        assessed.append(Assessment(found.stop.name, found.support, limit, mean, worst, (*common, *own)))
    return assessed


def faults(found: StopTests, *, must_slide: bool = True) -> Iterator[str]:
    """Why these tests decide nothing, whatever the criterion; `must_slide`: also that they test no slide protection."""
    tests, count = found.tests, len(found.tests)
    if count < found.asked:
        yield f"{count} of {found.asked} tests were made"
    for key, (text, _, has) in GATES.items():
        bad = [one for one in tests if not has(one, tests)]
        if bad and (must_slide or key != "slid"):
            why = f", one ended early: {bad[0].message}" if key == "ended" else ""
            yield f"{count - len(bad)} of {count} tests {text}{why}"
    rolling = sum(one.completed and not one.stopped for one in tests)
    if found.stop.stops and rolling:
        yield f"in {rolling} of {count} tests the train had not stopped after {found.stop.duration:g} s"
    bad = [one for one in found.fine if not (is_whole(one) and (one.stopped or not found.stop.stops))]
    if bad:
        faulty = "ended early, did not stop, lost contact or have an open energy balance"
        yield f"{len(bad)} of {len(found.fine)} tests with finer steps {faulty}"


def rig_faults(rig: StopTests, track: StopTests) -> Iterator[str]:
    """Why the rig's tests say nothing about the vehicle: the exclusion criteria of the rig itself."""
    if not (rig.tests and track.tests):
        return
    rows = assessment_rows(rig.case, (track.tests, rig.tests), (track.fine, rig.fine))
    own = (*SUPPORTS, "fine")  # those say it of their own tests
    gates = [row for row in rows if row.gate and row.key.partition("_")[0] not in own]
    kept = [row.outcome == "met" or (row.low <= 0.0 and row.value.interval.high <= row.high) for row in gates]
    shut = [row.finding for row, is_open in zip(gates, kept, strict=True) if not is_open]
    power = max(one.measures.get("drive_power_limited_s", 0.0) / one.measures["duration_s"] for one in rig.tests)
    if not power <= POWER_LIMITED:
        shut.append(
            f"time at a roller drive's power limit up to {percent(power)}, target at most {percent(POWER_LIMITED)}"
        )
    if shut:
        yield f"the rig is no track here: {'; '.join(shut)}"


def dry_faults(found: StopTests) -> Iterator[str]:
    """Why the dry stop is no reference."""
    if found.dry is None:
        yield "the dry reference was not made"
        return
    dry = found.dry.measures
    if not (found.dry.completed and found.dry.stopped):
        yield f"the dry reference did not come to a stop: {found.dry.message}"
    if dry.get("beyond_peak_s", math.nan) != 0.0:
        yield "in the dry reference an axle passed the peak of the creep curve"
    if dry.get("dump_cycles", math.nan) != 0.0:
        yield "in the dry reference the protection acted"
    shortest = min((one.measures["distance_m"] for one in found.tests), default=math.nan)
    if shortest < dry["distance_m"]:
        yield "a test stopped in less than the dry distance"
