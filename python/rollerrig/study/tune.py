"""Gains and filters of the rig's controller tuned: tracking error against torque ripple, margins of the loop as constraints.

Case, free keys -> candidates -> margins of the linear loop -> runs of those that keep them, with the same draws
    -> [TuneStudy] -> front of candidates that none surpasses, compromise, its difference from the case as shipped; tuned.toml

Half of the candidates fill the ranges, the others lie about the front found so far. Whether the compromise is better than the
case as shipped is decided by draws that the choice has not seen.
"""

import math
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from operator import attrgetter
from typing import Annotated, Any

import numpy as np

from rollerrig.analysis.control_loop import creep_slope, loop_of, margins
from rollerrig.analysis.loop_stability import gain_limit, vehicle_plant
from rollerrig.cases import as_case
from rollerrig.common.arrays import Array
from rollerrig.common.formatting import number
from rollerrig.config import Case, ConfigError, ConfigProblem, Plan, plan_of_case
from rollerrig.config.errors import show_value
from rollerrig.config.validate.messages import validate
from rollerrig.plot.control import front as front_picture
from rollerrig.results.dataset import COMPLETED
from rollerrig.study.control import study_case
from rollerrig.study.ensemble import Estimate, check_ensemble, estimate, relative, start_jobs, start_name, started
from rollerrig.study.frame import Content, Outcome, Study
from rollerrig.study.jobs import Done, Progress, Round, job
from rollerrig.study.options import Option, Processes, command
from rollerrig.study.quantities import Numbers, Quantities, Quantity
from rollerrig.study.report import Picture, Section
from rollerrig.study.runs.control import run_variant
from rollerrig.study.runs.sweep import Axis, Points

TUNED = tuple(f"rig_control.{table}" for table in ("feedback", "estimator", "axle_torque", "drive_command"))
"""Tables that are the controller's own; others of [rig_control] are the rig."""
HIGHEST = 1e3  # factor on the gains up to which a margin is looked for


@dataclass(frozen=True)
class Point:
    """A candidate, or the case as shipped."""

    # at the free keys, in their units; None: the case leaves it to what follows from others
    values: Sequence[float | None]
    place: Sequence[float]  # in the unit cube of the ranges; empty of the case as shipped
    # factor on the gains from which vehicle and loop are unstable; 0: as it is, inf: not up to HIGHEST
    gain_margin: float
    phase_margin_deg: float  # of the feedback of one axle alone; inf: it does not cross over
    runs: Sequence[Mapping[str, Any]] = ()  # numbers of its runs, one of each draw

    def of(self, name: str) -> list[float]:
        """An error in each draw; NaN where the test ended early."""
        return [float(run[name]) if run["status"] in COMPLETED else math.nan for run in self.runs]


def not_dominated(errors: Array) -> list[int]:
    """Rows that no other row surpasses: at most as large in all columns, smaller in one; shape (point, objective)."""
    return [
        k for k, one in enumerate(errors) if not np.any(np.all(errors <= one, axis=1) & np.any(errors < one, axis=1))
    ]


def compromise(errors: Array) -> int:
    """Row nearest to the least of each column, in logarithms over their span; shape (point of the front, objective).

    M. Zeleny, Multiple Criteria Decision Making (1982).
    """
    logs = np.log(errors) - np.log(errors.min(axis=0))
    return int(np.argmin(np.linalg.norm(logs / np.maximum(logs.max(axis=0), 1e-12), axis=1)))


def free_axes(case: Case, free: Mapping[str, Any]) -> list[Axis]:
    """The free keys, dotted key -> least and most, as a sweep takes them; ConfigError: none of the controller's, or no range."""
    keys, varied, problems = list(free), [], []
    for key, ends in free.items():
        if not key.startswith(tuple(f"{table}." for table in TUNED)):
            problems.append(ConfigProblem(case.name, "free", show_value(key), f"allowed: keys of {', '.join(TUNED)}"))
        elif not isinstance(ends, list | tuple) or len(ends) != 2:
            problems.append(ConfigProblem(case.name, f"free.{key}", show_value(ends), "needed: [least, most]"))
        else:
            name = "_".join(key.split(".")[1:])
            varied.append({"key": key, "name": name, "least": ends[0], "most": ends[1]})
    if problems:
        raise ConfigError(problems)
    if not keys:
        raise ConfigError.of(case.name, "free", "{}", "needed: a key and its range")
    sampled = {"kind": "latin_hypercube", "samples": 2}
    raw = {"name": "tune", "case": case.name, "vary": varied, "measure": [], "design": sampled}
    try:
        plan, problems = validate(Plan, raw, case.name)
        if plan is None:
            raise ConfigError(problems)
        return Points(plan_of_case(plan, case, case.name)).axes
    except ConfigError as error:
        named = [re.sub(r"vary\[(\d+)\]", lambda at: f"free.{keys[int(at[1])]}", one.key) for one in error.problems]
        raise ConfigError([replace(one, key=key) for one, key in zip(error.problems, named, strict=True)]) from None


def values_at(axes: Sequence[Axis], place: Sequence[float]) -> list[float]:
    """Values at a place of the unit cube, of four digits; a positive range is divided by its logarithm."""
    found = []
    for axis, part in zip(axes, place, strict=True):
        assert axis.quantile is not None
        least, most = axis.quantile(np.array([0.0, 1.0])).tolist()
        value = least * (most / least) ** part if least > 0.0 else least + part * (most - least)
        found.append(min(max(float(f"{value:.4g}"), least), most))
    return found


def margins_of(case: Case, candidates: Mapping[str, Any], progress: Progress | None = None) -> dict[str, Any]:
    """Candidates, each with the gain margin of vehicle and sampled loop, rolling or sliding, and phase margin of one axle."""
    creep, vehicle = creep_slope(case), vehicle_plant(case)
    found: dict[str, Any] = {}
    for name, one in candidates.items():
        changed = case.with_changes(one["changes"])
        loops = [loop for slides in (False, True) if (loop := loop_of(changed, creep, sliding=slides)) is not None]
        phase = math.degrees(margins(loops[0]).phase)
        limits = np.nan_to_num([gain_limit(loop, vehicle, HIGHEST) for loop in loops], nan=math.inf)
        phase_margin = math.inf if math.isnan(phase) else phase
        found[name] = {**one, "gain_margin": float(limits.min()), "phase_margin_deg": phase_margin}
        if progress is not None:
            progress(len(found) / len(candidates), name)
    return found


FREE: Mapping[str, Any] = {
    "rig_control.feedback.bandwidth": (0.2, 12.0),
    "rig_control.estimator.bandwidth": (5.0, 80.0),
}
"""Sought unless others are given: dotted key -> ends of the range [Hz]."""
OBJECTIVES = {"tracking_rms": "tracking error", "ripple_nm": "torque ripple"}
SHIPPED = "shipped"
REACH = 0.1  # standard deviation of a candidate about a point of the front, over the range


@dataclass(frozen=True)
class Tuned:
    """Points by name, the front by rising tracking error, the compromise, its change from shipped on new draws."""

    points: dict[str, Point]
    front: list[str]
    chosen: str
    changes: dict[str, Estimate]


@dataclass(frozen=True)
class TuneStudy(Study[Tuned]):
    """Free keys of a case's controller, tried in `duration` [s] of its test."""

    case: Case
    free: Mapping[str, Any]
    duration: float
    draws: int
    candidates: int
    gain_margin: float
    phase_margin_deg: float
    seed: int

    command = "tune"
    heading = "{case.name}: controller of the roller drives tuned"
    writes = ("candidates.csv", "tuned.toml")
    round_ends = (0.05, 0.5, 0.55, 0.9, 1.0)
    assumes = (
        "Margins are those of the linear loop at the speed at which the test begins: the gain margin with the vehicle on its "
        "springs, the phase margin of one axle alone.",
        "A controller is tuned to one test: other rails, speeds and encoders may ask for other gains.",
    )

    def __post_init__(self) -> None:
        """Refuse with a ConfigError a controller without a linear loop, and keys and ranges that do not fit."""
        if loop_of(self.test, 1.0, sliding=False) is None:
            kinds = "an estimator other than exact, no [sensors.roller_torque], no rotors"
            raise ConfigError.of(self.case.name, "rig_control", "no linear loop", f"needed for the margins: {kinds}")
        check_ensemble(self.test)
        assert self.axes

    @cached_property
    def test(self) -> Case:
        """The case as it is run."""
        return study_case(self.case, self.duration)

    @cached_property
    def axes(self) -> list[Axis]:
        """The free keys with their ranges."""
        return free_axes(self.case, self.free)

    def rounds(self, done: Done) -> Iterator[Round]:
        from scipy.stats import qmc  # slow to load

        half, rng = self.candidates // 2, np.random.default_rng(self.seed)
        first = qmc.LatinHypercube(len(self.axes), seed=rng).random(self.candidates - half)
        own = [attrgetter(axis.key)(self.case) for axis in self.axes]  # None: it follows from others
        shipped = {"place": [], "changes": {}, "values": [None if value is None else float(value) for value in own]}
        yield {"margins 1": job(margins_of, self.test, {SHIPPED: shipped, **self._candidates(first, 0)})}
        yield self._runs(done["margins 1"])
        found = self._collected(done)
        parents = np.array([found.points[name].place for name in found.front if name != SHIPPED] or first)
        places = parents[rng.integers(len(parents), size=half)] + REACH * rng.normal(size=(half, len(self.axes)))
        yield {"margins 2": job(margins_of, self.test, self._candidates(np.clip(places, 0.0, 1.0), len(first)))}
        yield self._runs(done["margins 2"])
        if (chosen := self._collected(done).chosen) != SHIPPED:
            both = done["margins 1"] | done["margins 2"]
            yield self._runs({name: both[name] for name in (SHIPPED, chosen)}, self.draws)

    def _candidates(self, places: Array, begin: int) -> dict[str, Any]:
        """Candidates at places of the unit cube, shape (candidate, key)."""
        found = {}
        for k, place in enumerate(places.tolist(), begin + 1):
            values = values_at(self.axes, place)
            changes = {axis.key: axis.written(value) for axis, value in zip(self.axes, values, strict=True)}
            found[f"candidate {k}"] = {"place": place, "changes": changes, "values": values}
        return found

    def _runs(self, margins: Mapping[str, Any], begin: int = 0) -> Round:
        """As many runs as draws, from one on, of the case as shipped and of candidates that keep the margins."""
        cases = {
            name: self.test.with_changes(one["changes"])
            for name, one in margins.items()
            if name == SHIPPED or self._keeps_margins(one["gain_margin"], one["phase_margin_deg"])
        }
        return start_jobs(cases, lambda one, _: job(run_variant, one), begin + self.draws, begin)

    def _keeps_margins(self, gain: float, phase_deg: float) -> bool:
        return gain >= self.gain_margin and phase_deg >= self.phase_margin_deg

    def collect(self, done: Done) -> Tuned | None:
        return self._collected(done) if start_name(SHIPPED, self.draws - 1) in done else None

    def _collected(self, done: Done) -> Tuned:
        points, again = {}, {}
        for name, one in {**done["margins 1"], **done.get("margins 2", {})}.items():
            point = Point(one["values"], one["place"], one["gain_margin"], one["phase_margin_deg"])
            runs = started(done, name)
            points[name] = replace(point, runs=runs[: self.draws] if len(runs) >= self.draws else ())
            again[name] = replace(point, runs=runs[self.draws :])
        fair = [name for name, one in points.items() if not self._cause(one)]
        errors = {name: [estimate(points[name].of(of)).mean for of in OBJECTIVES] for name in fair}
        best = not_dominated(np.array(list(errors.values())))
        front = sorted((fair[k] for k in best), key=lambda name: errors[name])
        chosen = front[compromise(np.array([errors[name] for name in front]))] if front else SHIPPED
        new = again[chosen], again[SHIPPED]
        seen = chosen != SHIPPED and all(one.runs for one in new)
        changes = {of: relative(*(one.of(of) for one in new)) for of in OBJECTIVES} if seen else {}
        return Tuned(points, front, chosen, changes)

    def _cause(self, point: Point) -> str:
        """Why a point is not on offer; empty: it is."""
        if not self._keeps_margins(point.gain_margin, point.phase_margin_deg):
            return "margins"
        if not point.runs:
            return "not run"
        return "" if all(value > 0.0 for of in OBJECTIVES for value in point.of(of)) else "test ended early"

    def numbers(self, results: Tuned) -> dict[str, Any]:
        points: dict[str, dict[str, Any]] = {}
        for name, one in results.points.items():
            none = Estimate(math.nan, math.nan, 0.0)
            points[name] = {
                "values": dict(zip(self.free, one.values, strict=True)),
                "gain_margin": one.gain_margin,
                "phase_margin_deg": one.phase_margin_deg,
                "cause": self._cause(one),
                "on_front": name in results.front,
                **{of: (estimate(one.of(of)) if one.runs else none).as_dict() for of in OBJECTIVES},
            }
        return {
            "case": self.case.name,
            "duration_s": self.test.time.duration,
            "draws": self.draws,
            "gain_margin_demanded": self.gain_margin,
            "phase_margin_demanded_deg": self.phase_margin_deg,
            "units": {axis.key: axis.unit for axis in self.axes},
            "points": points,
            "compromise": results.chosen,
            "changes": {of: {**one.as_dict(), "outcome": outcome(one)} for of, one in results.changes.items()},
        }

    def summary(self, results: Tuned, numbers: Numbers) -> list[str]:
        causes = [one["cause"] for name, one in numbers["points"].items() if name != SHIPPED]
        tried = (
            f"{len(causes)} candidates: {causes.count('margins')} without the margins, {causes.count('test ended early')} whose "
            f"test ended early, {len(results.front)} points on the front."
        )
        if results.chosen == SHIPPED:
            return [tried, "No candidate is a better compromise than the case as shipped."]
        return [tried, f"Best compromise: {results.chosen}, {self._values(results)}.", *self._changes(numbers)]

    def _values(self, results: Tuned) -> str:
        pairs = zip(self.axes, results.points[results.chosen].values, strict=True)
        return ", ".join(f"{axis.key} = {value:g} {axis.unit}".removesuffix(" 1") for axis, value in pairs)

    def _changes(self, numbers: Numbers) -> list[str]:
        """What the compromise changes, as far as its interval is known."""
        told = self.quantities["changes.*.mean"].told
        return [
            f"{OBJECTIVES[of]} over the shipped one, less 1: {told(one)} on {self.draws} new draws: {one['outcome']}."
            for of, one in numbers["changes"].items()
            if None not in one.values()
        ]

    def files(self, results: Tuned, numbers: Numbers) -> Mapping[str, Content]:
        found: dict[str, Content] = {"candidates.csv": self._rows(numbers)}
        if results.chosen == SHIPPED:
            return found
        chosen = results.points[results.chosen]
        head = (
            f"{results.chosen} of `rollerrig tune {self.case.name}`, seed {self.seed}: the best compromise of "
            f"{len(results.points) - 1} in {self.test.time.duration:g} s of the test, {self.draws} draws.",
            f"Gain margin {number(chosen.gain_margin, 3)}, at least {self.gain_margin:g}; phase margin "
            f"{number(chosen.phase_margin_deg, 3)} degrees, at least {self.phase_margin_deg:g}.",
            f"{self._values(results)}; all else is as in the case.",
            *self._changes(numbers),
        )
        pairs = zip(self.axes, chosen.values, strict=True)
        case = self.case.with_changes({axis.key: axis.written(value) for axis, value in pairs})
        return {**found, "tuned.toml": "\n".join([*(f"# {line}" for line in head), "", case.to_short_toml()])}

    def _rows(self, numbers: Numbers) -> list[list[object]]:
        """A row per point, header first."""
        keys = [f"{axis.key} [{axis.unit}]".removesuffix(" [1]") for axis in self.axes]
        margins, ends, more = ("gain_margin", "phase_margin_deg"), ("mean", "low", "high"), ("cause", "on_front")
        errors = [f"{of}_{end}" for of in OBJECTIVES for end in ends]
        rows: list[list[object]] = [["candidate", *keys, *margins, *errors, *more]]
        for name, one in numbers["points"].items():
            found = [one[of][end] for of in OBJECTIVES for end in ends]
            own, last = ([one[key] for key in names] for names in (margins, more))
            rows.append([name, *one["values"].values(), *own, *found, *last])
        return rows

    def sections(self, results: Tuned, numbers: Numbers) -> list[Section]:
        points = numbers["points"]
        shown = {name: one for name, one in points.items() if one["cause"] == "" or name == SHIPPED}
        caption = (
            f"Torque ripple over tracking error, means of {self.draws} draws with intervals of 95 %; line: the front, whose "
            "points none surpasses in both. Candidates without the margins were not run."
        )
        picture = Picture("front", front_picture(shown, results.front, SHIPPED, results.chosen), caption)
        own = Quantities(self.quantities, [Quantity(one.key, one.key, one.unit, one.key, 3) for one in self.axes])
        errors = [f"points.*.{of}.mean" for of in OBJECTIVES]
        names = [*self.free, "gain_margin", "phase_margin_deg", *errors, "cause", "on_front"]
        table = own.table(
            {k: {**one, **one["values"]} for k, one in points.items()}, names, "All candidates.", "candidate"
        )
        return [Section("Tracking error against torque ripple", [picture, table])]


def outcome(change: Estimate) -> str:
    """Better or worse than shipped, where the whole interval says so."""
    ends = change.interval
    return "better" if ends.high < 0.0 else "worse" if ends.low > 0.0 else "not decided"


@command
def tune(
    case: Case | str,
    free: Annotated[
        Mapping[str, object] | None,
        Option(meaning="what is sought: KEY=[LEAST,MOST], a key of [rig_control] and its range; again for more."),
    ] = None,
    *,
    duration: Annotated[float, Option(least=1.0, most=600.0)] = 4.0,
    draws: Annotated[int, Option(least=2, most=100)] = 3,
    candidates: Annotated[int, Option(least=2, most=10000)] = 24,
    gain_margin: Annotated[float, Option(least=1.0, most=100.0)] = 2.0,
    phase_margin_deg: Annotated[float, Option(least=0.0, most=180.0)] = 45.0,
    seed: Annotated[int, Option(least=0)] = 1,
    processes: Processes = 1,
    progress: Progress | None = None,
) -> Outcome[Tuned]:
    """Gains and filters of the rig's controller: tracking error against torque ripple, with margins of the loop.

    Args:
        case: case on rollers with [rig_control]: a name of the catalogue or a TOML file.
        free: what is sought, dotted key of [rig_control] -> least and most; None: bandwidths of feedback and estimator.
        duration: length of each run [s].
        draws: tests of each candidate, drawn by [ensemble] alike for all.
        candidates: half of them fill the ranges, the others lie about the front found so far.
        gain_margin: least factor on the gains at which the loop with the vehicle becomes unstable.
        phase_margin_deg: least phase margin of one axle's feedback [deg].
        seed: of the candidates.
        processes: runs at a time; more than 1 asks a script for `if __name__ == "__main__":`.
        progress: called with the fraction done and a short text.

    Raises:
        ConfigError: the case has no controller with a linear loop, or a key or range does not fit.
        StartError: no rolling equilibrium was found.
    """
    wanted = FREE if free is None else free
    study = TuneStudy(as_case(case), wanted, duration, draws, candidates, gain_margin, phase_margin_deg, seed)
    return study.outcome(processes, progress)
