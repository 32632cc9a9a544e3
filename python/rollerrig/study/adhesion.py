"""The same brake or traction test on degraded track and on the dry rig that reproduces it, and why the two differ.

Case of a rig with [rig_control] -> [AdhesionStudy] -> ensembles on track and rig, variants of the rig -> assessment, causes

Tracking compares the rig's axles with the virtual train that they follow; fidelity compares the rig with the track, which also
contains what the virtual train leaves out. Every compared number is that of an ensemble, with its error: the limit cycle of the
slide protection has another phase in every test, and nobody knows adhesion, pads and load as exactly as a case states them. Some
tests are made again with finer steps and samples, what they change belongs to the error. Equations:
docs/theory/rig_control.md.

The variants take one imperfection of the rig away after the other: pure rolling of the wheels on the rollers, then drives
without lag and limit, then known force and torque. The differences between them, and what remains between the last and the
track, add up to the whole within their errors: the causes. Tests on track with a later protection give the rig's equivalent
dead time.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

from rollerrig.analysis import slide_statistics as slides
from rollerrig.analysis.equivalent_dead_time import DeadTime, predicted_dead_time
from rollerrig.analysis.slide_statistics import TestRecord
from rollerrig.analysis.virtual_rail import patch_of, slipperiest_peak
from rollerrig.assembly.model import assemble
from rollerrig.common.formatting import number, percent
from rollerrig.config import Case
from rollerrig.plot import adhesion as figures
from rollerrig.plot.adhesion import cause_bars, dead_time_curve, slip_histogram
from rollerrig.results import COMPLETED
from rollerrig.simulation.run import simulate
from rollerrig.study import ensemble
from rollerrig.study.assessment import NOT_DECIDED, SHOWN
from rollerrig.study.ensemble import FINER_STARTS, Estimate, distances, measure, started, with_error
from rollerrig.study.frame import Study
from rollerrig.study.jobs import Done, Round, job
from rollerrig.study.quantities import Numbers, Quantities
from rollerrig.study.report import VIEW, Block, Picture, Section, Table
from rollerrig.study.runs import adhesion as runs
from rollerrig.study.runs.adhesion import CAUSES, GROUPS, STEPS, VARIANTS, Row, track_case

QUANTITIES = Quantities("adhesion")
RUN, RIG = ([q.key.split(".")[1] for q in QUANTITIES.below(on) if q.key.endswith(".mean")] for on in ("*", "rig"))
"""Names of what is reported of both ensembles, and of that of the rig alone."""

VARIANT = ("tracking_rms", "mean_slip", "dump_cycles", "air_litres")
STARTS, QUICK_STARTS, FIRST_STARTS, MORE_STARTS, MOST_STARTS = 8, 2, 2, 2, 16
"""Tests of an ensemble; of a quick study; before the first page; so many more at a time while the error of a share is too large;
and the most of an ensemble."""

WHOLE = ("track", "rig", "rolling")
"""Ensembles whose first test is kept as a whole, to be drawn."""

FINE = ", finer steps"
"""After the name of an ensemble: its first tests with finer steps and samples."""

LATER = "track, later by "
"""Before the additional dead time of the protection [s], in the name of an ensemble."""


@dataclass(frozen=True)
class Runs:
    """What was run.

    Attributes:
        whole: first tests as a whole, by name: track, rig, rolling and a second start on track.
        records: by name of the ensemble: track, rig, the variants of the rig.
        later: additional dead time of the protection [s] -> ensemble on track.
    """

    whole: Mapping[str, xr.Dataset]
    records: Mapping[str, Sequence[TestRecord]]
    later: Mapping[float, Sequence[TestRecord]]


@dataclass(frozen=True)
class AdhesionStudy(Study[Runs]):
    """A test on degraded track and on the rig; attributes as the arguments of `rollerrig.adhesion`."""

    case: Case
    error_budget: bool = True
    quick: bool = False

    command = "adhesion"
    round_ends = (0.05, 0.8)
    heading = "{case.name}: degraded track and the rig that reproduces it"
    quantities = QUANTITIES
    quick_means = f"only {QUICK_STARTS} starts of each test, whose numbers only show that everything works"
    writes = ("track*.nc", "rig*.nc", "axles*.csv", VIEW)
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

    def rounds(self, done: Done) -> Iterator[Round]:
        count = QUICK_STARTS if self.quick else STARTS
        names = ("rig", *runs.variants_of(self.case)) if self.error_budget else ("rig",)
        later = [f"{LATER}{delay}" for delay in ensemble.dead_times(self.case, self.predicted)]
        whole = {name: job(simulate, self._case(name)) for name in WHOLE if name == "track" or name in names}
        fine = [] if self.quick else [f"{name}{FINE}" for name in ("track", *names) if name in ("track", "rig", *STEPS)]
        tests = self._tests(("track", *names, *later), 0, count)
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
        if name.startswith(LATER):
            return ensemble.later_protection(track_case(self.case), float(name.removeprefix(LATER)))
        if name == "track":
            return track_case(self.case)
        return self.case if name == "rig" else runs.variant(self.case, name)

    def _records(self, done: Done, names: Sequence[str]) -> dict[str, list[TestRecord]]:
        """What there is of each ensemble, in the order of the starts, up to the first one that is missing."""
        whole = {name: [slides.test_record(done[name], self._case(name))] for name in WHOLE if name in done}
        return {name: started(done, name, whole.get(name, ())) for name in ("track", *names)}

    def collect(self, done: Done) -> Runs | None:
        if "track" not in done or "rig" not in done:
            return None
        names = ("rig", *runs.variants_of(self.case))
        fine = [f"{name}{FINE}" for name in ("track", "rig", *STEPS)]
        records = {name: found for name, found in self._records(done, (*names, *fine)).items() if found}
        delays = ensemble.dead_times(self.case, self.predicted)
        later = self._records(done, [f"{LATER}{delay}" for delay in delays])
        whole = {name: done[name] for name in WHOLE if name in done}
        return Runs(whole, records, {delay: found for delay in delays if (found := later[f"{LATER}{delay}"])})

    def statuses(self, results: Runs) -> Sequence[str]:
        return [record.status for name in ("track", "rig") for record in results.records[name]]

    def rows(self, results: Runs) -> list[Row]:
        """Rows of the assessment."""
        tests, fine = ([results.records.get(f"{on}{end}", ()) for on in ("track", "rig")] for end in ("", FINE))
        return runs.verdict_rows(self.case, (tests[0], tests[1]), (fine[0], fine[1]))

    def numbers(self, results: Runs) -> dict[str, Any]:
        records, rows = results.records, self.rows(results)
        variants = [name for name in runs.variants_of(self.case) if name in records]
        shares = _shares(records)
        peak = slipperiest_peak(self.case, patch_of(assemble(self.case)), self.case.motion.speed)
        return {
            "case": self.case.name,
            "starts": min(len(records["track"]), len(records["rig"])),
            "fine_starts": len(records.get(f"rig{FINE}", ())),
            "creep_peak": dict(zip(("slip", "adhesion"), peak, strict=True)),
            "verdict": {group: runs.verdict_of(rows, group) for group in GROUPS},
            "verdicts": {row.key: row.as_dict() for row in rows},
            "track": _run_numbers(records["track"], RUN),
            "rig": _run_numbers(records["rig"], [*RUN, *RIG]),
            "variants": {name: _variant_numbers(records["track"], records[name]) for name in variants},
            "causes": {name: {"share": share.mean, "standard_error": share.standard_error, **vars(share.interval),
                              "within_its_error": runs.is_within_error(share)} for name, share in shares.items()},
            "dead_time": self._dead_time_numbers(results),
            "tracking_by_own_motion": slides.by_own_motion(results.whole["rig"]),
        }  # fmt: skip

    def _dead_time_numbers(self, results: Runs) -> dict[str, Any]:
        """Numbers of the equivalent dead time; empty where nothing is predicted."""
        predicted, records = self.predicted, results.records
        if predicted is None:
            return {}
        found: dict[str, Any] = {
            "predicted_s": predicted.total,
            "torque_s": predicted.torque,
            "drive_s": predicted.drive,
            "least_s": predicted.least,
        }
        if results.later:
            delays = sorted(results.later)
            own, *curve = distances((records["rig"], records["track"], *(results.later[d] for d in delays)))
            tracks = {0.0: curve[0], **dict(zip(delays, curve[1:], strict=True))}
            measured = ensemble.measured_dead_time(
                ensemble.difference(own, curve[0]),
                {d: ensemble.difference(way, curve[0]) for d, way in tracks.items()},
            )
            found |= {"measured_s": measured.mean, "standard_error_s": measured.standard_error}
            found |= {"low_s": measured.interval.low, "high_s": measured.interval.high}
        for delay, tests in results.later.items():
            one = measure(tests, "distance_m")
            found.setdefault("track", {})[f"{1e3 * delay:g}"] = {
                "distance_m": one.mean,
                "standard_error_m": one.standard_error,
                "dump_cycles": measure(tests, "dump_cycles").mean,
            }
        return found

    def summary(self, results: Runs, numbers: Numbers) -> list[str]:
        rows = self.rows(results)
        lines = [f"{SHOWN[row.verdict]}, {row.group}: {row.told}" for row in rows]
        enough = numbers["starts"] >= STARTS
        return [
            *_verdict_lines(rows),
            *_how_sure(rows, numbers["starts"]),
            *(_starts_needed(rows) if enough else ()),
            *slides.idle_valves(self.case),
            *findings(numbers),
            *lines,
        ]

    def files(self, results: Runs, numbers: Numbers) -> Mapping[str, Any]:
        track, rig = results.whole["track"], results.whole["rig"]
        return {"track.nc": track, "rig.nc": rig, "axles.csv": _axle_columns(track, rig)}

    def shown(self, results: Runs) -> Mapping[str, xr.Dataset]:
        return {"degraded track": results.whole["track"], "rig": results.whole["rig"]}

    def sections(self, results: Runs, numbers: Numbers) -> list[Section]:
        lines = [(SHOWN[r.verdict], r.group, r.text, r.value_text, r.target_text, r.origin) for r in self.rows(results)]
        header = ("", "", "what", "mean of all starts (95 % interval)", "target", "where the target comes from")
        sections = [Section("Assessment", [Table(header, lines)])]
        if numbers["causes"]:
            sections.append(_causes(numbers))
        if numbers["dead_time"]:
            sections.append(_dead_time(numbers))
        shares = {on: np.mean([one.slip_shares for one in results.records[on]], axis=0) for on in ("track", "rig")}
        caption = "Part of the time that the axles spent at a slip, mean of all starts, while brake or traction act."
        histogram = Picture("slip_histogram", slip_histogram(slides.SLIP_EDGES, shares), caption)
        pictures = _signals(self.case, results.whole)
        return [
            *sections,
            Section("Slip", [histogram]),
            _numbers(numbers),
            *(Section(picture.name.replace("_", " ").capitalize(), [picture]) for picture in pictures),
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


def _axle_columns(track: xr.Dataset, rig: xr.Dataset) -> dict[str, ArrayLike]:
    """Speeds and forces of each axle, rig beside track, as long as both ran."""
    count = min(track.sizes["time"], rig.sizes["time"])
    both = ("axle_speed", "cylinder_pressure", "contact_force", "creep_force", "brake_torque", "traction_torque")
    columns = {"time_s": rig["time"], "train_speed_track": track["train_speed"], "train_speed_rig": rig["train_speed"]}
    for name in (*both, "virtual_speed", "real_sliding", "roller_torque"):
        for axle in rig["axle"].to_numpy():
            for label, run in (("track", track), ("rig", rig)):
                if label == "rig" or name in both:
                    columns[f"{name}_{axle}_{label}"] = run[name].sel(axle=axle)
    return {name: column.to_numpy()[:count] for name, column in columns.items()}


def _verdict_lines(rows: Sequence[Row]) -> Iterator[str]:
    """The outcome of each group, and what is not met or not decided."""
    for group, title in GROUPS.items():
        own, word = [row for row in rows if row.group == group], runs.verdict_of(rows, group)
        met = sum(row.verdict == "met" for row in own)
        open_ones = sorted((row for row in own if row.verdict != "met"), key=lambda row: row.verdict != "not met")
        yield f"{title}: {word.upper() if word == 'not met' else word}; {met} of {len(own)} targets met." + "".join(
            f" {SHOWN[row.verdict]}: {row.told}." for row in open_ones
        )


def _how_sure(rows: Sequence[Row], starts: int) -> Iterator[str]:
    """Distance and dump cycles with their intervals, whatever their outcome."""
    found = [f"{row.text} {row.value_text}" for row in rows if row.key in ("distance", "dump_cycles")]
    if found:
        yield f"Rig less track, means of {starts} starts with intervals of 95 %: {'; '.join(found)}."


def _starts_needed(rows: Sequence[Row]) -> Iterator[str]:
    """How many starts would decide what is not decided, the fewest first."""
    needed = {row.text: row.starts_needed for row in rows if row.verdict == NOT_DECIDED}
    found = [
        f"{text} about {count:g}" for text, count in sorted(needed.items(), key=lambda one: one[1]) if count < math.inf
    ]
    if found:
        yield f"More starts would decide, if mean and scatter stay: {'; '.join(found)} starts. {MOST_STARTS} at most are made."


def findings(numbers: Numbers) -> Iterator[str]:
    """Sentences after the assessment."""
    fine = f"contain what a quarter of step and samples changes in {numbers['fine_starts']} of them"
    yield (
        f"The protection's limit cycle has another phase in every test: rig and track are compared by means over "
        f"{numbers['starts']} starts each, drawn by [ensemble], not point by point; their intervals of 95 % "
        f"{fine if numbers['fine_starts'] else 'do not contain what step and samples change'}."
    )
    row = numbers["verdicts"].get("regrip_adhesion")
    if row is not None and row["verdict"] == "not met":
        track, rig = (number(numbers[where]["regrip_adhesion"]["mean"], 3) for where in ("track", "rig"))
        force = f"the largest force on an axle that has slid is {track} of its load on track, {rig} on the rig"
        yield f"Readhesion is not reproduced: {force}."
    counted = numbers["track"]["odometer_error_m"]["mean"]
    if counted and numbers["track"]["beyond_peak_s"]["mean"]:
        most = number(numbers["track"]["reference_speed_error_largest_mps"]["mean"], 2)
        yield (
            f"The train's odometer, the reference speed of its slide protection integrated, counts {abs(counted):.3g} m "
            f"{'more' if counted > 0.0 else 'less'} on track than the {number(numbers['track']['distance_m']['mean'])} m that "
            f"the train runs; that speed is off by up to {most} m/s."
        )
    if numbers["causes"]:
        yield from _cause_lines(numbers)
    if numbers["dead_time"]:
        yield _dead_time_line(numbers["dead_time"])
    for label in ("track", "rig"):
        if numbers[label]["status"] not in COMPLETED:
            yield f"{label}: {numbers[label]['status_message']}"


def _cause_lines(numbers: Numbers) -> Iterator[str]:
    causes = numbers["causes"]
    known = sorted((n for n in CAUSES if not causes[n]["within_its_error"]), key=lambda n: -abs(causes[n]["share"]))
    hidden = [name for name in CAUSES if causes[name]["within_its_error"]]
    text = ", ".join(f"{CAUSES[name]} {_share_text(causes[name])}" for name in known) or "none is larger than its error"
    text += f"; not distinguishable from zero: {', '.join(CAUSES[name] for name in hidden)}" if hidden else ""
    yield f"Causes of the difference of {_share_text(causes[runs.TOGETHER])} in distance: {text}."
    rough = max(one["standard_error"] or 0.0 for one in causes.values())
    if rough >= runs.LARGEST_ERROR:
        aim = percent(runs.LARGEST_ERROR)
        yield f"The shares are rough: standard errors up to {percent(rough)} of the distance, aimed at {aim}."
    sliding = causes["rolling"]
    ends = f"between {percent(sliding['low'], signed=True)} and {percent(sliding['high'], signed=True)}"
    yield (
        f"The real sliding of the wheels on the rollers, {1e3 * numbers['rig']['real_sliding_largest_mps']['mean']:.3g} mm/s at "
        f"most, changes the distance by {ends}"
        + (": not distinguishable from zero." if sliding["within_its_error"] else ".")
    )


def _share_text(one: Numbers) -> str:
    """A share with its standard error."""
    if one["standard_error"] is None:
        return percent(one["share"], signed=True)
    return f"{100.0 * one['share']:+.2f} ± {100.0 * one['standard_error']:.2f} %"


def _dead_time_line(found: Numbers) -> str:
    parts = f"{1e3 * found['torque_s']:z.1f} ms of the axle's torque, {1e3 * found['drive_s']:z.1f} ms of the drives"
    more = f"{1e3 * found['predicted_s']:z.1f} ms more ({parts})"
    text = f"Equivalent dead time: the rig acts like a track whose protection has {more}"
    measured = found.get("measured_s")
    if measured is not None:
        text += f"; measured: {1e3 * measured:z.1f} ms"
        if found["low_s"] is not None:
            text += f", between {1e3 * found['low_s']:.1f} and {1e3 * found['high_s']:.1f} ms"
            rest = 1e3 * (measured - found["predicted_s"])
            if not found["low_s"] <= found["predicted_s"] <= found["high_s"]:
                text += f"; the prediction counts mean lags alone, the other {rest:+.1f} ms are imperfections listed under Causes"
    elif found.get("track"):
        most = max(0.0, *(float(delay) for delay in found["track"]))
        text += f"; measured: none, no dead time from 0 to {most:g} ms gives the track the rig's distance"
    return f"{text}."


def _causes(numbers: Numbers) -> Section:
    causes = {CAUSES.get(name, name): one for name, one in numbers["causes"].items()}
    bars = {text: (one["share"], one["standard_error"] or 0.0, one["within_its_error"]) for text, one in causes.items()}
    caption = (
        "Part of the difference in mean distance that goes away with each imperfection, one after the other; standard errors. "
        "Hollow: inside its error of 95 %, not distinguishable from zero."
    )
    names = ("share", "causes.*.standard_error", "causes.*.low", "causes.*.high", "within_its_error")
    found = {text: numbers["variants"][name] for name, text in VARIANTS.items() if name in numbers["variants"]}
    rows = [(text, *(with_error(one[name]) for name in ("distance_relative", *VARIANT))) for text, one in found.items()]
    header = ("run", "distance over track, less 1", "tracking RMS", "mean slip", "dump cycles", "air [l]")
    more = "Each of the lines after the first takes one more imperfection away; ± standard error."
    shares = QUANTITIES.table(causes, names, "Shares of the distance on track.", "cause")
    blocks: list[Block] = [Picture("causes", cause_bars(bars), caption), shares, Table(header, rows, more)]
    return Section("Why rig and track differ", blocks)


def _dead_time(numbers: Numbers) -> Section:
    found, blocks = numbers["dead_time"], list[Picture | Table]()
    if found.get("track"):
        own, rig = numbers["track"]["distance_m"], numbers["rig"]["distance_m"]
        curve = {0.0: (own["mean"], own["standard_error"] or 0.0)}
        curve |= {float(d): (one["distance_m"], one["standard_error_m"] or 0.0) for d, one in found["track"].items()}
        caption = (
            "Mean distance on track with more dead time of the protection, on the rig: where the curve has the rig's distance "
            "is its equivalent dead time. Dashed: in closed form, (D17); dotted: (Q8). Standard errors."
        )
        ends = (1e3 * found["predicted_s"], 1e3 * found["least_s"])
        drawn = dead_time_curve(curve, (rig["mean"], rig["standard_error"] or 0.0), ends)
        blocks.append(Picture("dead_time", drawn, caption))
    times = {QUANTITIES[f"dead_time.{name}"].in_words: found[name] for name in found if name.endswith("_s")}
    rows = [(text, "–" if value is None else round(1e3 * value, 2)) for text, value in times.items()]
    return Section("Equivalent dead time", [*blocks, Table(("", "ms"), rows, "Equivalent dead time.")])


def _numbers(numbers: Numbers) -> Section:
    rows = []
    for name in (*RUN, *RIG):
        quantity = QUANTITIES[f"{'*' if name in RUN else 'rig'}.{name}.mean"]
        both = [numbers[on].get(name) for on in ("track", "rig")]
        factor = quantity.in_shown_unit(1.0)
        rows.append((quantity.heading, *("–" if one is None else with_error(one, factor) for one in both)))
    return Section("Numbers", [Table(("", "track", "rig"), rows, "Means of all starts ± standard error.")])


def _signals(case: Case, whole: Mapping[str, xr.Dataset]) -> Iterator[Picture]:
    """Signals of the first tests; from the first slides on their limit cycles have different phases."""
    track, rig, ideal = whole["track"], whole["rig"], whole.get("rolling")
    radius = slides.wheel_radius(rig)
    yield Picture("speeds", figures.speeds(track, rig, radius), "Train and wheels: rig, virtual train, track.")
    track, rig = slides.under_test(track), slides.under_test(rig)
    ideal = None if ideal is None else slides.under_test(ideal)
    both = {"rig": rig, "track": track}
    yield Picture("first_slide", figures.first_slide(track, rig, radius), "Slip, and the response to it.")
    if case.brake is not None:
        brake = figures.axles_over_time(both, figures.BRAKE, 6.0)
        yield Picture("brakes", brake, "Cylinder pressure, dump cycles, air taken.")
    if case.traction is not None:
        text = "Torque of the motors, and the part of the demand that is left."
        yield Picture("traction", figures.axles_over_time(both, figures.TRACTION, 4.4), text)
    used = ("creep force\nover static load [-]", "creep_force", 1.0 / slides.axle_load(rig))
    yield Picture("adhesion", figures.axles_over_time(both, [used], 3.2), "Force on each axle over its static load.")
    rollers = figures.axles_over_time({"rig": rig}, figures.ROLLERS, 2.8)
    yield Picture("roller_drives", rollers, "Torque of the roller drives, positive forward.")
    sliding = (
        "Full: the rig with its contact model; dashed: wheels that roll on the rollers without sliding. Below, the wheelsets' "
        "own motion along the track: the bogie swings on its traction rod, which the control law does not know, and the wheels "
        "turn by it (D14)."
    )
    yield Picture("sliding", figures.sliding(rig, ideal, radius), sliding)
