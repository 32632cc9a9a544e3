"""Two systems of wheel slide protection compared: the same programme, the same draws, and what differs test by test.

Two cases, Programme -> [WspStudy of each] -> StopTests in pairs -> [Difference] -> interval, effect size, which is better,
    number of tests that would decide it

Test k of both systems draws the same adhesion, pads, load, speed and demand: what both depend on alike cancels in the
difference. Neither system is better where a test of either is a bad one, as in the programme itself.
"""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Annotated, Any, Literal

import numpy as np
from scipy.stats import nct, t

from rollerrig.analysis.slide_statistics import idle_valves
from rollerrig.cases import as_case
from rollerrig.common.formatting import number
from rollerrig.config import CRITERIA, Case, ConfigError, ConfigProblem, Programme, load_programme
from rollerrig.plot.adhesion import means_with_intervals
from rollerrig.study.ensemble import CONFIDENCE, Estimate, difference, stepped
from rollerrig.study.frame import Content, Outcome, Study
from rollerrig.study.jobs import Done, Progress, Round
from rollerrig.study.options import Option, Processes, command
from rollerrig.study.quantities import Numbers
from rollerrig.study.report import Block, Mark, Picture, Section, Table, Text
from rollerrig.study.runs.wsp import (
    OVER_DRY,
    SUPPORTS,
    StopTests,
    Support,
    check_case,
    dry_faults,
    faults,
    rig_faults,
    stop_case,
)
from rollerrig.study.wsp import ON, Results, WspStudy, label, with_unit

Better = Literal["first", "second", "neither", "not decided"]
System = Literal["first", "second"]
SYSTEMS: tuple[System, ...] = ("first", "second")
POWER = 0.8  # probability with which the number of tests that would decide a difference decides it
MOST_TESTS = 10_000
PROTECTION = (
    "slide_protection", "wheel_slip_control", "brake.air", "brake.volume", "brake.electrodynamic.on_slide", "brake_unit",
    "sensors.vehicle", "fault",
)  # fmt: skip
"""What may differ: protection, its valves and sensors, and their faults; with any other difference tests are no pairs."""
DRAWN = {"distance": "distance [%]", "air": "air [%]"}  # criteria that have a figure -> what its axis shows


@dataclass(frozen=True)
class Difference:
    """A criterion of a stop on one support: means of both systems, the second less the first, in its SI unit."""

    criterion: str
    first: Estimate
    second: Estimate
    found: Estimate
    deviation: float  # standard deviation of the differences of single tests
    reasons: tuple[str, ...]  # why nothing is decided

    @property
    def effect(self) -> float:
        """Mean difference over the standard deviation of the differences (Cohen's d of paired tests) [-]."""
        return self.found.mean / self.deviation if self.deviation > 0.0 else math.nan

    @property
    def better(self) -> Better:
        """The system on whose side of zero the whole interval of the difference lies; neither: all tests gave the same."""
        interval = self.found.interval
        if self.reasons or not (math.isfinite(interval.low) and math.isfinite(interval.high)):
            return "not decided"
        if interval.low <= 0.0 <= interval.high:
            return "neither" if interval.low == interval.high else "not decided"
        more_is_better = CRITERIA[self.criterion].least
        return "second" if (interval.low > 0.0) == more_is_better else "first"

    @property
    def tests_needed(self) -> float:
        """Tests of each system that decide a difference as large as this with POWER; NaN: no number of tests does."""
        beyond_steps = abs(self.found.mean) - self.found.systematic
        return pairs_needed(beyond_steps / self.deviation) if self.deviation > 0.0 < beyond_steps else math.nan


def pairs_needed(effect: float) -> float:
    """Least number of pairs with which a t-test finds an effect, mean over standard deviation [-], with POWER; NaN: too many."""
    count = np.arange(2, MOST_TESTS + 1)
    critical = t.ppf(0.5 + 0.5 * CONFIDENCE, count - 1)
    enough = np.flatnonzero(nct.sf(critical, count - 1, abs(effect) * np.sqrt(count)) >= POWER)
    return float(count[enough[0]]) if enough.size else math.nan


@dataclass(frozen=True)
class ProtectionComparison(Study[Mapping[System, Results]]):
    """Two cases through one programme; attributes as the arguments of `rollerrig.wsp`, `against` the second system."""

    case: Case
    against: Case
    programme: Programme
    starts: int = 0
    quick: bool = False

    command = "wsp_against"
    heading = "{case.name} and {against.name}: two systems of wheel slide protection"
    writes = ("tests_*.csv", "signals_*.csv")
    irrelevant = ("description", "source")

    def __post_init__(self) -> None:
        """Refuse cases with nothing to test or whose stops differ in more than the protection, and a case against itself."""
        for case in (self.case, self.against):
            check_case(case, self.programme)
        problems = [
            ConfigProblem(
                self.against.name, key, value, f"allowed: {first}, as in {self.case.name}; only the protection differs"
            )
            for key, first, value in self.changes
            if not f"{key}.".startswith(tuple(f"{one}." for one in PROTECTION))
        ]
        if problems:
            raise ConfigError(problems)
        if not self.changes:
            needed = (
                f"needed: a system that differs from {self.case.name}, such as another threshold in [slide_protection]"
            )
            raise ConfigError.of(self.against.name, "", "the same case", needed)

    @property
    def studies(self) -> Mapping[System, WspStudy]:
        """The programme with each system."""
        cases = zip(SYSTEMS, (self.case, self.against), strict=True)
        return {system: WspStudy(case, self.programme, self.starts, self.quick) for system, case in cases}

    @property
    def changes(self) -> list[tuple[str, str, str]]:
        """Key, value of the first and of the second system, of all that differs in any stop but the names."""
        found: dict[tuple[str, str, str], None] = {}
        for stop in self.programme.stop:
            first, second = (stop_case(case, self.programme, stop) for case in (self.case, self.against))
            found |= dict.fromkeys(first.diff(second).texts())
        return [row for row in found if row[0].rpartition(".")[2] not in ("name", "description", "source")]

    @property
    def mark(self) -> Mark | None:
        return self.studies["first"].mark

    def cases(self) -> Mapping[str, Case]:
        return {self.case.name: self.case, f"{self.against.name} (second)": self.against}

    @property
    def round_ends(self) -> tuple[float, ...]:  # type: ignore[override]
        return self.studies["first"].round_ends

    def rounds(self, done: Done) -> Iterator[Round]:
        """A stop with both systems at a time."""
        for works in zip(*(study.rounds({}) for study in self.studies.values()), strict=True):
            named = zip(SYSTEMS, works, strict=True)
            yield {f"{system}: {name}": job for system, work in named for name, job in work.items()}

    def collect(self, done: Done) -> Mapping[System, Results] | None:
        """Tests that both systems have: an interrupted study is compared in pairs, too."""
        own = {
            system: {name.removeprefix(f"{system}: "): one for name, one in done.items() if name.startswith(system)}
            for system in SYSTEMS
        }
        both = own["first"].keys() & own["second"].keys()
        found: dict[System, Results] = {}
        for system, study in self.studies.items():
            results = study.collect({name: one for name, one in own[system].items() if name in both})
            if results is None:
                return None
            found[system] = results
        return found

    def statuses(self, results: Mapping[System, Results]) -> list[str]:
        return [status for system, study in self.studies.items() for status in study.statuses(results[system])]

    def numbers(self, results: Mapping[System, Results]) -> dict[str, Any]:
        stops: dict[str, Any] = {}
        for stop in results["first"]:
            for on in SUPPORTS:
                own = {one.criterion: _as_dict(one) for one in differences(results, stop, on)}
                stops.setdefault(stop, {})[on] = own
        words = [one["better"] for stop in stops.values() for own in stop.values() for one in own.values()]
        return {
            "case": self.case.name,
            "against": self.against.name,
            "programme": self.programme.name,
            "starts": self.studies["first"].count,
            "changes": {key: {"first": a, "second": b} for key, a, b in self.changes},
            "stops": stops,
            "sums": {word.replace(" ", "_"): words.count(word) for word in ("first", "second", "neither", "not decided")},
        }  # fmt: skip

    def summary(self, results: Mapping[System, Results], numbers: Numbers) -> list[str]:
        idle = [f"{case.name}: {line}." for case in (self.case, self.against) for line in idle_valves(case)]
        return [*idle, *_findings(numbers)]

    def files(self, results: Mapping[System, Results], numbers: Numbers) -> Mapping[str, Content]:
        found: dict[str, Content] = {}
        for system, study in self.studies.items():
            for name, content in study.files(results[system], {}).items():
                kind, _, stop = name.partition("_")
                found[f"{kind}_{system}_{stop}"] = content
        return found

    def sections(self, results: Mapping[System, Results], numbers: Numbers) -> list[Section]:
        changed = Table(("key", self.case.name, self.against.name), self.changes, "What differs between the systems.")
        tables = [_table(numbers, on) for on in SUPPORTS]
        return [
            Section("Differences", [*tables, *_pictures(numbers)]),
            Section("The two systems", [changed]),
            Section("What is not claimed", [Text(text) for text in CLAIMS]),
        ]


def differences(results: Mapping[System, Results], stop: str, on: Support) -> Iterator[Difference]:
    """All criteria of a stop on one support, the second system less the first."""
    tests = {system: results[system][stop].tests for system in SYSTEMS}
    one, two = (tests[system][on] for system in SYSTEMS)
    common = [f"{system}: {why}" for system in SYSTEMS for why in _faults(tests[system], on)]
    for criterion, what in CRITERIA.items():
        if what.of_a_stop and not one.stop.stops:
            continue
        name, factor = what.measure, what.factor
        dry = [f"{s}: {why}" for s in SYSTEMS if name in OVER_DRY for why in dry_faults(tests[s][on])]
        found = difference(two.values(name), one.values(name))
        count = min(len(one.fine), len(two.fine))
        if count:
            coarse = difference(two.values(name)[:count], one.values(name)[:count])
            fine = difference(two.values(name, two.fine), one.values(name, one.fine))
            found = stepped(found, coarse, fine)
        deviation = factor * found.standard_error * math.sqrt(len(one.tests))
        first, second = (both.estimate(name).times(factor) for both in (one, two))
        yield Difference(criterion, first, second, found.times(factor), deviation, (*common, *dry))


def _faults(tests: Mapping[Support, StopTests], on: Support) -> list[str]:
    own = list(faults(tests[on]))
    return own + (list(rig_faults(tests["rig"], tests["track"])) if on == "rig" else [])


def _as_dict(one: Difference) -> dict[str, Any]:
    own = {"first": one.first.mean, "second": one.second.mean, "difference": one.found.as_dict()}
    more = {name: getattr(one, name) for name in ("effect", "better", "tests_needed")}
    return {**own, **more, "why": "; ".join(one.reasons)}


CLAIMS = (
    "Of a hundred criteria in which the systems do not differ, about five come out as decided, by intervals of 95 %.",
    "Which system is better is said by one criterion at a time: a shorter distance may take more air.",
)


def _findings(numbers: Numbers) -> Iterator[str]:
    names = {"first": numbers["case"], "second": numbers["against"]}
    sums = numbers["sums"]
    yield (
        f"First: {names['first']}; second: {names['second']}. Of {sum(sums.values())} criteria on track and on the rig the first "
        f"system is better in {sums['first']}, the second in {sums['second']}; {sums['neither']} are the same, "
        f"{sums['not_decided']} not decided."
    )
    told: dict[str, list[str]] = {}
    for stop, own in numbers["stops"].items():
        found = [(on, criterion, one) for on, assessed in own.items() for criterion, one in assessed.items()]
        for on, criterion, one in found:
            place = f"{stop.replace('_', ' ')} on {ON[on]}, {label(criterion)}"
            if one["better"] in SYSTEMS:
                value = with_unit(criterion, one["difference"])
                told.setdefault(f"The {one['better']} is better", []).append(f"{place} {value}")
            elif one["why"]:
                told.setdefault(f"Not decided, {one['why']}", []).append(place)
    for head, places in sorted(told.items(), reverse=True):
        yield f"{head}: {'; '.join(places)}."


def _table(numbers: Numbers, on: Support) -> Table:
    rows = []
    for stop, own in numbers["stops"].items():
        for criterion, one in own[on].items():
            cells = (with_unit(criterion, one[name]) for name in (*SYSTEMS, "difference"))
            effect, needed = (number(one[name], 2) for name in ("effect", "tests_needed"))
            rows.append((stop.replace("_", " "), label(criterion), *cells, effect, one["better"], needed))
    header = ("stop", "criterion", *SYSTEMS, "second less first", "effect size", "better", "tests that would decide")
    return Table(header, rows, f"On {ON[on]}: means of all tests, intervals of 95 %.")


def _pictures(numbers: Numbers) -> Iterator[Block]:
    for criterion, axis in DRAWN.items():
        stops = {name: own for name, own in numbers["stops"].items() if criterion in own["track"]}
        found: dict[str, list[Numbers | None]] = {
            on: [_relative(own[on][criterion]) for own in stops.values()] for on in SUPPORTS
        }
        if stops:
            drawn = means_with_intervals(list(stops), found, f"second less first over first: {axis}", zero=True)
            caption = f"Difference in {label(criterion)}, over the mean of the first system, with intervals of 95 %."
            yield Picture(f"difference_{criterion}", drawn, caption)


def _relative(one: Numbers) -> Numbers | None:
    """The difference in per cent of the first system's mean, where its interval is known."""
    found = {end: one["difference"][end] for end in ("mean", "low", "high")}
    if not one["first"] or None in found.values():
        return None
    return {end: 100.0 * value / one["first"] for end, value in found.items()}


@command
def wsp(
    case: Case | str,
    programme: Programme | str = "slide_protection_stops",
    *,
    against: Case | str | None = None,
    starts: Annotated[int, Option(least=0, most=100)] = 0,
    quick: bool = False,
    processes: Processes = 1,
    progress: Progress | None = None,
) -> Outcome[Any]:
    """A test programme for wheel slide protection: a series of stops on track and on the rig, assessed by limits.

    Args:
        case: case on rollers with [rig_control]: a name of the catalogue or a TOML file.
        programme: stops and limits: a name of the catalogue or a TOML file.
        against: another case, whose system is compared with this one: the same stops with the same draws, what differs with
            intervals, effect sizes and the number of tests that would decide it; limits then assess nothing.
        starts: tests of each stop on each support; 0: as many as the programme needs for a decision.
        quick: two starts of the first two stops: to see that everything works.
        processes: runs at a time; more than 1 asks a script for `if __name__ == "__main__":`.
        progress: called with the fraction done and a short text.

    Raises:
        ConfigError: a case has nothing to test, or cannot do a stop; two cases are the same, or have different samples.
        StartError: a case finds no equilibrium to start from.
    """
    tested = programme if isinstance(programme, Programme) else load_programme(programme)
    if against is None:
        return WspStudy(as_case(case), tested, starts, quick).outcome(processes, progress)
    return ProtectionComparison(as_case(case), as_case(against), tested, starts, quick).outcome(processes, progress)
