"""A test programme for wheel slide protection: every stop on track and on the rig, as ensembles, assessed by limits.

Case of a rig with brake and slide protection, Programme -> [WspStudy] -> outcome per criterion, numbers per stop, CSV files
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
import xarray as xr

from rollerrig.analysis.slide_statistics import SLIP_EDGES, axle_columns, idle_valves, wheel_radius
from rollerrig.common.arrays import Array
from rollerrig.config import CRITERIA, Case, Programme
from rollerrig.config.schema.programme import BrakedRun
from rollerrig.config.write.toml import to_toml
from rollerrig.plot.adhesion import PRESSURE, axles_over_time, means_with_intervals, slip_histograms, wheel_less_train
from rollerrig.study.assessment import SHOWN, overall
from rollerrig.study.ensemble import finer, start_jobs, started
from rollerrig.study.frame import Content, Study
from rollerrig.study.jobs import Done, Job, Round, job
from rollerrig.study.quantities import Numbers, Quantities, Quantity
from rollerrig.study.report import Block, Picture, Preformatted, Section, Table, Text
from rollerrig.study.runs import wsp as runs
from rollerrig.study.runs.adhesion import GROUPS, assessment_rows, track_case
from rollerrig.study.runs.adhesion import outcome_of as group_outcome
from rollerrig.study.runs.wsp import SUPPORTS, Assessment, StopRecord, StopTests, Support

Tests = Mapping[Support, StopTests]
ON: Mapping[Support, str] = {"track": "track", "rig": "the rig"}
FINE, FINE_STARTS = ", finer steps", 2
"""Ending of the jobs with finer steps and samples, and how many there are of each stop and support."""

QUICK_STOPS, QUICK_STARTS = 2, 2  # stops and starts of a quick study

QUANTITIES = Quantities("wsp")
MEASURED = [
    q.key.split(".")[3] for q in QUANTITIES.below("stops.*.*") if q.key.endswith(".mean") and "criteria" not in q.key
]
"""Names of what is reported of the tests of a stop."""

WORDS = ("met", "not met", "not decided")


@dataclass(frozen=True)
class StopResult:
    """What a stop gave: tests by support, criteria on both, the signals of the first tests, processor time of all [s]."""

    tests: Tests
    assessed: Sequence[Assessment]
    signals: Mapping[str, xr.Dataset]
    seconds: float


Results = Mapping[str, StopResult]


@dataclass(frozen=True)
class WspStudy(Study[Results]):
    """A test programme for wheel slide protection; attributes as the arguments of `rollerrig.wsp`."""

    case: Case
    programme: Programme
    starts: int = 0
    quick: bool = False

    command = "wsp"
    heading = "{case.name}: wheel slide protection, programme {programme.name}"
    quick_means = (
        f"{QUICK_STARTS} starts of the first {QUICK_STOPS} stops, whose numbers only show that everything works"
    )
    writes = ("tests_*.csv", "signals_*.csv")
    irrelevant = ("description", "source")

    def __post_init__(self) -> None:
        """Refuse a case that has no slide protection to be tested on a rig, and stops that it cannot do."""
        runs.check_case(self.case, self.programme)

    @property
    def count(self) -> int:
        """Tests of each stop on each support."""
        return QUICK_STARTS if self.quick else self.starts or self.programme.starts

    @property
    def stops(self) -> Sequence[BrakedRun]:
        """Those that are made."""
        return self.programme.stop[:QUICK_STOPS] if self.quick else self.programme.stop

    @cached_property
    def stop_cases(self) -> Mapping[str, Case]:
        """Name of the stop -> its case on the rig."""
        return {stop.name: runs.stop_case(self.case, self.programme, stop) for stop in self.stops}

    @property
    def round_ends(self) -> tuple[float, ...]:  # type: ignore[override]
        """A round per stop."""
        return tuple((k + 1) / len(self.stops) for k in range(len(self.stops)))

    def rounds(self, done: Done) -> Iterator[Round]:
        for stop in self.stops:
            jobs: dict[str, Job] = {}
            for on in SUPPORTS if stop.stops else ():
                dry = _on(runs.dry_case(self.case, self.programme, stop), on)
                jobs[f"{runs.dry_name(self.case, stop)}, {on}"] = job(runs.stop_record, dry, self.programme.flat, False)
            cases = {f"{stop.name}, {on}": _on(self.stop_cases[stop.name], on) for on in SUPPORTS}
            jobs |= start_jobs(
                cases, lambda one, k: job(runs.stop_record, one, self.programme.flat, k == 0), self.count
            )
            fine = {f"{name}{FINE}": finer(case) for name, case in cases.items() if not self.quick}
            jobs |= start_jobs(fine, lambda one, _: job(runs.stop_record, one, self.programme.flat, False), FINE_STARTS)
            yield jobs

    def plan(self) -> dict[str, Any]:
        """Limits and numbers of starts change no test."""
        found = super().plan()
        programme = {key: value for key, value in found["programme"].items() if key not in ("limit", "starts")}
        return {**{key: value for key, value in found.items() if key != "starts"}, "programme": programme}

    def collect(self, done: Done) -> Results | None:
        found = {stop.name: self._result(stop, done) for stop in self.stops}
        kept = {name: one for name, one in found.items() if all(tests.tests for tests in one.tests.values())}
        return kept or None

    def _result(self, stop: BrakedRun, done: Done) -> StopResult:
        made: dict[Support, list[StopRecord]] = {
            on: started(done, f"{stop.name}, {on}")[: self.count] for on in SUPPORTS
        }
        fine = {on: [one.test for one in started(done, f"{stop.name}, {on}{FINE}")] for on in SUPPORTS}
        needed, case = max(self.programme.starts, self.count), self.stop_cases[stop.name]
        tests: dict[Support, StopTests] = {}
        for on, records in made.items():
            dry: StopRecord | None = done.get(f"{runs.dry_name(self.case, stop)}, {on}") if stop.stops else None
            own = [one.test for one in records]
            tests[on] = StopTests(stop, on, case, needed, own, None if dry is None else dry.test, fine[on])
        assessed = [
            one
            for on, other in zip(SUPPORTS, SUPPORTS[::-1], strict=True)
            if tests[on].tests
            for one in runs.assessments(self.programme, tests[on], tests[other])
        ]
        signals: dict[str, xr.Dataset] = {
            on: records[0].signals for on, records in made.items() if records and records[0].signals is not None
        }
        return StopResult(tests, assessed, signals, sum(one.seconds for records in made.values() for one in records))

    def statuses(self, results: Results) -> Sequence[str]:
        return [record.status for one in results.values() for tests in one.tests.values() for record in tests.tests]

    def numbers(self, results: Results) -> dict[str, Any]:
        return {
            "case": self.case.name,
            "programme": self.programme.name,
            "starts": self.count,
            "starts_needed": self.programme.starts,
            "stops": {name: _stop_numbers(one) for name, one in results.items()},
            "sums": {on: _sum_numbers(list(results.values()), on) for on in SUPPORTS},
        }

    def summary(self, results: Results, numbers: Numbers) -> list[str]:
        return [*idle_valves(self.case), *_findings(numbers, len(self.programme.limit)), NOT_QUOTED]

    def timings(self, results: Results) -> Mapping[str, Mapping[str, float]]:
        each = {name: one.seconds for name, one in results.items()}
        return {"processor time of the tests [s]": {**each, "all": sum(each.values())}}

    def files(self, results: Results, numbers: Numbers) -> Mapping[str, Content]:
        found: dict[str, Content] = {}
        for name, one in results.items():
            found[f"tests_{name}.csv"] = _test_rows(one.tests)
            found[f"signals_{name}.csv"] = axle_columns(one.signals, runs.SIGNALS)
        return found

    def sections(self, results: Results, numbers: Numbers) -> list[Section]:
        programme = Preformatted(f"The whole programme: {self.programme.name}", to_toml(self.programme))
        return [
            Section("Assessment", [_overview(self.programme, numbers)]),
            Section("Criteria", [_criteria_table(numbers)]),
            Section("Stops", [*_stop_tables(numbers), *_pictures(results, numbers)]),
            *(_stop_section(name, one, numbers["stops"][name]) for name, one in results.items()),
            Section("What is not claimed", [Text(text) for text in CLAIMS]),
            Section("Programme", [programme]),
        ]


def _on(case: Case, support: Support) -> Case:
    return track_case(case) if support == "track" else case


def _stop_numbers(result: StopResult) -> dict[str, Any]:
    track, rig = result.tests["track"], result.tests["rig"]
    rows = assessment_rows(rig.case, (track.tests, rig.tests), (track.fine, rig.fine))
    criteria: dict[str, Any] = {}
    for one in result.assessed:
        limit = one.limit
        kind = "at least" if CRITERIA[limit.criterion].least else "at most"
        head = {"limit": limit.value, "kind": kind, "origin": limit.origin, "clause": limit.clause}
        found = {"outcome": one.outcome, **one.mean.as_dict(), "worst": one.worst, "why": one.why}
        criteria.setdefault(limit.criterion, head)[one.support] = found
    return {
        "kind": track.stop.kind,  # type: ignore[attr-defined]
        "speed_kmh": 3.6 * track.stop.speed,
        **{on: _support_numbers(tests, result.assessed) for on, tests in result.tests.items()},
        "criteria": criteria,
        "rig_like_track": {group: group_outcome(rows, group) for group in GROUPS},
    }


def _support_numbers(found: StopTests, assessed: Sequence[Assessment]) -> dict[str, Any]:
    numbers: dict[str, Any] = {
        "outcome": overall(one.outcome for one in assessed if one.support == found.support),
        "tests": len(found.tests),
        "stopped": sum(one.stopped for one in found.tests),
        "dry_distance_m": None if found.dry is None else found.dry.measures["distance_m"],
        "dry_build_up_s": None if found.dry is None else found.dry.measures["build_up_s"],
    }
    for name in MEASURED:
        values = found.values(name)
        mean, largest = found.estimate(name), max(values) if np.isfinite(values).all() else None
        numbers[name] = {**mean.as_dict(), "largest": largest}
    return numbers


def _sum_numbers(results: Sequence[StopResult], on: Support) -> dict[str, Any]:
    words = [assessed.outcome for one in results for assessed in one.assessed if assessed.support == on]
    own = [one.tests[on] for one in results]
    means = ("distance_m", "air_litres", "dump_cycles")
    return {
        "criteria": {word.replace(" ", "_"): words.count(word) for word in WORDS},  # type: ignore[arg-type]
        **{name: sum(float(np.mean(one.values(name))) for one in own) for name in means},
        **{name: max(max(one.values(name)) for one in own) for name in ("longest_lock_s", "flat_length_m")},
    }


def _test_rows(tests: Tests) -> list[list[object]]:
    """A line per test of a stop, header first."""
    rows: list[list[object]] = [["support", "start", "status", *MEASURED]]
    for on, found in tests.items():
        columns = [found.values(name) for name in MEASURED]
        rows += [[on, k + 1, one.status, *(column[k] for column in columns)] for k, one in enumerate(found.tests)]
    return rows


NOT_QUOTED = (
    "Stops and limits are those of the programme file. EN 15595 and UIC 541-05 are not quoted: an outcome here is no approval, "
    "and says only what the limits of that file say."
)
CLAIMS = (
    NOT_QUOTED,
    "The length of a flat is an estimate of its order; on the rig it is that of the train which the rig stands for. What each "
    "number means, and what intervals contain: docs/studies/wsp.md.",
)


def _findings(numbers: Numbers, limits: int) -> Iterator[str]:
    head = f"{len(numbers['stops'])} stops of {numbers['starts']} starts each, on track and on the rig."
    stops = numbers["stops"].items()
    criteria = [(stop, name, one) for stop, own in stops for name, one in own["criteria"].items()]
    if limits:
        parts = []
        for on in SUPPORTS:
            found = numbers["sums"][on]["criteria"]
            parts.append(
                f"on {ON[on]} {found['met']} of {sum(found.values())} criteria are met, {found['not_met'] or 'none'} not met, "
                f"{found['not_decided'] or 'none'} not decided"
            )
        yield f"O{'; '.join(parts)[1:]}. {head}"
    else:
        yield f"{head} The programme sets no limit: nothing is assessed."
    for on in SUPPORTS:
        told: dict[tuple[str, str], list[str]] = {}
        for stop, name, one in criteria:
            outcome, why = (one.get(on, {}).get(key, "") for key in ("outcome", "why"))
            value = f" {value_text(name, one[on])}, {limit_text(name, one)}" if outcome == "not met" else ""
            told.setdefault((outcome, why), []).append(f"{stop.replace('_', ' ')} ({label(name)}{value})")
        for (outcome, why), places in sorted(told.items(), key=lambda pair: pair[0][0] != "not met"):
            if outcome in ("not met", "not decided"):
                yield f"{SHOWN[outcome]} on {ON[on]}{f', {why}' if why else ''}: {'; '.join(places)}."
    words = [one["rig_like_track"]["fidelity"] for _, one in stops]
    met, against, open_ = (words.count(word) for word in WORDS)
    yield (
        f"The rig does as the track within the targets of the command adhesion in {met} of {len(words)} stops, not in {against}, "
        f"not decided in {open_}: an outcome on the rig is one of the test on the rig."
    )
    sums = [quantity for quantity in QUANTITIES.below("sums.*") if "criteria" not in quantity.key]
    for on in SUPPORTS:
        found = numbers["sums"][on]
        yield f"All stops on {ON[on]}: {', '.join(f'{one.label} {one.told(found[one.name])}' for one in sums)}."


def label(criterion: str) -> str:
    """What a criterion is called."""
    return quantity_of(criterion).label


def quantity_of(criterion: str) -> Quantity:
    """What a criterion is set for, in its SI unit, shown as the measure."""
    one = CRITERIA[criterion]
    found = QUANTITIES[f"stops.*.*.{one.measure}.mean"]
    return replace(found, shown=(found.shown_unit, found.in_shown_unit(1.0 / one.factor)))


def with_unit(criterion: str, value: object) -> str:
    """A value of a criterion, or a mean with its interval, with the unit of tables."""
    return quantity_of(criterion).told(value)


def value_text(name: str, one: Numbers) -> str:
    """Mean of a criterion, its interval, and the worst test where each counts."""
    every = CRITERIA[name].every and one.get("worst") is not None
    return with_unit(name, one) + (f", worst {with_unit(name, one['worst'])}" if every else "")


def limit_text(name: str, one: Numbers) -> str:
    """A limit."""
    each = " in each test" if CRITERIA[name].every else ""
    return f"{one['kind']} {with_unit(name, one['limit'])}{each}"


def _overview(programme: Programme, numbers: Numbers) -> Table:
    described = {stop.name: stop.description for stop in programme.stop}
    rows = []
    for name, one in numbers["stops"].items():
        same = one["rig_like_track"]
        words = [SHOWN[one[on]["outcome"]] for on in SUPPORTS]
        text = ", ".join(filter(None, (one["kind"], f"{one['speed_kmh']:.4g} km/h", described[name])))
        rows.append((*words, name.replace("_", " "), text, SHOWN[same["tracking"]], SHOWN[same["fidelity"]]))
    header = ("on track", "on the rig", "stop", "", "rig follows its virtual axles", "rig as the track")
    return Table(header, rows, "All criteria of each stop; and the assessment of the rig itself.")


def _criteria_table(numbers: Numbers) -> Table:
    rows = []
    for stop, own in numbers["stops"].items():
        for name, one in own["criteria"].items():
            found = [
                one.get(on, {"outcome": None, "mean": None, "low": None, "high": None, "why": ""}) for on in SUPPORTS
            ]
            whys = dict.fromkeys(two["why"] for two in found if two["why"])
            rows.append((
                *(SHOWN[two["outcome"]] for two in found), stop.replace("_", " "), label(name),
                *(value_text(name, two) for two in found), limit_text(name, one), one["clause"] or "–",
                "; ".join((*whys, one["origin"])),
            ))  # fmt: skip
    header = ("on track", "on the rig", "stop", "criterion", "track", "rig", "limit", "clause",
              "why nothing is decided; who set it")  # fmt: skip
    caption = "Every criterion: means of all starts (intervals of 95 %)." if rows else "No limit is set."
    return Table(header, rows, caption)


def _stop_tables(numbers: Numbers) -> Iterator[Table]:
    first = ("distance_m", "increase_over_dry", "k_wet", "mean_deceleration_mps2", "air_litres", "dump_cycles")
    second = ("adhesion_utilisation", "large_slip_share", "longest_lock_s", "flat_length_m", "odometer_error_m")
    rows = {f"{stop} on {ON[on]}": own[on] for stop, own in numbers["stops"].items() for on in SUPPORTS}
    for names, what in ((first, "Distances, air, dump cycles."), (second, "Sliding.")):
        caption = f"{what} Means of all starts, with intervals of 95 %."
        yield QUANTITIES.table(rows, [f"stops.*.*.{name}.mean" for name in names], caption, "stop")


def _pictures(results: Results, numbers: Numbers) -> Iterator[Block]:
    stops = numbers["stops"]
    dry = [one["track"]["dry_distance_m"] for one in stops.values()]
    caption = "Distance since the demand, mean and interval of 95 %, and the dry distance of the same speed and demand."
    drawn = means_with_intervals(list(stops), _means(stops, "distance_m"), "distance [m]", dry=dry)
    yield Picture("distances", drawn, caption)
    stopping = {name: one for name, one in stops.items() if one["track"]["k_wet"]["mean"] is not None}
    if stopping:
        limits = [one["criteria"].get("k_wet", {}).get("limit") for one in stopping.values()]
        caption = (
            "K_wet: dry distance over distance, mean and interval of 95 %; diamonds: least that the programme allows."
        )
        drawn = means_with_intervals(list(stopping), _means(stopping, "k_wet"), "K_wet [-]", limits=limits)
        yield Picture("k_wet", drawn, caption)
    shares: dict[str, dict[str, Array]] = {
        name: {on: np.mean([test.slip_shares for test in one.tests[on].tests], axis=0) for on in SUPPORTS}
        for name, one in results.items()
    }
    caption = "Part of the time that the axles spent at a slip, mean of all starts, while the brake acts above 2 m/s."
    yield Picture("slip_histograms", slip_histograms(SLIP_EDGES, shares), caption)


def _means(stops: Mapping[str, Numbers], name: str) -> dict[str, list[Numbers | None]]:
    return {on: [one[on][name] for one in stops.values()] for on in SUPPORTS}


def _stop_section(name: str, one: StopResult, own: Numbers) -> Section:
    keys = [f"stops.*.*.{key}.mean" for key in MEASURED]
    found: dict[str, Numbers] = {on: own[on] for on in SUPPORTS}
    caption = f"Means of {own['track']['tests']} and {own['rig']['tests']} tests, with intervals of 95 %."
    blocks: list[Block] = [QUANTITIES.list_table(found, keys, caption)]
    title = name.replace("_", " ")
    if len(one.signals) == len(SUPPORTS):
        speed = ("train\n[km/h]", "train_speed", 3.6)
        drawn = axles_over_time(one.signals, (speed, wheel_less_train(wheel_radius(one.signals["rig"])), PRESSURE), 6.0)
        blocks.insert(0, Picture(f"stop_{name}", drawn, f"{title}: the first tests on track and on the rig."))
    return Section(f"Stop {title}", blocks)
