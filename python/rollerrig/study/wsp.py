"""A test programme for wheel slide protection: every stop on track and on the rig, as ensembles, judged by limits.

Case of a rig with brake and slide protection, Programme -> [WspStudy] -> verdict per criterion, numbers per stop, CSV files
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rollerrig.analysis.slide_statistics import SLIP_EDGES
from rollerrig.config import CRITERIA, Case, Programme
from rollerrig.config.schema.programme import BrakedRun
from rollerrig.config.write.toml import to_toml
from rollerrig.plot.wsp import Ends, means_with_intervals, slip_grid, stop_over_time
from rollerrig.study.ensemble import estimate, starts
from rollerrig.study.frame import Content, Study
from rollerrig.study.jobs import Done, Job, Round, job
from rollerrig.study.quantities import Numbers, Quantities
from rollerrig.study.report import Block, Mark, Picture, Preformatted, Section, Table, Text
from rollerrig.study.runs.adhesion import GROUPS, SHOWN, track_case, verdict_rows
from rollerrig.study.runs.adhesion import verdict_of as group_verdict
from rollerrig.study.runs.wsp import (
    SUPPORTS,
    Judgement,
    StopRecord,
    StopTests,
    Support,
    check_case,
    counts,
    dry_case,
    dry_name,
    judgements,
    stop_case,
    stop_record,
    verdict_of,
)
from rollerrig.wording import number

Tests = Mapping[Support, StopTests]


QUANTITIES = Quantities("wsp")
MEASURED = [
    q.key.split(".")[3] for q in QUANTITIES.below("stops.*.*") if q.key.endswith(".mean") and "criteria" not in q.key
]
"""Names of what is reported of the tests of a stop."""


def stop_numbers(tests: Tests, judged: Sequence[Judgement]) -> dict[str, Any]:
    """Of one stop."""
    track, rig = tests["track"], tests["rig"]
    rows = verdict_rows(rig.case, track.tests, rig.tests)
    return {
        "kind": track.stop.kind,  # type: ignore[attr-defined]
        "speed_kmh": 3.6 * track.stop.speed,
        **{on: _support_numbers(tests[on], [one for one in judged if one.support == on]) for on in SUPPORTS},
        "criteria": _criteria(judged),
        "rig_like_track": {group: group_verdict(rows, group) for group in GROUPS},
    }


def _support_numbers(found: StopTests, judged: Sequence[Judgement]) -> dict[str, Any]:
    numbers: dict[str, Any] = {
        "verdict": verdict_of(judged),
        "tests": len(found.tests),
        "stopped": sum(one.stopped for one in found.tests),
        "dry_distance_m": None if found.dry is None else found.dry.measures["distance_m"],
    }
    for name in MEASURED:
        values = found.values(name)
        mean = estimate(values)
        ends = {"mean": mean.mean, "low": mean.interval.low, "high": mean.interval.high}
        numbers[name] = {**ends, "largest": max(values) if np.isfinite(values).all() else None}
    return numbers


def _criteria(judged: Sequence[Judgement]) -> dict[str, Any]:
    found: dict[str, Any] = {}
    for one in judged:
        limit = one.limit
        kind = "at least" if CRITERIA[limit.criterion].least else "at most"
        head = {"limit": limit.value, "kind": kind, "origin": limit.origin, "clause": limit.clause}
        interval = one.mean.interval
        found.setdefault(limit.criterion, head)[one.support] = {
            "verdict": one.verdict,
            "mean": one.mean.mean,
            "low": interval.low,
            "high": interval.high,
            "worst": one.worst,
            "why": one.why,
        }
    return found


def sum_numbers(stops: Sequence[Tests], judged: Sequence[Judgement]) -> dict[str, Any]:
    """Of all stops."""
    found: dict[str, Any] = {}
    for on in SUPPORTS:
        own = [tests[on] for tests in stops]
        means = {
            name: sum(float(np.mean(one.values(name))) for one in own)
            for name in ("distance_m", "air_litres", "dump_cycles")
        }
        worst = {name: max(max(one.values(name)) for one in own) for name in ("longest_lock_s", "flat_length_m")}
        found[on] = {"criteria": counts([one for one in judged if one.support == on]), **means, **worst}
    return found


# -------------------------------------------------------------------------------------------------------- CSV files


def test_rows(tests: Tests) -> list[list[object]]:
    """A line per test of a stop, header first."""
    rows: list[list[object]] = [["support", "start", "status", *MEASURED]]
    for on in SUPPORTS:
        found = tests[on]
        columns = [found.values(name) for name in MEASURED]
        for k, one in enumerate(found.tests):
            rows.append([on, k + 1, one.status, *(column[k] for column in columns)])
    return rows


test_rows.__test__ = False  # type: ignore[attr-defined]  # the name is no test's


def signal_columns(signals: Mapping[Support, Mapping[str, Any]]) -> Mapping[str, Any]:
    """Signals of the first tests, rig beside track, as long as both ran."""
    count = min((len(next(iter(one.values()))) for one in signals.values() if one), default=0)
    found: dict[str, Any] = {}
    for on, own in signals.items():
        for name, values in own.items():
            found.setdefault(name if name == "time_s" else f"{name}_{on}", values[:count])
    return found


NAMES = {
    "k_wet": "K_wet",
    "increase_over_dry": "increase over dry",
    "distance": "distance",
    "mean_deceleration": "mean deceleration",
    "adhesion_utilisation": "adhesion utilisation",
    "longest_lock": "longest lock",
    "flat_length": "flat length, estimated",
    "large_slip_share": "time at slip above 30 %",
    "air": "air",
    "ventings": "ventings",
}
"""Of the criteria."""

UNITS = {
    "increase_over_dry": ("%", 100.0),
    "distance": ("m", 1.0),
    "mean_deceleration": ("m/s²", 1.0),
    "longest_lock": ("s", 1.0),
    "flat_length": ("mm", 1e3),
    "large_slip_share": ("%", 100.0),
    "air": ("l", 1e3),
}
"""In which they are shown, and the factor."""

NOT_QUOTED = (
    "Stops and limits are those of the programme file. EN 15595 and UIC 541-05 are not quoted: a verdict here is no approval, "
    "and says only what the limits of that file say."
)


def findings(numbers: Numbers, limits: int) -> Iterator[str]:
    """All lines."""
    yield from _verdicts(numbers, limits)
    yield from _not_met(numbers)
    yield from _not_decided(numbers)
    yield from _fidelity(numbers)
    yield from _sum_lines(numbers)
    yield NOT_QUOTED


def _verdicts(numbers: Numbers, limits: int) -> Iterator[str]:
    count = len(numbers["stops"])
    head = f"{count} stops of {numbers['starts']} starts each, on track and on the rig."
    if not limits:
        yield f"{head} The programme sets no limit: nothing is judged."
        return
    parts = []
    for on in SUPPORTS:
        found = numbers["sums"][on]["criteria"]
        where = "on track" if on == "track" else "on the rig"
        parts.append(
            f"{where} {found['met']} of {sum(found.values())} criteria are met, {found['not_met'] or 'none'} not met, "
            f"{found['not_decided'] or 'none'} not decided"
        )
    text = "; ".join(parts)
    yield f"{text[0].upper()}{text[1:]}. {head}"


def _not_met(numbers: Numbers) -> Iterator[str]:
    for on in SUPPORTS:
        found = [
            f"{stop}: {NAMES[name]} {value_text(name, one[on])}, {limit_text(name, one)}"
            for stop, own in numbers["stops"].items()
            for name, one in own["criteria"].items()
            if on in one and one[on]["verdict"] == "not met"
        ]
        if found:
            yield f"NOT met on {'track' if on == 'track' else 'the rig'}: {'; '.join(found)}."


def _not_decided(numbers: Numbers) -> Iterator[str]:
    """Grouped by the reason."""
    for on in SUPPORTS:
        reasons: dict[str, dict[str, None]] = {}
        for stop, own in numbers["stops"].items():
            for name, one in own["criteria"].items():
                if on in one and one[on]["verdict"] == "not decided":
                    why = one[on]["why"]
                    inside = why == "the limit lies within the interval"
                    reasons.setdefault(why, {})[f"{stop} ({NAMES[name]})" if inside else stop] = None
        for why, stops in reasons.items():
            yield f"Not decided on {'track' if on == 'track' else 'the rig'}: {', '.join(stops).replace('_', ' ')}: {why}."


def _fidelity(numbers: Numbers) -> Iterator[str]:
    """How far a verdict on the rig is one on track."""
    words = [one["rig_like_track"]["fidelity"] for one in numbers["stops"].values()]
    differ = [
        f"{stop} ({NAMES[name]})"
        for stop, own in numbers["stops"].items()
        for name, one in own["criteria"].items()
        if {one[on]["verdict"] for on in SUPPORTS if on in one} == {"met", "not met"}
    ]
    met, against, open_ = (words.count(word) for word in ("met", "not met", "not decided"))
    yield (
        f"The rig does as the track within the targets of the command adhesion in {met} of {len(words)} stops, not in {against}, "
        f"not decided in {open_}: a verdict on the rig is one of the test on the rig. "
        f"Opposite verdicts on track and rig: {', '.join(differ).replace('_', ' ') or 'none'}."
    )


def _sum_lines(numbers: Numbers) -> Iterator[str]:
    for on in SUPPORTS:
        one = numbers["sums"][on]
        flat = one["flat_length_m"]
        where = "track" if on == "track" else "the rig"
        yield (
            f"All stops on {where}: {number(one['distance_m'])} m, {number(one['air_litres'])} l of "
            f"air, {number(one['dump_cycles'])} ventings; longest lock {number(one['longest_lock_s'], 3)} s, longest flat "
            f"{number(1e3 * flat, 2) if flat is not None else '–'} mm (an estimate)."
        )


def value_text(name: str, one: Numbers) -> str:
    """Mean of a criterion, its interval, and the worst test where each counts."""
    if one["mean"] is None:
        return "–"
    unit, factor = UNITS.get(name, ("", 1.0))
    text = number(factor * one["mean"], 3)
    if one["low"] is not None and one["high"] is not None and one["low"] != one["high"]:
        text += f" ({number(factor * one['low'], 3)} … {number(factor * one['high'], 3)})"
    if CRITERIA[name].every and one["worst"] is not None:  # type: ignore[index]
        text += f", worst {number(factor * one['worst'], 3)}"
    return f"{text} {unit}".rstrip()


def limit_text(name: str, one: Numbers) -> str:
    """A limit."""
    unit, factor = UNITS.get(name, ("", 1.0))
    each = " in each test" if CRITERIA[name].every else ""  # type: ignore[index]
    return f"{one['kind']} {number(factor * one['limit'], 3)} {unit}".rstrip() + each


FIRST = ("distance_m", "increase_over_dry", "k_wet", "mean_deceleration_mps2", "air_litres", "dump_cycles")
SECOND = ("adhesion_utilisation", "large_slip_share", "longest_lock_s", "flat_length_m")

CLAIMS = (
    NOT_QUOTED,
    "K_wet is 100 / (100 + increase over dry in %). Distances run from the demand to motion.stop_speed, at which the train "
    "counts as stationary; below 2 m/s no slip and no lock is counted.",
    "The length of a flat is an estimate of its order, from the energy dissipated under a locked wheel, (H1) and (H2) of "
    "docs/theory/wheel_flats.md; on the rig it is that of the train which the rig stands for, whose wheels would slide.",
    "Intervals are of 95 %, of the mean over starts whose first speeds differ by up to 3 mm/s: the limit cycle's phase. They say "
    "nothing of what differs from one vehicle, rail or day to another.",
    "Eight tests out of eight within a limit say with 95 % that at least 69 % of all such tests are.",
)


def wsp_sections(programme: Programme, results: Mapping[str, Any], numbers: Numbers) -> list[Section]:
    """All sections of the report."""
    return [
        Section("Verdict", [_overview(programme, numbers), _sums(numbers)]),
        Section("Criteria", [_criteria_table(numbers)]),
        Section("Stops", [*_stop_tables(numbers), *_pictures(results, numbers)]),
        *_each_stop(results, numbers),
        Section("What is not claimed", [Text(text) for text in CLAIMS]),
        Section("Programme", [Preformatted(f"The whole programme: {programme.name}", to_toml(programme))]),
    ]


def _shown(word: str | None) -> str:
    return "–" if word is None else SHOWN[word]


def _overview(programme: Programme, numbers: Numbers) -> Table:
    described = {stop.name: stop.description for stop in programme.stop}
    rows = []
    for name, one in numbers["stops"].items():
        same = one["rig_like_track"]
        words = [_shown(one[on]["verdict"]) for on in SUPPORTS]
        text = ", ".join(filter(None, (one["kind"], f"{one['speed_kmh']:.4g} km/h", described[name])))
        rows.append((*words, name.replace("_", " "), text, _shown(same["tracking"]), _shown(same["fidelity"])))
    header = ("on track", "on the rig", "stop", "", "rig follows its virtual axles", "rig as the track")
    return Table(header, rows, "All criteria of each stop; and the verdict on the rig itself.")


def _sums(numbers: Numbers) -> Table:
    names = ("distance_m", "air_litres", "dump_cycles", "longest_lock_s", "flat_length_m")
    entries: dict[str, Numbers] = {
        on: {f"sums.*.{name}": numbers["sums"][on][name] for name in names} for on in SUPPORTS
    }
    return QUANTITIES.table(
        entries, [f"sums.*.{name}" for name in names], "All stops: sums of means; worst of all tests.", ""
    )


def _criteria_table(numbers: Numbers) -> Table:
    rows = []
    for stop, own in numbers["stops"].items():
        for name, one in own["criteria"].items():
            found = [one.get(on, {"verdict": None, "mean": None, "why": ""}) for on in SUPPORTS]
            whys = dict.fromkeys(two["why"] for two in found if two["why"])
            rows.append((
                *(_shown(two["verdict"]) for two in found), stop.replace("_", " "), NAMES[name],
                *(value_text(name, two) for two in found), limit_text(name, one), one["clause"] or "–",
                "; ".join((*whys, one["origin"])),
            ))  # fmt: skip
    header = (
        "on track",
        "on the rig",
        "stop",
        "criterion",
        "track",
        "rig",
        "limit",
        "clause",
        "why nothing is decided; who set it",
    )
    return Table(
        header, rows, "Every criterion: means of all starts (intervals of 95 %)." if rows else "No limit is set."
    )


def _stop_tables(numbers: Numbers) -> Iterator[Table]:
    for names, caption in ((FIRST, "Distances, air, ventings."), (SECOND, "Sliding.")):
        labels = [QUANTITIES[f"stops.*.*.{name}.mean"].heading for name in names]
        rows = [
            (stop.replace("_", " "), on, *(_ends_text(name, own[on][name]) for name in names))
            for stop, own in numbers["stops"].items()
            for on in SUPPORTS
        ]
        yield Table(("stop", "on", *labels), rows, f"{caption} Means of all starts, with intervals of 95 %.")


def _ends_text(name: str, one: Numbers) -> str:
    factor = QUANTITIES[f"stops.*.*.{name}.mean"].in_shown_unit(1.0)
    if one["mean"] is None:
        return "–"
    mean = number(factor * one["mean"])
    if one["low"] is None or one["high"] is None or one["low"] == one["high"]:
        return mean
    return f"{mean} ± {number(0.5 * factor * (one['high'] - one['low']), 2)}"


def _pictures(results: Mapping[str, Any], numbers: Numbers) -> Iterator[Block]:
    stops = numbers["stops"]
    dry = [one["track"]["dry_distance_m"] for one in stops.values()]
    caption = "Distance since the demand, mean and interval of 95 %, and the dry distance of the same speed and demand."
    yield Picture(
        "distances", means_with_intervals(list(stops), _ends(stops, "distance_m"), "distance [m]", dry=dry), caption
    )
    stopping = {name: one for name, one in stops.items() if one["track"]["k_wet"]["mean"] is not None}
    if stopping:
        limits = [one["criteria"].get("k_wet", {}).get("limit") for one in stopping.values()]
        caption = (
            "K_wet: dry distance over distance, mean and interval of 95 %; diamonds: least that the programme allows."
        )
        found = means_with_intervals(list(stopping), _ends(stopping, "k_wet"), "K_wet [-]", limits=limits)
        yield Picture("k_wet", found, caption)
    shares: dict[str, dict[str, NDArray[np.float64]]] = {
        name: {on: np.mean([test.slip_shares for test in one.tests[on].tests], axis=0) for on in SUPPORTS}
        for name, one in results.items()
    }
    caption = "Part of the time that the axles spent at a slip, mean of all starts, while the brake acts above 2 m/s."
    yield Picture("slip_histograms", slip_grid(SLIP_EDGES, shares), caption)


def _ends(stops: Mapping[str, Numbers], name: str) -> dict[str, list[Ends | None]]:
    return {on: [_three(one[on][name]) for one in stops.values()] for on in SUPPORTS}


def _three(one: Numbers) -> Ends | None:
    if one["mean"] is None:
        return None
    low, high = (np.nan if one[end] is None else one[end] for end in ("low", "high"))
    return one["mean"], low, high


def _each_stop(results: Mapping[str, Any], numbers: Numbers) -> Iterator[Section]:
    for name, one in results.items():
        own = numbers["stops"][name]
        rows = []
        for measure in MEASURED:
            heading = QUANTITIES[f"stops.*.*.{measure}.mean"].heading
            rows.append((heading, *(_ends_text(measure, own[on][measure]) for on in SUPPORTS)))
        table = Table(
            ("", *SUPPORTS),
            rows,
            f"Means of {own['track']['tests']} and {own['rig']['tests']} tests ± half an interval of 95 %.",
        )
        blocks: list[Block] = [table]
        if all(one.signals[on] for on in SUPPORTS):
            caption = f"{name.replace('_', ' ')}: the first tests on track and on the rig."
            blocks.insert(0, Picture(f"stop_{name}", stop_over_time(one.signals), caption))
        yield Section(f"Stop {name.replace('_', ' ')}", blocks)


QUICK_STOPS, QUICK_STARTS = 2, 2
"""Of a quick study."""


@dataclass(frozen=True)
class StopResult:
    """What a stop gave.

    Attributes:
        tests: by support.
        judged: its criteria on both supports.
        signals: of the first tests, by support.
        seconds: processor time of all its tests [s].
    """

    tests: Mapping[Support, StopTests]
    judged: Sequence[Judgement]
    signals: Mapping[Support, Mapping[str, Any]]
    seconds: float


Results = Mapping[str, StopResult]


@dataclass(frozen=True)
class WspStudy(Study[Results]):
    """A test programme for wheel slide protection.

    Attributes:
        case: of the rig.
        programme: stops and limits.
        starts: tests of each stop on each support; 0: as many as the programme asks for. With fewer nothing is decided.
        quick: only two starts of the first two stops: to see that everything works.
    """

    case: Case
    programme: Programme
    starts: int = 0
    quick: bool = False

    command = "wsp"
    quantities = QUANTITIES
    writes = ("tests_*.csv", "signals_*.csv")
    irrelevant = ("description", "source")

    def __post_init__(self) -> None:
        """Refuse a case that has no slide protection to be stop_record on a rig, and stops that it cannot do."""
        check_case(self.case, self.programme)

    @property
    def title(self) -> str:
        return f"{self.case.name}: wheel slide protection, programme {self.programme.name}"

    @property
    def mark(self) -> Mark | None:
        meaning = (
            f"{QUICK_STARTS} starts of the first {QUICK_STOPS} stops, whose numbers only show that everything works"
        )
        return Mark("quick", meaning) if self.quick else None

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
        return {stop.name: stop_case(self.case, self.programme, stop) for stop in self.stops}

    # ------------------------------------------------------------------------------------------------------- jobs

    def rounds(self, done: Done) -> Iterator[Round]:
        jobs: dict[str, Job] = {}
        for stop in self.stops:
            if stop.stops:
                dry = dry_case(self.case, self.programme, stop)
                jobs |= {_dry(self.case, stop, on): self._job(_on(dry, on), False) for on in SUPPORTS}
            for on in SUPPORTS:
                for k, case in enumerate(starts(_on(self.stop_cases[stop.name], on), self.count)):
                    jobs[_test(stop, on, k)] = self._job(case, k == 0)
        yield jobs

    def _job(self, case: Case, keep: bool) -> Job:
        return job(stop_record, case, self.programme.flat, keep)

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
        tests: dict[Support, StopTests] = {}
        signals: dict[Support, Mapping[str, Any]] = {}
        seconds = 0.0
        for on in SUPPORTS:
            made = [done.get(_test(stop, on, number)) for number in range(self.count)]
            records: list[StopRecord] = [one for one in made if one is not None]
            dry: StopRecord | None = done.get(_dry(self.case, stop, on)) if stop.stops else None
            tests[on] = StopTests(
                stop,
                on,
                self.stop_cases[stop.name],
                max(self.programme.starts, self.count),
                [one.test for one in records],
                None if dry is None else dry.test,
            )
            signals[on] = next((one.signals for one in records if one.signals), {})
            seconds += sum(one.seconds for one in records)
        judged = [
            one
            for on, other in zip(SUPPORTS, SUPPORTS[::-1], strict=True)
            if tests[on].tests
            for one in judgements(self.programme, tests[on], tests[other])
        ]
        return StopResult(tests, judged, signals, seconds)

    def statuses(self, results: Results) -> Sequence[str]:
        return [record.status for one in results.values() for tests in one.tests.values() for record in tests.tests]

    # ---------------------------------------------------------------------------------------------------- numbers

    def numbers(self, results: Results) -> dict[str, Any]:
        judged = [one for result in results.values() for one in result.judged]
        return {
            "case": self.case.name,
            "programme": self.programme.name,
            "starts": self.count,
            "starts_needed": self.programme.starts,
            "stops": {name: stop_numbers(one.tests, one.judged) for name, one in results.items()},
            "sums": sum_numbers([one.tests for one in results.values()], judged),
        }

    def summary(self, results: Results, numbers: Numbers) -> list[str]:
        return list(findings(numbers, len(self.programme.limit)))

    def timings(self, results: Results) -> Mapping[str, Mapping[str, float]]:
        each = {name: one.seconds for name, one in results.items()}
        return {"processor time of the tests [s]": {**each, "all": sum(each.values())}}

    def files(self, results: Results, numbers: Numbers) -> Mapping[str, Content]:
        found: dict[str, Content] = {}
        for name, one in results.items():
            found[f"tests_{name}.csv"] = test_rows(one.tests)
            found[f"signals_{name}.csv"] = signal_columns(one.signals)
        return found

    def sections(self, results: Results, numbers: Numbers) -> list[Section]:
        return wsp_sections(self.programme, results, numbers)


def _on(case: Case, support: Support) -> Case:
    return track_case(case) if support == "track" else case


def _test(stop: BrakedRun, support: Support, number: int) -> str:
    return f"{stop.name}, {support}, start {number + 1}"


def _dry(case: Case, stop: BrakedRun, support: Support) -> str:
    return f"{dry_name(case, stop)}, {support}"
