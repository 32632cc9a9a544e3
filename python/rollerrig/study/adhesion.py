"""The same brake or traction test on degraded track and on the dry rig that reproduces it, and why the two differ.

Case of a rig with [rig_control] -> [AdhesionStudy] -> ensembles on track and rig, variants of the rig -> verdict, causes

Tracking compares the rig's axles with the virtual train that they follow; fidelity compares the rig with the track, which also
contains what the virtual train leaves out. Every compared number is that of an ensemble, with its error: the limit cycle of the
slide protection has another phase in every test. Equations: docs/theory/rig_control.md.

The variants take one imperfection of the rig away after the other: pure rolling of the wheels on the rollers, then drives
without lag and limit, then known force and torque. The differences between them, and what remains between the last and the
track, add up to the whole: the causes. Tests on track with a later protection give the rig's equivalent dead time.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import xarray as xr

from rollerrig.analysis.equivalent_dead_time import DeadTime, predicted_dead_time
from rollerrig.analysis.rig_fidelity import by_own_motion, point_by_point
from rollerrig.analysis.slide_statistics import TestRecord, test_record
from rollerrig.config import Case
from rollerrig.simulation import simulate
from rollerrig.study.adhesion_causes import are_known, cause_shares
from rollerrig.study.adhesion_figures import adhesion_sections, axle_columns
from rollerrig.study.adhesion_laws import law_case, law_names, law_numbers
from rollerrig.study.adhesion_numbers import (
    QUANTITIES,
    cause_numbers,
    dead_time_numbers,
    run_numbers,
    variant_numbers,
)
from rollerrig.study.adhesion_text import findings, target_lines, verdict_lines
from rollerrig.study.adhesion_variants import STEPS, track_case, variant, variants_of
from rollerrig.study.adhesion_verdicts import GROUPS, Row, verdict_of, verdict_rows
from rollerrig.study.dead_time import dead_times, later_protection, measured_dead_time
from rollerrig.study.ensemble import distances, estimate, recorded, starts
from rollerrig.study.frame import Study
from rollerrig.study.jobs import Done, Round, job
from rollerrig.study.quantities import Numbers
from rollerrig.study.report import VIEW, Mark, Section

STARTS, QUICK_STARTS, MOST_STARTS = 8, 2, 40
"""Tests of an ensemble; of a quick study; and up to which they are added until the errors of the shares are small."""

WHOLE = ("track", "rig", "rolling")
"""Ensembles whose first test is kept as a whole, to be drawn."""

SECOND = "track, second"
"""Another start on track, kept as a whole: what it differs by is phase alone."""


@dataclass(frozen=True)
class Runs:
    """What was run.

    Attributes:
        whole: first tests as a whole, by name: track, rig, rolling and a second start on track.
        records: by name of the ensemble: track, rig, the variants of the rig, both with other creep laws.
        later: additional dead time of the protection [s] -> ensemble on track.
    """

    whole: Mapping[str, xr.Dataset]
    records: Mapping[str, Sequence[TestRecord]]
    later: Mapping[float, Sequence[TestRecord]]


@dataclass(frozen=True)
class AdhesionStudy(Study[Runs]):
    """A test on degraded track and on the rig.

    Attributes:
        case: of the rig.
        error_budget: also run the variants of the rig, the track with later protection, and other creep laws.
        quick: only two starts of each test: to see that everything works.
    """

    case: Case
    error_budget: bool = True
    quick: bool = False

    command = "adhesion"
    quantities = QUANTITIES
    writes = ("track*.nc", "rig*.nc", "axles*.csv", VIEW)
    irrelevant = ("description", "error_budget")

    def __post_init__(self) -> None:
        """Refuse a case that is not that of a rig which reproduces a test on track."""
        track_case(self.case)

    @property
    def title(self) -> str:
        return f"{self.case.name}: degraded track and the rig that reproduces it"

    @property
    def mark(self) -> Mark | None:
        meaning = f"only {QUICK_STARTS} starts of each test, whose numbers only show that everything works"
        return Mark("quick", meaning) if self.quick else None

    def cases(self) -> Mapping[str, Case]:
        return {"rig": self.case, "track": track_case(self.case)}

    @cached_property
    def predicted(self) -> DeadTime | None:
        """Equivalent dead time in closed form."""
        return predicted_dead_time(self.case) if self.error_budget else None

    # ------------------------------------------------------------------------------------------------------- jobs

    def rounds(self, done: Done) -> Iterator[Round]:
        count = QUICK_STARTS if self.quick else STARTS
        names = ("rig", *variants_of(self.case)) if self.error_budget else ("rig",)
        later = dead_times(self.case, self.predicted)
        whole = {name: job(simulate, self._case(name)) for name in WHOLE if name == "track" or name in names}
        whole[SECOND] = job(simulate, starts(self._case("track"), 2)[1])
        laws = law_names(self.case) if self.error_budget else ()
        yield {**whole, **self._tests(("track", *names, *map(_later, later), *laws), 0, count)}
        grown = ("track", "rig", *STEPS)
        while not self.quick and count < MOST_STARTS and not are_known(cause_shares(self._records(done, names))):
            yield self._tests(grown, count, count + STARTS)
            count += STARTS

    def _tests(self, names: Sequence[str], begin: int, end: int) -> Round:
        """Ensembles from one start to another; the first start of some is run as a whole."""
        cases = {name: starts(self._case(name), end) for name in names}
        return {
            _test(name, k): job(recorded, found[k])
            for name, found in cases.items()
            for k in range(begin, end)
            if not (k == 0 and name in WHOLE)
        }

    def _case(self, name: str) -> Case:
        if name.startswith(_later("")):
            return later_protection(track_case(self.case), float(name.removeprefix(_later(""))))
        if name == "track":
            return track_case(self.case)
        if (with_law := law_case(self.case, name)) is not None:
            return with_law
        return self.case if name == "rig" else variant(self.case, name)

    def _records(self, done: Done, names: Sequence[str]) -> dict[str, list[TestRecord]]:
        """What there is of each ensemble, in the order of the starts, up to the first one that is missing."""
        found: dict[str, list[TestRecord]] = {}
        for name in ("track", *names):
            first = [test_record(done[name], self._case(name))] if name in WHOLE and name in done else []
            while (next_one := done.get(_test(name, len(first)))) is not None:
                first.append(next_one)
            found[name] = first
        return found

    def collect(self, done: Done) -> Runs | None:
        if "track" not in done or "rig" not in done:
            return None
        names = ("rig", *variants_of(self.case), *law_names(self.case))
        records = {name: found for name, found in self._records(done, names).items() if found}
        delays = dead_times(self.case, self.predicted)
        later = self._records(done, [_later(delay) for delay in delays])
        whole = {name: done[name] for name in (*WHOLE, SECOND) if name in done}
        return Runs(whole, records, {delay: found for delay in delays if (found := later[_later(delay)])})

    def statuses(self, results: Runs) -> Sequence[str]:
        return [record.status for name in ("track", "rig") for record in results.records[name]]

    # ---------------------------------------------------------------------------------------------------- numbers

    def rows(self, results: Runs) -> list[Row]:
        """Of the verdict."""
        return verdict_rows(self.case, results.records["track"], results.records["rig"])

    def numbers(self, results: Runs) -> dict[str, Any]:
        records, whole, rows = results.records, results.whole, self.rows(results)
        others = {name: records[name] for name in variants_of(self.case) if name in records}
        own, on_track = (estimate(values) for values in distances((records["rig"], records["track"])))
        curve = {delay: estimate(values) for delay, (values, _) in _beside(results).items()}
        measured = measured_dead_time(own, {0.0: on_track, **curve}) if curve else None
        compared = {name: whole[name] for name in ("rig", SECOND) if name in whole}
        return {
            "case": self.case.name,
            "starts": min(len(records["track"]), len(records["rig"])),
            "verdict": {group: verdict_of(rows, group) for group in GROUPS},
            "verdicts": {row.key: row.as_dict() for row in rows},
            "track": run_numbers(records["track"], rig=False),
            "rig": run_numbers(records["rig"], rig=True),
            "variants": {name: variant_numbers(records["track"], found) for name, found in others.items()},
            "causes": cause_numbers(cause_shares(records)),
            "creep_laws": law_numbers(self.case, records),
            "dead_time": dead_time_numbers(self.predicted, measured, results.later),
            "point_by_point": {name: point_by_point(whole["track"], run) for name, run in compared.items()},
            "tracking_by_own_motion": by_own_motion(whole["rig"]),
        }

    def summary(self, results: Runs, numbers: Numbers) -> list[str]:
        return [
            *verdict_lines(self.rows(results)),
            *findings(numbers),
            *target_lines(self.rows(results)),
        ]

    def files(self, results: Runs, numbers: Numbers) -> Mapping[str, Any]:
        track, rig = results.whole["track"], results.whole["rig"]
        return {"track.nc": track, "rig.nc": rig, "axles.csv": axle_columns(track, rig)}

    def shown(self, results: Runs) -> Mapping[str, xr.Dataset]:
        return {"degraded track": results.whole["track"], "rig": results.whole["rig"]}

    def sections(self, results: Runs, numbers: Numbers) -> list[Section]:
        return adhesion_sections(self.case, self.rows(results), results.whole, results.records, numbers)


def _test(name: str, number: int) -> str:
    return f"{name}, start {number + 1}"


def _later(delay: float | str) -> str:
    return f"track, later by {delay}"


def _beside(results: Runs) -> dict[float, tuple[list[float], list[float]]]:
    """Additional dead time -> distances on track with it, and on the rig, as far as all ran."""
    return {delay: tuple(distances((found, results.records["rig"]))) for delay, found in results.later.items()}  # type: ignore[misc]
