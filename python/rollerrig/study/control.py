"""Which controller of the roller drives tolerates what: one test under many variants, and the limit each exceeds first.

Case -> families of variants -> [ControlStudy] -> tracking and ripple of each run -> where each fails, ranking
     -> lightly excited runs over the gains -> growth, beside the eigenvalues of the linear loop

Tracking is the wheel's speed less the virtual wheel's, over the train's speed (docs/theory/rig_control.md).
"""

import itertools
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Annotated, Any

import numpy as np
import xarray as xr

from rollerrig.cases import as_case, rig_of
from rollerrig.common.formatting import number, percent
from rollerrig.config import Case, ConfigError, ConfigProblem
from rollerrig.config.errors import nearest, one_of
from rollerrig.plot import control as figures
from rollerrig.simulation.controllers import users_controllers
from rollerrig.study.frame import Outcome, Study
from rollerrig.study.jobs import Done, Progress, Round, job
from rollerrig.study.options import Option, Processes, command
from rollerrig.study.quantities import Numbers, Quantities
from rollerrig.study.report import Block, Picture, Section, Table, Text
from rollerrig.study.runs import control as runs
from rollerrig.study.runs.adhesion import track_case
from rollerrig.study.runs.control import FAMILIES, MEASURED, RIPPLE_LIMIT, TRACKING_LIMIT, Family, Result, run_variant

QUANTITIES = Quantities("control")


REFERENCE_COLUMNS = ("status", "tracking_rms", "tracking_largest", "real_sliding_largest_mps", "roller_torque_largest_nm",
                     "ripple_nm", "distance_relative", "dump_cycles", "air_litres")  # fmt: skip


@dataclass(frozen=True)
class Failure:
    """A part of a curve in which every value tried fails of one cause."""

    cause: str  # as of Result
    # begin, end: of the part, ascending; where a value without a failure is next to it, interpolated to where tracking or
    # ripple passes its limit; NaN: it goes on to the end of the values tried
    begin: float
    end: float
    largest: float  # tracking RMS [-] or ripple [N m], the largest there; NaN where the tests ended early
    largest_at: float  # value that has it, or whose test ended first


@dataclass(frozen=True)
class Rank:
    """One curve in the order of how badly it fares: results along the axis, that of most severity, parts in which it fails."""

    family: Family
    points: list[Result]
    worst: Result
    failures: list[Failure]


def failures(family: Family, points: Sequence[Result]) -> list[Failure]:
    """All parts of a curve that fail, its points in the order of the axis: a curve may pass again beyond one."""
    found = []
    for cause, group in itertools.groupby(enumerate(points), key=lambda place: place[1].cause):
        if cause:
            places = list(group)
            (low, first), (high, last) = places[0], places[-1]
            worst = max((one for _, one in places), key=lambda r: r.severity)
            largest = float(worst.numbers[MEASURED[cause][0]]) if cause in MEASURED else math.nan
            begin = _border(family, first, points[low - 1]) if low > 0 else math.nan
            end = _border(family, last, points[high + 1]) if high + 1 < len(points) else math.nan
            found.append(Failure(cause, begin, end, largest, worst.value))
    return found


def _border(family: Family, bad: Result, other: Result) -> float:
    """Where the failure begins, in the logarithm of the error; the value itself where the neighbour fails too, or tests end."""
    if other.cause or bad.cause not in MEASURED:
        return bad.value
    key, limit = MEASURED[bad.cause]
    low, high = (math.log(r.numbers[key]) for r in (other, bad))
    a, b = (math.log(r.value) if family.scale == "log" else r.value for r in (other, bad))
    value = a + (math.log(limit) - low) / (high - low) * (b - a)
    return math.exp(value) if family.scale == "log" else value


def curves_of(family: Family, results: Sequence[Result]) -> dict[str, list[Result]]:
    """Curves of a family -> their results along the axis."""
    mine = sorted((r for r in results if r.family == family.name), key=lambda r: r.value)
    labels = dict.fromkeys(r.curve for r in results if r.family == family.name)
    return {label: [r for r in mine if r.curve == label] for label in labels}


def ranking(families: Sequence[Family], results: Sequence[Result]) -> list[Rank]:
    """All curves, the most severe result within the range tried first."""
    ranks = [
        Rank(family, points, max(points, key=lambda r: r.severity), failures(family, points))
        for family in families
        for points in curves_of(family, results).values()
    ]
    return sorted(ranks, key=lambda rank: rank.worst.severity, reverse=True)


def failures_text(rank: Rank) -> str:
    """All parts of a curve that fail, from where to where ('…': the end of the values tried), and the largest error there."""
    known = {"tracking": runs.TRACKING_CRITERION, "ripple": runs.RIPPLE_CRITERION}
    text, parts = rank.family.text, []
    for one in rank.failures:
        cause = known.get(one.cause, f"{one.cause.replace('_', ' ')}, test ends early,")
        begin, end = ("…" if math.isnan(value) else text(value) for value in (one.begin, one.end))
        scale, unit = (100.0, "%") if one.cause == "tracking" else (1.0, "N m")
        largest = f" (largest {number(scale * one.largest, 3)} {unit} at {text(one.largest_at)})"
        parts.append(f"{cause} from {begin} to {end}{'' if math.isnan(one.largest) else largest}")
    return " and ".join(parts)


def ranking_table(case: Case, ranked: Sequence[Rank]) -> Table:
    """Where every curve fails, and its worst run."""
    rows = []
    for rank in ranked:
        worst, family = rank.worst, rank.family
        base = family.base(case)
        shipped = "–" if base is None else family.text(base)
        cells = [QUANTITIES[name].cell(worst.numbers[name]) for name in ("tracking_rms", "ripple_nm")]
        error = cells[0] if worst.completed else "ended early"
        fails = failures_text(rank) or "no failure"
        rows.append([family.title, worst.curve, fails, shipped, family.text(worst.value), error, cells[1]])
    header = ("varied", "curve", "fails", "shipped", "worst at", "tracking RMS [%]", "ripple [N m]")
    return Table(header, rows, "every curve, the worst first; …: to the end of the values tried")


def family_picture(case: Case, family: Family, results: Sequence[Result]) -> Picture:
    """Errors over the axis of a family, a line per curve."""
    curves = {}
    for label, points in curves_of(family, results).items():
        both = ("tracking_rms", "ripple_nm")
        curves[label] = np.array(
            [(p.value, *(p.numbers[k] if p.completed else math.nan for k in both)) for p in points]
        )
    limits = (TRACKING_LIMIT, RIPPLE_LIMIT)
    picture = figures.over_parameter(curves, family.axis, family.scale, family.base(case), limits)
    caption = (
        f"Dashed: limits of failure, {100 * TRACKING_LIMIT:g} % and {RIPPLE_LIMIT:g} N m; dotted: the case as shipped."
    )
    return Picture(family.name, picture, f"{family.title}. {caption}")


def loop_blocks(loop: Numbers, points: list[dict[str, float]]) -> list[Block]:
    """Margins and limits of the gains, and figure, of the report."""
    users = loop["users"] or {}
    names = [q.key for q in QUANTITIES.below("loop") if q.label and (users or "users" not in q.key)]
    title = "The feedback in closed form, and from which factor on its gains on it is unstable."
    table = QUANTITIES.list_table({"": {**loop, **users}}, names, title)
    picture = figures.loop_growth({key: [point[key] for point in points] for key in points[0]})
    caption = (
        "Growth rate and frequency of the least damped motion above 10 Hz over the gains: computed with and without the vehicle, "
        f"and measured in lightly excited runs on a dry rail. A failure is the size alone: {runs.RIPPLE_CRITERION}."
    )
    cause = users.get("no_loop")
    told = [Text(f"The loop that the user's controller closes has no growth rate: {cause}.")] if cause else []
    return [table, *told, Picture("loop_growth", picture, caption)]


@dataclass(frozen=True)
class Found:
    """Results of references and families, courses over time by label, points of the loop."""

    references: list[Result]
    results: list[Result]
    courses: dict[str, xr.Dataset]
    loop: list[dict[str, float]]
    users: dict[str, Any] | None  # the point of a user's controller


@dataclass(frozen=True)
class ControlStudy(Study[Found]):
    """One test, of `study_case`, under many variants of the controller; attributes as the arguments of `rollerrig.control`."""

    case: Case
    families: tuple[str, ...] = ()
    user: str | None = None
    loop: bool = True

    command = "control"
    heading = "{case.name}: controllers of the roller drives compared"
    writes = ("variants.csv", "loop.csv")
    irrelevant = ("description", "families", "loop")
    round_ends = (0.98, 1.0)
    leaves_out = (
        "One test and one course of the slide protection, whose valves switch on small differences: errors of neighbouring "
        "values scatter by some tenths. Each variant changes one thing.",
    )

    def __post_init__(self) -> None:
        """Refuse with a ConfigError an unknown family, and a user's controller that cannot be used."""
        known = tuple(family.name for family in FAMILIES)
        unknown = [name for name in self.families if name not in known]
        if unknown:
            problem = (self.case.name, "families")
            raise ConfigError([ConfigProblem(*problem, repr(n), one_of(known), nearest(n, known)) for n in unknown])
        if self.user is not None:
            users_controllers(self.case.with_changes(runs.users_controller(self.user)), {})

    @cached_property
    def chosen(self) -> list[Family]:
        """The families that are run."""
        known = {family.name: family for family in FAMILIES}
        return [known[name] for name in dict.fromkeys(self.families or known)]

    @cached_property
    def variants(self) -> dict[tuple[str, str, float], Case]:
        """Family, curve and value of each variant -> its case; those of 'references' have no value."""
        own: dict[str, Any] = {runs.USER: runs.users_controller(self.user)} if self.user else {}
        shipped = {
            ("references", label, math.nan): changes for label, changes in (runs.references(self.case) | own).items()
        }
        varied = {
            (family.name, label, float(value)): family.changes(self.case, curve, value)
            for family in self.chosen
            for label, curve in (dict(family.curves) | (own if family.user else {})).items()
            for value in family.values
        }
        return {key: self.case.with_changes(changes) for key, changes in (shipped | varied).items()}

    def rounds(self, done: Done) -> Iterator[Round]:
        jobs = {_name(key): job(run_variant, case, key[0] == "references") for key, case in self.variants.items()}
        yield {**jobs, **(runs.loop_jobs(self.case, self.user) if self.loop else {})}
        yield {f"course of {_name(key)}": job(run_variant, self.variants[key], True) for key in self._worst(done)}

    def _worst(self, done: Done) -> list[tuple[str, str, float]]:
        """The worst variant of each cause whose test came to its end."""
        results = self._results(done)[1]
        worst = (max((r for r in results if r.cause == cause), key=lambda r: r.severity, default=None)
                 for cause in ("tracking", "ripple"))  # fmt: skip
        return [(r.family, r.curve, r.value) for r in worst if r is not None]

    def _results(self, done: Done) -> tuple[list[Result], list[Result]]:
        found = [Result(*key, done[_name(key)]["numbers"]) for key in self.variants if _name(key) in done]
        return [r for r in found if r.family == "references"], [r for r in found if r.family != "references"]

    def collect(self, done: Done) -> Found | None:
        references, results = self._results(done)
        if not references or references[0].curve != next(iter(runs.REFERENCES)):
            return None
        shipped = done[_name(("references", references[0].curve, math.nan))]["course"]
        base, courses = shipped.isel(time=slice(None, None, 50)), {references[0].curve: shipped}
        references, results = (
            [replace(r, numbers=runs.against(r.numbers, base)) for r in rs] for rs in (references, results)
        )
        for key in self._worst(done):
            family = next(f for f in FAMILIES if f.name == key[0])
            if f"course of {_name(key)}" in done:
                label = f"{family.name.replace('_', ' ')},\n{key[1]}: {family.text(key[2])}"
                courses[label] = done[f"course of {_name(key)}"]["course"]
        loop = (point for name, point in done.items() if name.startswith("gains times "))
        points = sorted(loop, key=lambda point: point["factor"])
        return Found(references, results, courses, points, done.get(runs.USER))

    def numbers(self, results: Found) -> dict[str, Any]:
        return {
            "case": self.case.name,
            "duration_s": self.case.time.duration,
            "limits": {"tracking_rms": TRACKING_LIMIT, "ripple_nm": RIPPLE_LIMIT},
            "references": {r.curve: r.numbers for r in results.references},
            "results": [_entry(r) for r in results.results],
            "ranking": [
                {
                    "family": rank.family.name,
                    "curve": rank.worst.curve,
                    "worst_value": rank.worst.value,
                    "worst_tracking_rms": rank.worst.numbers["tracking_rms"],
                    "worst_ripple_nm": rank.worst.numbers["ripple_nm"],
                    "failures": [vars(failure) for failure in rank.failures],
                }
                for rank in ranking(self.chosen, results.results)
            ],
            "loop": runs.loop_numbers(self.case, results.loop, results.users) if results.loop else None,
        }

    def summary(self, results: Found, numbers: Numbers) -> list[str]:
        shipped = percent(results.references[0].numbers["tracking_rms"])
        lines = [
            f"As shipped the wheels follow the virtual train within {shipped} RMS of its speed. A variant fails with a "
            f"{runs.TRACKING_CRITERION}, with a {runs.RIPPLE_CRITERION}, or where the test ends early."
        ]
        failing = [rank for rank in ranking(self.chosen, results.results) if rank.failures]
        lines.append("Where variants fail, worst first:" if failing else "No variant failed within the ranges run.")
        return lines + [f"– {one.family.title}, {one.worst.curve}: {failures_text(one)}." for one in failing]

    def files(self, results: Found, numbers: Numbers) -> Mapping[str, Any]:
        names = ("family", "curve", "value", "cause", *(q.key for q in QUANTITIES.below("*.*")))
        rows = [_entry(r) for r in (*results.references, *results.results)]
        loop = {"loop.csv": [list(results.loop[0]), *(list(p.values()) for p in results.loop)]} if results.loop else {}
        return {"variants.csv": QUANTITIES.csv(rows, names), **loop}

    def sections(self, results: Found, numbers: Numbers) -> list[Section]:
        ranked = ranking(self.chosen, results.results)
        references = {r.curve: r.numbers for r in results.references}
        courses = figures.runs_beside(results.courses, figures.course_rows(self.case.vehicle.data.wheel.radius), 5.6)
        caption = "Leading axle over time: the case as shipped, and the worst runs of each kind that came to their end."
        sections = [
            *([Section("Where variants fail", [ranking_table(self.case, ranked)])] if ranked else []),
            Section("Where the error comes from", [
                QUANTITIES.table(references, REFERENCE_COLUMNS, "the case, and where its error comes from", "run"),
                Picture("courses", courses, caption)]),
        ]  # fmt: skip
        if numbers["loop"] is not None:
            sections.append(Section("Stability of the loop", loop_blocks(numbers["loop"], results.loop)))
        return sections + [
            Section(f.title, [family_picture(self.case, f, results.results)])
            for f in self.chosen
            if any(r.family == f.name for r in results.results)
        ]


def study_case(case: Case, duration: float | None) -> Case:
    """The case as it is compared: shortened, and recorded finely enough to see ripple; ConfigError: nothing to compare."""
    track_case(case)
    control = rig_of(case)[1]
    if not control.is_ours:
        needed = "needed: the built-in controller in the case; give your own class with --controller, beside it"
        key = "user" if control.user is not None else "fmu"
        raise ConfigError.of(case.name, f"rig_control.{key}", repr(getattr(control, key)), needed)
    length = case.time.duration if duration is None else min(duration, case.time.duration)
    step = max(runs.OUTPUT_STEP, case.time.sampling_step)
    return case.with_changes({"time.duration": length, "time.output_step": step})


def _entry(result: Result) -> dict[str, Any]:
    """A result as summary.json and variants.csv have it."""
    names = ("family", "curve", "value", "cause")
    return {**{name: getattr(result, name) for name in names}, **result.numbers}


def _name(key: tuple[str, str, float]) -> str:
    return ", ".join(map(str, key[:2] if math.isnan(key[2]) else key))


@command
def control(
    case: Case | str,
    *,
    duration: Annotated[float, Option(least=1.0, most=600.0)] = 10.0,
    families: Annotated[Sequence[str], Option(commas=True)] = (),
    controller: str | None = None,
    loop: bool = True,
    processes: Processes = 1,
    progress: Progress | None = None,
) -> Outcome[Found]:
    """Controllers of the roller drives: estimators, feedbacks, sample times, drives, wrong parameters; which fails first.

    Args:
        case: case on rollers with [rig_control]: a name of the catalogue or a TOML file.
        duration: length of each run [s]: until adhesion has broken away and recovered.
        families: what is varied, by name; everything if absent.
        controller: your own controller to compare: 'file.py:Class' or 'module:Class', or an FMU.
        loop: also find the gains at which the loop becomes unstable, computed and measured.
        processes: runs at a time; more than 1 asks a script for `if __name__ == "__main__":`.
        progress: called with the fraction done and a short text.

    Raises:
        ConfigError: the case has no controller to be compared, or a name is unknown.
    """
    study = ControlStudy(study_case(as_case(case), duration), tuple(families), controller, loop)
    return study.outcome(processes, progress)
