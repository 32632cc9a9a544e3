"""A test programme for wheel slide protection: every stop on track and on the rig, as ensembles, judged by limits.

Case of a rig with brake and slide protection, Programme -> [WspStudy] -> verdict per criterion, numbers per stop, CSV files
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from rollerrig.config import Case, Programme
from rollerrig.config.schema.programme import BrakedRun
from rollerrig.study.adhesion_variants import track_case
from rollerrig.study.ensemble import starts
from rollerrig.study.frame import Content, Study
from rollerrig.study.jobs import Done, Job, Round, job
from rollerrig.study.quantities import Numbers
from rollerrig.study.report import Mark, Section
from rollerrig.study.wsp_cases import check_case, dry_case, dry_name, stop_case
from rollerrig.study.wsp_numbers import QUANTITIES, signal_columns, stop_numbers, sum_numbers, test_rows
from rollerrig.study.wsp_record import StopRecord, stop_record
from rollerrig.study.wsp_report import wsp_sections
from rollerrig.study.wsp_text import findings
from rollerrig.study.wsp_verdicts import SUPPORTS, Judgement, StopTests, Support, judgements

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
                for number, case in enumerate(starts(_on(self.stop_cases[stop.name], on), self.count)):
                    jobs[_test(stop, on, number)] = self._job(case, number == 0)
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
