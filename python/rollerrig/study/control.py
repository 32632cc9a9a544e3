"""Which controller of the roller drives tolerates what: one test under many variants, and the limit each exceeds first.

Case -> families of variants -> [ControlStudy] -> tracking and ripple of each run -> where each fails, ranking
     -> linear loop -> margins, limits of the gains, motion under a user's controller

Tracking is the wheel's speed less the virtual wheel's, over the train's speed (docs/theory/rig_control.md).
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Annotated, Any

import numpy as np

from rollerrig.cases import as_case, rig_of
from rollerrig.common.formatting import percent
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
from rollerrig.study.runs.control import FAMILIES, RIPPLE_LIMIT, TRACKING_LIMIT, Family, Result, run_variant

QUANTITIES = Quantities("control")
SHIPPED = "as shipped"


@dataclass(frozen=True)
class Rank:
    """One curve in the order of how badly it fares: results along the axis."""

    family: Family
    points: list[Result]

    @property
    def worst(self) -> Result:
        """The most severe result."""
        return max(self.points, key=lambda one: one.severity)

    @property
    def failures(self) -> dict[str, list[float]]:
        """Cause, as of Result -> values that fail of it, along the axis: a curve may pass again beyond one."""
        causes = dict.fromkeys(one.cause for one in self.points if one.cause)
        return {cause: [one.value for one in self.points if one.cause == cause] for cause in causes}

    @property
    def failures_text(self) -> str:
        """All values that fail."""
        known = {"tracking": runs.TRACKING_CRITERION, "ripple": runs.RIPPLE_CRITERION}
        texts = {cause: ", ".join(map(self.family.text, values)) for cause, values in self.failures.items()}
        ended = {cause: f"{cause.replace('_', ' ')}, test ends early," for cause in texts}
        return " and ".join(f"{(ended | known)[cause]} at {text}" for cause, text in texts.items())


def curves_of(family: Family, results: Sequence[Result]) -> dict[str, list[Result]]:
    """Curves of a family -> their results along the axis."""
    mine = sorted((r for r in results if r.family == family.name), key=lambda r: r.value)
    labels = dict.fromkeys(r.curve for r in results if r.family == family.name)
    return {label: [r for r in mine if r.curve == label] for label in labels}


def ranking(families: Sequence[Family], results: Sequence[Result]) -> list[Rank]:
    """All curves, the most severe result within the range tried first."""
    ranks = [Rank(family, points) for family in families for points in curves_of(family, results).values()]
    return sorted(ranks, key=lambda rank: rank.worst.severity, reverse=True)


def ranking_table(case: Case, ranked: Sequence[Rank]) -> Table:
    """Where every curve fails, and its worst run."""
    rows = []
    for rank in ranked:
        worst, family = rank.worst, rank.family
        base = family.base(case)
        shipped = "–" if base is None else family.text(base)
        cells = [QUANTITIES[name].cell(worst.numbers[name]) for name in ("tracking_rms", "ripple_nm")]
        error = cells[0] if worst.completed else "ended early"
        fails = rank.failures_text or "no failure"
        rows.append([family.title, worst.curve, fails, shipped, family.text(worst.value), error, cells[1]])
    header = ("varied", "curve", "fails", "shipped", "worst at", "tracking RMS [%]", "ripple [N m]")
    return Table(header, rows, "every curve, the worst first")


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


def loop_blocks(loop: Numbers) -> list[Block]:
    """Margins and limits of the gains, of the report."""
    users = loop["users"] or {}
    names = [q.key for q in QUANTITIES.below("loop") if q.label and (users or "users" not in q.key)]
    title = "The feedback in closed form, and from which factor on its gains on it is unstable."
    cause = users.get("no_loop")
    told = [Text(f"The loop that the user's controller closes has no growth rate: {cause}.")] if cause else []
    return [QUANTITIES.list_table({"": {**loop, **users}}, names, title), *told]


@dataclass(frozen=True)
class Found:
    """Results of the case as it is, with a user's controller beside it, and of the families; numbers of the linear loop."""

    references: list[Result]
    results: list[Result]
    loop: dict[str, Any] | None


@dataclass(frozen=True)
class ControlStudy(Study[Found]):
    """One test, of `study_case`, under many variants of the controller; attributes as the arguments of `rollerrig.control`."""

    case: Case
    families: tuple[str, ...] = ()
    user: str | None = None
    loop: bool = True

    command = "control"
    heading = "{case.name}: controllers of the roller drives compared"
    writes = ("variants.csv",)
    irrelevant = ("description", "families", "loop")
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
        shipped = {("references", label, math.nan): changes for label, changes in {SHIPPED: {}, **own}.items()}
        varied = {
            (family.name, label, float(value)): family.changes(self.case, curve, value)
            for family in self.chosen
            for label, curve in (dict(family.curves) | (own if family.user else {})).items()
            for value in family.values
        }
        return {key: self.case.with_changes(changes) for key, changes in (shipped | varied).items()}

    def rounds(self, done: Done) -> Iterator[Round]:
        jobs = {_name(key): job(run_variant, case) for key, case in self.variants.items()}
        yield {**jobs, **({"loop": job(runs.loop_numbers, self.case, self.user)} if self.loop else {})}

    def collect(self, done: Done) -> Found | None:
        found = [Result(*key, done[_name(key)]) for key in self.variants if _name(key) in done]
        references = [r for r in found if r.family == "references"]
        if not references or references[0].curve != SHIPPED:
            return None
        return Found(references, [r for r in found if r.family != "references"], done.get("loop"))

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
                    "failures": rank.failures,
                }
                for rank in ranking(self.chosen, results.results)
            ],
            "loop": results.loop,
        }

    def summary(self, results: Found, numbers: Numbers) -> list[str]:
        shipped = percent(results.references[0].numbers["tracking_rms"])
        lines = [
            f"As shipped the wheels follow the virtual train within {shipped} RMS of its speed. A variant fails with a "
            f"{runs.TRACKING_CRITERION}, with a {runs.RIPPLE_CRITERION}, or where the test ends early."
        ]
        failing = [rank for rank in ranking(self.chosen, results.results) if rank.failures]
        lines.append("Where variants fail, worst first:" if failing else "No variant failed within the ranges run.")
        return lines + [
            f"– {one.family.title}, {one.worst.curve}: {one.failures_text}; worst at {one.family.text(one.worst.value)}."
            for one in failing
        ]

    def files(self, results: Found, numbers: Numbers) -> Mapping[str, Any]:
        names = ("family", "curve", "value", "cause", *(q.key for q in QUANTITIES.below("*.*")))
        rows = [_entry(r) for r in (*results.references, *results.results)]
        return {"variants.csv": QUANTITIES.csv(rows, names)}

    def sections(self, results: Found, numbers: Numbers) -> list[Section]:
        ranked = ranking(self.chosen, results.results)
        names = [q.key for q in QUANTITIES.below("*.*") if q.label]
        sections = [Section("As shipped", [QUANTITIES.table(numbers["references"], names, head="run")])]
        if ranked:
            sections.insert(0, Section("Where variants fail", [ranking_table(self.case, ranked)]))
        if numbers["loop"] is not None:
            sections.append(Section("Stability of the loop", loop_blocks(numbers["loop"])))
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
        loop: also find the gains at which the linear loop becomes unstable.
        processes: runs at a time; more than 1 asks a script for `if __name__ == "__main__":`.
        progress: called with the fraction done and a short text.

    Raises:
        ConfigError: the case has no controller to be compared, or a name is unknown.
    """
    study = ControlStudy(study_case(as_case(case), duration), tuple(families), controller, loop)
    return study.outcome(processes, progress)
