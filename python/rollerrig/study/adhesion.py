"""The same brake or traction test on degraded track and on the dry rig that reproduces it, and why the two differ.

Case of a rig with [rig_control] -> [AdhesionStudy] -> ensembles on track and rig, variants of the rig -> assessment, causes

Tracking compares the rig's axles with the virtual train that they follow; fidelity compares the rig with the track, which also
contains what the virtual train leaves out. Every compared number is that of an ensemble, with its error: the limit cycle of the
slide protection has another phase in every test, and nobody knows adhesion, pads and load as exactly as a case states them. What
finer steps and samples change belongs to the error. Equations: docs/theory/rig_control.md.

The variants take one imperfection of the rig away after the other: their differences, and what remains between the last and the
track, are the causes. Tests on track with a later protection give the rig's equivalent dead time.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from rollerrig.analysis import slide_statistics as slides
from rollerrig.analysis.equivalent_dead_time import DeadTime, predicted_dead_time
from rollerrig.analysis.slide_statistics import TestRecord
from rollerrig.analysis.virtual_rail import patch_of, slipperiest_peak
from rollerrig.assembly.model import assemble
from rollerrig.cases import as_case
from rollerrig.common.formatting import percent
from rollerrig.config import Case
from rollerrig.plot import adhesion as figures
from rollerrig.plot.adhesion import cause_bars, dead_time_curve, slip_histograms
from rollerrig.results import COMPLETED
from rollerrig.simulation.run import simulate
from rollerrig.study import ensemble
from rollerrig.study.assessment import SHOWN
from rollerrig.study.ensemble import FINER_STARTS, Estimate, distances, measure, started
from rollerrig.study.frame import Outcome, Study
from rollerrig.study.jobs import Done, Progress, Round, job
from rollerrig.study.options import Processes, command
from rollerrig.study.quantities import Numbers, Quantities
from rollerrig.study.report import VIEW, Block, Picture, Section, Table
from rollerrig.study.runs import adhesion as runs
from rollerrig.study.runs.adhesion import CAUSES, GROUPS, STARTS, STEPS, VARIANTS, Row, track_case

QUANTITIES = Quantities("adhesion")
RUN, RIG = ([q.key.split(".")[1] for q in QUANTITIES.below(on) if q.key.endswith(".mean")] for on in ("*", "rig"))
"""Names of what is reported of both ensembles, and of that of the rig alone."""

VARIANT = ("tracking_rms", "mean_slip", "dump_cycles", "air_litres")
QUICK_STARTS, FIRST_STARTS, MORE_STARTS, MOST_STARTS = 2, 2, 2, 16
"""Tests of an ensemble of a quick study; before the first page; so many more at a time while the error of a share is too large;
and the most of an ensemble."""

WHOLE = ("track", "rig", "rolling")  # ensembles whose first test is kept as a whole, to be drawn
FINE = ", finer steps"  # after the name of an ensemble: its first tests with finer steps and samples
LATER = "track, later by "  # before the additional dead time of the protection [s], in the name of an ensemble


@dataclass(frozen=True)
class Runs:
    """What was run: first tests as a whole, and the records of each ensemble, by its name."""

    whole: Mapping[str, xr.Dataset]
    records: Mapping[str, Sequence[TestRecord]]


@dataclass(frozen=True)
class AdhesionStudy(Study[Runs]):
    """A test on degraded track and on the rig; attributes as the arguments of `rollerrig.adhesion`."""

    case: Case
    error_budget: bool = True
    quick: bool = False

    command = "adhesion"
    round_ends = (0.05, 0.8)
    heading = "{case.name}: degraded track and the rig that reproduces it"
    quick_means = f"only {QUICK_STARTS} starts of each test, whose numbers only show that everything works"
    writes = ("track*.nc", "rig*.nc", VIEW)
    irrelevant = ("description", "error_budget")

    def __post_init__(self) -> None:
        """Refuse a case that is not that of a rig which reproduces a test on track."""
        ensemble.check_ensemble(track_case(self.case))

    def cases(self) -> Mapping[str, Case]:
        return {"rig": self.case, "track": track_case(self.case)}

    @cached_property
    def predicted(self) -> DeadTime | None:
        """Equivalent dead time in closed form."""
        return predicted_dead_time(self.case) if self.error_budget else None

    @cached_property
    def later(self) -> dict[str, float]:
        """Ensemble on track with a later protection -> its additional dead time [s]."""
        return {f"{LATER}{delay}": delay for delay in ensemble.dead_times(self.case, self.predicted)}

    def rounds(self, done: Done) -> Iterator[Round]:
        count = QUICK_STARTS if self.quick else STARTS
        names = ("rig", *runs.variants_of(self.case)) if self.error_budget else ("rig",)
        whole = {name: job(simulate, self._case(name)) for name in WHOLE if name == "track" or name in names}
        fine = [] if self.quick else [f"{name}{FINE}" for name in ("track", *names) if name in ("track", "rig", *STEPS)]
        tests = self._tests(("track", *names, *self.later), 0, count)
        yield {**whole, **self._tests(("track", "rig"), 0, FIRST_STARTS)}
        yield {**tests, **self._tests(fine, 0, FINER_STARTS)}
        while not self.quick and (found := self.collect(done)) is not None and (more := self._more_starts(found)):
            yield more

    def _more_starts(self, results: Runs) -> Round:
        """Once, those on track and rig that decide rows; then the next of the ensembles whose share is not known yet.

        Once only: an interval that is looked at after each start ends outside of a limit more often than it says.
        """
        count = {name: len(records) for name, records in results.records.items()}
        needed = [row.starts_needed for row in self.rows(results) if STARTS < row.starts_needed <= MOST_STARTS]
        if needed and count["rig"] == STARTS:
            return self._tests(("track", "rig"), STARTS, math.ceil(max(needed)))
        found: Round = {}
        for pair in runs.to_refine(runs.cause_shares(results.records)):
            if (begin := min(count[name] for name in pair)) < MOST_STARTS:
                found = {**found, **self._tests(pair, begin, begin + MORE_STARTS)}
        return found

    def _tests(self, names: Sequence[str], begin: int, end: int) -> Round:
        """Ensembles from one start to another; the first start of some is run as a whole."""
        cases = {name: self._case(name) for name in names}
        jobs = ensemble.start_jobs(cases, lambda one, _: job(ensemble.recorded, one), end, begin)
        return {name: one for name, one in jobs.items() if name not in [ensemble.start_name(one, 0) for one in WHOLE]}

    def _case(self, name: str) -> Case:
        if name.endswith(FINE):
            return ensemble.finer(self._case(name.removesuffix(FINE)))
        if name in self.later:
            return ensemble.later_protection(track_case(self.case), self.later[name])
        if name == "track":
            return track_case(self.case)
        return self.case if name == "rig" else runs.variant(self.case, name)

    def collect(self, done: Done) -> Runs | None:
        """What there is of each ensemble, in the order of the starts, up to the first one that is missing."""
        if "track" not in done or "rig" not in done:
            return None
        whole = {name: done[name] for name in WHOLE if name in done}
        first = {name: [slides.test_record(run, self._case(name))] for name, run in whole.items()}
        names = ("track", "rig", *runs.variants_of(self.case))
        names = (*names, *(f"{name}{FINE}" for name in names), *self.later)
        return Runs(whole, {name: found for name in names if (found := started(done, name, first.get(name, ())))})

    def statuses(self, results: Runs) -> Sequence[str]:
        return [record.status for name in ("track", "rig") for record in results.records[name]]

    def rows(self, results: Runs) -> list[Row]:
        """Rows of the assessment."""
        tests, fine = ([results.records.get(f"{on}{end}", ()) for on in ("track", "rig")] for end in ("", FINE))
        return runs.assessment_rows(self.case, (tests[0], tests[1]), (fine[0], fine[1]))

    def numbers(self, results: Runs) -> dict[str, Any]:
        records, rows = results.records, self.rows(results)
        variants = [name for name in runs.variants_of(self.case) if name in records]
        peak = slipperiest_peak(self.case, patch_of(assemble(self.case)), self.case.motion.speed)
        return {
            "case": self.case.name,
            "starts": min(len(records["track"]), len(records["rig"])),
            "fine_starts": len(records.get(f"rig{FINE}", ())),
            "creep_peak": dict(zip(("slip", "adhesion"), peak, strict=True)),
            "outcome": {group: runs.outcome_of(rows, group) for group in GROUPS},
            "outcomes": {row.key: row.as_dict() for row in rows},
            "track": _run_numbers(records["track"], RUN),
            "rig": _run_numbers(records["rig"], [*RUN, *RIG]),
            "variants": {name: _variant_numbers(records["track"], records[name]) for name in variants},
            "causes": {name: {**share.as_dict(), "within_its_error": runs.is_within_error(share)}
                       for name, share in _shares(records).items()},
            "dead_time": self._dead_time_numbers(records),
        }  # fmt: skip

    def _dead_time_numbers(self, records: Mapping[str, Sequence[TestRecord]]) -> dict[str, Any]:
        """Numbers of the equivalent dead time; empty where nothing is predicted."""
        if (predicted := self.predicted) is None:
            return {}
        found: dict[str, Any] = {f"{name}_s": getattr(predicted, name) for name in ("torque", "drive", "least")}
        found["predicted_s"] = predicted.total
        later = {self.later[name]: records[name] for name in self.later if name in records}
        if later:
            tracks = {0.0: records["track"], **later}
            own, base, *others = distances((records["rig"], *tracks.values()))
            ways = {d: ensemble.difference(way, base) for d, way in zip(tracks, (base, *others), strict=True)}
            found["measured"] = ensemble.measured_dead_time(ensemble.difference(own, base), ways).as_dict()
            found["track"] = {
                f"{1e3 * delay:g}": {name: measure(tests, name).as_dict() for name in ("distance_m", "dump_cycles")}
                for delay, tests in later.items()
            }
        return found

    def summary(self, results: Runs, numbers: Numbers) -> list[str]:
        rows = self.rows(results)
        of_groups = {group: [row for row in rows if row.group == group] for group in GROUPS}
        outcomes = [
            f"{title}: {SHOWN[numbers['outcome'][group]]}; {sum(row.outcome == 'met' for row in of_groups[group])} of "
            f"{len(of_groups[group])} targets met."
            for group, title in GROUPS.items()
        ]
        worst_first = sorted(rows, key=lambda row: ("not met", "not decided", "met").index(row.outcome))
        return [*outcomes, *(row.told for row in worst_first), *slides.idle_valves(self.case), *_findings(numbers)]

    def files(self, results: Runs, numbers: Numbers) -> Mapping[str, Any]:
        return {"track.nc": results.whole["track"], "rig.nc": results.whole["rig"]}

    def shown(self, results: Runs) -> Mapping[str, xr.Dataset]:
        return {"degraded track": results.whole["track"], "rig": results.whole["rig"]}

    def sections(self, results: Runs, numbers: Numbers) -> list[Section]:
        lines = [(SHOWN[r.outcome], r.group, r.text, r.value_text, r.target_text, r.origin) for r in self.rows(results)]
        header = ("", "", "what", "mean of all starts (95 % interval)", "target", "where the target comes from")
        sections = [Section("Assessment", [Table(header, lines)])]
        if numbers["causes"]:
            sections.append(_causes(numbers))
        if numbers["dead_time"]:
            sections.append(_dead_time(numbers))
        shares = {on: np.mean([one.slip_shares for one in results.records[on]], axis=0) for on in ("track", "rig")}
        caption = "Part of the time that the axles spent at a slip, mean of all starts, while brake or traction act."
        histogram = Picture("slip_histogram", slip_histograms(slides.SLIP_EDGES, {"": shares}), caption)
        means = {on: numbers[on] for on in ("track", "rig")}
        names = [*(f"*.{name}.mean" for name in RUN), *(f"rig.{name}.mean" for name in RIG)]
        return [
            *sections,
            Section("Slip", [histogram]),
            Section("Numbers", [QUANTITIES.list_table(means, names, "Means of all starts, with intervals of 95 %.")]),
            Section("First tests", [Picture(*one) for one in _signals(self.case, results.whole)]),
        ]


def _run_numbers(records: Sequence[TestRecord], names: Sequence[str]) -> dict[str, Any]:
    return {
        "status": records[0].status,
        "status_message": records[0].message,
        "completed": sum(record.completed for record in records),
        "stopped": sum(record.stopped for record in records),
        **{name: measure(records, name).as_dict() for name in names},
    }


def _variant_numbers(track: Sequence[TestRecord], records: Sequence[TestRecord]) -> dict[str, Any]:
    on_track, own = distances((track, records))
    found = {name: measure(records, name).as_dict() for name in VARIANT}
    return {"tests": len(records), "distance_relative": ensemble.relative(own, on_track).as_dict(), **found}


def _shares(records: Mapping[str, Sequence[TestRecord]]) -> dict[str, Estimate]:
    """Shares of the causes, with what finer steps change in their intervals; empty where an ensemble is missing."""
    shares = runs.cause_shares(records) or {}
    names = ("track", "rig", *STEPS)
    fine = {name: records.get(f"{name}{FINE}", ()) for name in names}
    count = min(len(one) for one in fine.values())
    if not (shares and count):
        return shares
    close, coarse = (runs.cause_shares({name: own[name][:count] for name in names}) or {} for own in (fine, records))
    return {name: ensemble.stepped(one, coarse[name], close[name]) for name, one in shares.items()}


def _findings(numbers: Numbers) -> Iterator[str]:
    """Sentences after the assessment."""
    fine = "contain" if numbers["fine_starts"] else "do not contain"
    yield (
        f"Rig and track are compared by means over {numbers['starts']} starts each, drawn by [ensemble], not point by point: the "
        f"protection's limit cycle has another phase in every test. Intervals of 95 % {fine} what finer steps and samples change."
    )
    causes, found = numbers["causes"], numbers["dead_time"]
    if causes:
        shares = {CAUSES.get(name, "Causes of the difference in distance,"): one for name, one in causes.items()}
        whole, *parts = (
            f"{text} {percent(one['mean'], signed=True)} ± {percent(one['standard_error'])}"
            + (" (not distinguishable from zero)" if one["within_its_error"] else "")
            for text, one in sorted(
                shares.items(), key=lambda pair: (pair[0] in CAUSES.values(), -abs(pair[1]["mean"] or 0.0))
            )
        )
        yield f"{whole}: {', '.join(parts)}."
    if found:
        measured = ""
        if "measured" in found:
            told = QUANTITIES["dead_time.measured.mean"].told(found["measured"])
            none = "none, no track that was run has the rig's distance"
            measured = f"; measured: {none if found['measured']['mean'] is None else told}"
        predicted, torque, drive = (
            QUANTITIES[f"dead_time.{name}_s"].cell(found[f"{name}_s"]) for name in ("predicted", "torque", "drive")
        )
        yield (
            f"Equivalent dead time: the rig acts like a track whose protection has {predicted} ms more in closed form, {torque} "
            f"ms of the axle's torque and {drive} ms of the drives{measured}."
        )
    for label in ("track", "rig"):
        if numbers[label]["status"] not in COMPLETED:
            yield f"{label}: {numbers[label]['status_message']}"


def _causes(numbers: Numbers) -> Section:
    causes = {CAUSES.get(name, name): one for name, one in numbers["causes"].items()}
    caption = (
        "Part of the difference in mean distance that goes away with each imperfection, one after the other; standard errors. "
        "Hollow: inside its error of 95 %, not distinguishable from zero."
    )
    found = {text: numbers["variants"][name] for name, text in VARIANTS.items() if name in numbers["variants"]}
    names = [f"variants.*.{name}.mean" for name in ("distance_relative", *VARIANT)]
    more = "Each of the lines after the first takes one more imperfection away; intervals of 95 %."
    shares = QUANTITIES.table(causes, "causes.*", "Shares of the distance on track.", "cause")
    variants = QUANTITIES.table(found, names, more, "run")
    return Section("Why rig and track differ", [Picture("causes", cause_bars(causes), caption), shares, variants])


def _dead_time(numbers: Numbers) -> Section:
    found, blocks = numbers["dead_time"], list[Block]()
    if "track" in found:
        own = {on: numbers[on]["distance_m"] for on in ("track", "rig")}
        curve = {0.0: own["track"]} | {float(delay): one["distance_m"] for delay, one in found["track"].items()}
        caption = (
            "Mean distance on track with more dead time of the protection, on the rig: where the curve has the rig's distance "
            "is its equivalent dead time. Dashed: in closed form, (D17); dotted: (Q8). Standard errors."
        )
        drawn = dead_time_curve(curve, own["rig"], (1e3 * found["predicted_s"], 1e3 * found["least_s"]))
        blocks.append(Picture("dead_time", drawn, caption))
    names = [f"dead_time.{name}" for name in ("predicted_s", "torque_s", "drive_s", "least_s", "measured.mean")]
    return Section("Equivalent dead time", [*blocks, QUANTITIES.list_table({"": found}, names)])


def _signals(case: Case, whole: Mapping[str, xr.Dataset]) -> Iterator[tuple[str, Figure, str]]:
    """Signals of the first tests; from the first slides on their limit cycles have different phases."""
    radius = slides.wheel_radius(whole["rig"])
    yield "speeds", figures.speeds(whole["track"], whole["rig"], radius), "Train and wheels: rig, virtual train, track."
    runs = {name: slides.under_test(run) for name, run in whole.items()}
    both = {name: runs[name] for name in ("rig", "track")}
    if case.brake is not None:
        drawn = figures.axles_over_time(both, figures.BRAKE, 6.0)
        yield "brakes", drawn, "Cylinder pressure, dump cycles, air taken."
    if case.traction is not None:
        drawn = figures.axles_over_time(both, figures.TRACTION, 4.4)
        yield "traction", drawn, "Torque of the motors, and the part of the demand that is left."
    used = ("creep force\nover static load [-]", "creep_force", 1.0 / slides.axle_load(both["rig"]))
    yield "adhesion", figures.axles_over_time(both, [used], 3.2), "Force on each axle over its static load."
    drawn = figures.axles_over_time({"rig": both["rig"]}, figures.ROLLERS, 2.8)
    yield "roller_drives", drawn, "Torque of the roller drives, positive forward."
    text = (
        "Full: the rig with its contact model; dashed: wheels that roll on the rollers without sliding. Below, the wheelsets' "
        "own motion along the track: the bogie swings on its traction rod, which the control law does not know, and the wheels "
        "turn by it (D14)."
    )
    yield "sliding", figures.sliding(both["rig"], runs.get("rolling"), radius), text


@command
def adhesion(
    case: Case | str,
    *,
    error_budget: bool = True,
    quick: bool = False,
    processes: Processes = 1,
    progress: Progress | None = None,
) -> Outcome[Runs]:
    """A brake or traction test on degraded track and on the dry rig that reproduces it, side by side.

    Args:
        case: case on rollers with [rig_control]: a name of the catalogue or a TOML file.
        error_budget: also run the rig without one imperfection after the other, and the track with later protection.
        quick: two starts of each test: to see that everything works.
        processes: runs at a time; more than 1 asks a script for `if __name__ == "__main__":`.
        progress: called with the fraction done and a short text.

    Raises:
        ConfigError: the case is no such test.
        StartError: a case finds no equilibrium to start from.
    """
    return AdhesionStudy(as_case(case), error_budget, quick).outcome(processes, progress)
