"""Lateral motion during a slide: does it disturb the control of the rig, and does the rig show what a sliding train does?

Case on elastic rollers with a disturbance -> [LateralStudy] -> runs displaced and centred, elastic and rigid, rig and track
-> tracking, real sliding, hunting before and in the slide
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr

from rollerrig.analysis.signals import half_waves
from rollerrig.analysis.slide_statistics import following, largest, real_sliding, slip, virtual_slip, wheel_radius
from rollerrig.cases import as_case
from rollerrig.common.arrays import Array
from rollerrig.config import Case, ConfigError, ConfigProblem, Rig
from rollerrig.config.validate.check_actuators import simulated_axles
from rollerrig.plot import adhesion as figures
from rollerrig.results import COMPLETED
from rollerrig.study.ensemble import means, start_jobs, started
from rollerrig.study.frame import Outcome, Study
from rollerrig.study.jobs import Done, Progress, Round, job, whole_run
from rollerrig.study.options import Processes, command
from rollerrig.study.quantities import Numbers
from rollerrig.study.report import VIEW, Picture, Section
from rollerrig.study.runs.adhesion import track_case

MEMBERS = 8  # runs of an ensemble, the case itself included
NEARLY = 1e-9  # relative change of the disturbance from one member to the next: below what any measurement could tell
SLIDES = 0.02  # slip from which on an axle counts as sliding: friction is used up long before, at some 0.5 %
LEAST_WAVE = 1e-2  # smaller half-waves are rounding [mm]


def unbraked(case: Case) -> Case:
    """The same run without brake and traction: no wheel slides."""
    tables = {name: table for name in ("brake", "traction") if (table := getattr(case, name)) is not None}
    none = {name: table.model_copy(update={"demand": ((0.0, 0.0), (1.0, 0.0))}) for name, table in tables.items()}
    return case.model_copy(update=none)


def whole_creep_slope(case: Case) -> Case:
    """The same rail with k_A = k_S = 1: as little friction, but a creep curve as steep as on a clean rail."""
    assert case.adhesion is not None
    rails = ["rail", *(f"piece.{k}.rail" for k in range(len(case.adhesion.piece)))]
    return case.with_changes({f"adhesion.{rail}.{key}": 1.0 for rail in rails for key in ("k_A", "k_S")})


def nearly_the_same(case: Case, count: int) -> list[Case]:
    """An ensemble: the case, and others of which each is displaced by 1e-9 more than the one before."""

    def displaced(k: float) -> Case:
        moved = (one.model_copy(update={"lateral": k * one.lateral, "yaw": k * one.yaw}) for one in case.disturbance)
        return case.model_copy(update={"disturbance": tuple(moved)})

    return [displaced(1.0 + NEARLY * k) for k in range(count)]


LABELS = {  # key of a run -> its label; displaced: by the case's disturbance
    "rig": "rig as it is, displaced",
    "rig_centred": "rig as it is, centred",
    "rig_rigid": "rigid rollers, displaced",
    "track": "track, displaced",
    "track_dry": "track, displaced, dry rail",
    "track_unbraked": "track, displaced, unbraked",
    "track_stiff": "track, displaced, k_A = k_S = 1",
    "track_stiff_unbraked": "track, displaced, k_A = k_S = 1, unbraked",
}

REPEATED = ("rig", "rig_rigid")
"""Runs in which flanges strike: repeated with a disturbance that differs by 1e-9, since no single figure of theirs is certain."""


CHAOTIC = ("tracking_rms", "real_sliding_largest_mps", "amplitude_before_mm", "amplitude_in_slide_mm")
"""Quantities of a run that the smallest change moves."""


CAUSES = (
    "Unbraked no wheel slides: hunting that dies there too dies of the flatter creep curve of the contaminated rail (k_A, k_S), "
    "or of the case's own creep law where that is Polach's, softer near the limit of friction; the pair with k_A = k_S = 1 "
    "separates the slide from the rail."
)


def on_rig(run: xr.Dataset) -> bool:
    """Whether a run stands on rollers."""
    return any("roller" in str(body) for body in run["body"].to_numpy())


def train_slip(run: xr.Dataset) -> xr.DataArray:
    """Slip of the wheels against the train, on a rig of the virtual wheels: flange strikes are no part of it."""
    return virtual_slip(run) if on_rig(run) else slip(run)


def slide_begins(run: xr.Dataset) -> float:
    """When an axle first slips by more than SLIDES against the train [s]; NaN: never."""
    sliding = np.flatnonzero((abs(train_slip(run)).to_numpy() > SLIDES).any(axis=1))
    return float(run["time"][sliding[0]]) if sliding.size else math.nan


def leading_lateral(run: xr.Dataset) -> Array:
    """Lateral displacement of the leading wheelset [mm], shape (time,)."""
    return np.asarray(1e3 * run["lateral"].sel(body=str(run["axle"].to_numpy()[0])))


def amplitude(time: Array, values: Array, begin: float, end: float) -> float:
    """Half of peak to peak within a time [unit of the values]; NaN where there is none of it."""
    within = values[(time >= begin) & (time <= end)]
    return 0.5 * float(np.ptp(within)) if within.size else math.nan


def hunting_frequency(time: Array, values: Array, begin: float, end: float) -> float:
    """Frequency of the half-waves larger than LEAST_WAVE of a displacement in mm within a time [Hz]; NaN: none."""
    within = (time >= begin) & (time <= end)
    duration = half_waves(time[within], values[within], LEAST_WAVE).duration
    return 0.5 / float(np.median(duration)) if duration.size else math.nan


def run_measured(case: Case, slide: float, progress: Progress | None = None) -> dict[str, Any]:
    """The numbers of one more member of an ensemble."""
    return run_numbers(whole_run(case, progress), slide)


def run_numbers(run: xr.Dataset, slide: float) -> dict[str, Any]:
    """The numbers of one run of `runs`; NaN where not defined, and where the wheels do not begin to slide at `slide` [s]."""
    time, lateral = run["time"].to_numpy(), leading_lateral(run)
    begin = slide if math.isfinite(slide) else float(time[-1])
    later = [amplitude(time, lateral, t, t + 1.0) for t in np.arange(begin + 1.0, time[-1] - 0.999)]
    rollers = [body for body in map(str, run["body"].to_numpy()) if "roller" in body]
    untracked = {"tracking_rms": math.nan, "tracking_largest": math.nan}
    return {
        "status": run.attrs["status"],
        **(following(run) if on_rig(run) else {**untracked, **real_sliding(run)}),
        "largest_slip": largest(train_slip(run)),
        "amplitude_before_mm": amplitude(time, lateral, begin - 1.0, begin),
        "amplitude_in_slide_mm": max(later, default=math.nan),
        "amplitude_end_mm": amplitude(time, lateral, time[-1] - 1.0, time[-1]),
        "frequency_hz": hunting_frequency(time, lateral, begin - 1.0, begin),
        "largest_lateral_mm": float(np.abs(lateral).max()),
        "roller_lateral_mm": 1e3 * float(np.abs(run["lateral"].sel(body=rollers)).max()) if rollers else math.nan,
    }


CONTROL = ("tracking_rms", "real_sliding_largest_mps", "real_sliding_largest_mps_standard_error")
HUNTING = ("amplitude_before_mm", "amplitude_in_slide_mm")
LEFT = 0.2  # hunting of which less than this part is left has died [-]


@dataclass(frozen=True)
class Found:
    """What was run and read off."""

    runs: dict[str, xr.Dataset]  # by key of LABELS
    repeated: dict[str, list[dict[str, Any]]]  # numbers of the nearly same runs, by key of REPEATED


@dataclass(frozen=True)
class LateralStudy(Study[Found]):
    """The runs of LABELS of one case, on elastic rollers with a lateral disturbance."""

    case: Case

    command = "lateral"
    heading = "{case.name}: lateral motion during a slide"
    writes = ("*.nc", VIEW)

    def __post_init__(self) -> None:
        """Refuse with a ConfigError a case without rig controller, elastic rollers, disturbance or degraded rail."""
        track_case(self.case)
        rig = self.case.support.data
        needed = (
            ("support.mounting", isinstance(rig, Rig) and rig.mounting is not None,
             "the elastic support of the roller axles, which this study also makes rigid"),
            ("disturbance", any(d.lateral or d.yaw for d in self.case.disturbance),
             "an offset in lateral or yaw, e.g. body = 'wheelset_1', lateral = '4 mm'"),
            ("adhesion", self.case.adhesion is not None, "the degraded rail on which the wheels slide"),
        )  # fmt: skip
        name = self.case.name
        problems = [ConfigProblem(name, key, "missing", f"needed: {what}") for key, there, what in needed if not there]
        if problems := problems + simulated_axles(self.case, self.command):
            raise ConfigError(problems)

    def cases(self) -> Mapping[str, Case]:
        return {"rig": self.case, "track": track_case(self.case)}

    def rounds(self, done: Done) -> Iterator[Round]:
        runs = self.runs()
        yield {LABELS[key]: job(whole_run, case) for key, case in runs.items()}
        if LABELS["rig"] not in done:
            return
        begin = _slide({key: done[label] for key, label in LABELS.items() if label in done})
        again = {LABELS[key]: runs[key] for key in REPEATED}
        yield start_jobs(again, lambda one, _: job(run_measured, one, begin), MEMBERS, 1, nearly_the_same)

    def runs(self) -> dict[str, Case]:
        """The cases that are run, by key of LABELS."""
        track = track_case(self.case)
        rigid: dict[str, object] = {"support.mounting": None}
        centred: dict[str, object] = {"disturbance": []}
        dry: dict[str, object] = {"adhesion.rail": "dry", "adhesion.piece": []}
        stiff = whole_creep_slope(track)
        return {
            "rig": self.case,
            "rig_centred": self.case.with_changes(centred),
            "rig_rigid": self.case.with_changes(rigid),
            "track": track,
            "track_dry": track.with_changes(dry),
            "track_unbraked": unbraked(track),
            "track_stiff": stiff,
            "track_stiff_unbraked": unbraked(stiff),
        }

    def collect(self, done: Done) -> Found | None:
        if LABELS["rig"] not in done:
            return None
        again = {key: started(done, LABELS[key], [None])[1:] for key in REPEATED}
        return Found({key: done[label] for key, label in LABELS.items() if label in done}, again)

    def statuses(self, results: Found) -> Sequence[str]:
        return [run.attrs["status"] for run in results.runs.values()]

    def numbers(self, results: Found) -> dict[str, Any]:
        begin = _slide(results.runs)
        runs = {key: run_numbers(run, begin) for key, run in results.runs.items()}
        return {
            "case": self.case.name,
            "slide_begins_s": begin,
            "runs": runs,
            "ensemble": {k: means([runs[k], *others], CHAOTIC) for k, others in results.repeated.items() if others},
        }

    def summary(self, results: Found, numbers: Numbers) -> list[str]:
        runs = numbers["runs"]
        ended = {key: run for key, run in results.runs.items() if run.attrs["status"] not in COMPLETED}
        control = {"rig_centred": runs.get("rig_centred", {}), **numbers["ensemble"]}
        lines = [
            f"{LABELS[key]}: {said}." for key, one in control.items() if (said := self.quantities.said(one, CONTROL))
        ]
        for key, run in runs.items():
            before, later = (run[name] for name in HUNTING)
            if later is not None and "centred" not in key and key not in ended:
                end = "dies" if later < LEFT * before else "goes on"
                lines.append(f"Hunting, {LABELS[key]}: {self.quantities.said(run, HUNTING)}: it {end}.")
        lines.append(CAUSES)
        return lines + [f"{LABELS[key]}: {run.attrs['status_message']}" for key, run in ended.items()]

    def shown(self, results: Found) -> Mapping[str, xr.Dataset]:
        return {LABELS[key]: results.runs[key] for key in ("track", "rig") if key in results.runs}

    def files(self, results: Found, numbers: Numbers) -> Mapping[str, Any]:
        return {f"{key}.nc": run for key, run in results.runs.items()}

    def sections(self, results: Found, numbers: Numbers) -> list[Section]:
        shown = {LABELS[key]: run for key, run in numbers["runs"].items()}
        table = self.quantities.list_table(shown, "runs.*")
        again = {LABELS[key]: one for key, one in numbers["ensemble"].items()}
        caption = f"mean of {MEMBERS} runs whose disturbances differ by 10⁻⁹, and its standard error"
        repeated = [self.quantities.list_table(again, "ensemble.*", caption)] if again else []
        pictures = [Section(title, [Picture(*picture)]) for title, *picture in _pictures(results.runs)]
        return [Section("Numbers", [table, *repeated]), *pictures]


def _slide(results: Mapping[str, xr.Dataset]) -> float:
    """When the wheels begin to slide, on track where that was run [s]."""
    return slide_begins(results.get("track", results["rig"]))


def _pictures(results: Mapping[str, xr.Dataset]) -> list[tuple[str, str, Any, str]]:
    """Title of the section, and what a Picture takes."""
    shown = {LABELS[k]: results[k] for k in ("rig", "rig_rigid", "track", "track_dry") if k in results}
    motion = {label: (run["time"].to_numpy(), leading_lateral(run)) for label, run in shown.items()}
    rigs = {LABELS[key]: results[key] for key in ("rig", "rig_rigid", "rig_centred") if key in results}
    radius = wheel_radius(results["rig"])
    control: tuple[figures.Signal, ...] = (
        ("tracking error\n[% of train speed]",
         lambda run: radius * (run["axle_speed"] - run["virtual_speed"]) / run["train_speed"], 100.0),
        ("sliding of wheel\non roller [mm/s]", "real_sliding", 1e3),
    )  # fmt: skip
    return [
        ("Disturbance of the control", "disturbed_control", figures.leading_axle(rigs, control, 4.6),
         "Leading wheelset: tracking error, and sliding of the real wheel on its roller."),
        ("Lateral motion", "motion", figures.motions(motion, _slide(results)),
         "Displacement of the leading wheelset; dashed: the wheels of the train on track begin to slide."),
    ]  # fmt: skip


@command
def lateral(case: Case | str, *, processes: Processes = 1, progress: Progress | None = None) -> Outcome[Found]:
    """Lateral motion during a slide: does hunting disturb the rig's control, and does the rig show what the track does?

    Args:
        case: case on elastic rollers with [rig_control] and a lateral disturbance: adhesion_lateral, or a TOML file.
        processes: runs at a time; more than 1 asks a script for `if __name__ == "__main__":`.
        progress: called with the fraction done and a short text.

    Raises:
        ConfigError: the case says nothing about lateral motion in a slide.
    """
    return LateralStudy(as_case(case)).outcome(processes, progress)
