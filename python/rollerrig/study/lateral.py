"""Lateral motion during a slide: does it disturb the control of the rig, and does the rig show what a sliding train does?

Case on elastic rollers with a disturbance -> [LateralStudy] -> runs displaced and centred, elastic and rigid, rig and track
-> tracking, real sliding, hunting before and in the slide; lateral creep of sliding wheels against its closed form, (Q6)
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import xarray as xr

from rollerrig.analysis.lateral_guidance import (
    Guidance,
    amplitudes_over_time,
    creep_force,
    guidance,
    lateral_creep_coefficient,
    leading_lateral,
    slide_begins,
    train_slip,
)
from rollerrig.analysis.tracking import wheel_radius
from rollerrig.config import Case, ConfigError, ConfigProblem, Rig
from rollerrig.config.validate.simulated_axles import simulated_axles
from rollerrig.plot import lateral as figures
from rollerrig.results import COMPLETED
from rollerrig.study.adhesion_variants import track_case
from rollerrig.study.frame import Study
from rollerrig.study.jobs import Done, Round, job, whole_run
from rollerrig.study.lateral_cases import CLEAN_POLACH, MEMBERS, nearly_the_same, unbraked, whole_creep_slope
from rollerrig.study.lateral_numbers import (
    ENSEMBLE,
    GUIDANCE,
    GUIDED,
    LABELS,
    QUANTITIES,
    REPEATED,
    RUN,
    ensemble_numbers,
    guidance_numbers,
    run_measured,
    run_numbers,
)
from rollerrig.study.lateral_text import control_text, guidance_text, hunting_text
from rollerrig.study.quantities import Numbers
from rollerrig.study.report import VIEW, Block, Picture, Section, Text


@dataclass(frozen=True)
class Found:
    """Runs by key of LABELS, and the numbers of the nearly same runs by key of REPEATED."""

    runs: dict[str, xr.Dataset]
    repeated: dict[str, list[dict[str, Any]]]


@dataclass(frozen=True)
class LateralStudy(Study[Found]):
    """The runs of LABELS of one case, on elastic rollers with a lateral disturbance."""

    case: Case

    command = "lateral"
    quantities = QUANTITIES
    writes = ("*.nc", VIEW)

    def __post_init__(self) -> None:
        """Refuse a case that says nothing about lateral motion in a slide.

        Raises:
            ConfigError: it has no rig controller, no elastic rollers, no disturbance or no degraded rail.
        """
        track_case(self.case)
        rig = self.case.support.data
        needed = {
            "support.mounting": "the elastic support of the roller axles, which this study also makes rigid",
            "disturbance": "an offset in lateral or yaw, e.g. body = 'wheelset_1', lateral = '4 mm'",
            "adhesion": "the degraded rail on which the wheels slide",
        }
        there = {
            "support.mounting": isinstance(rig, Rig) and rig.mounting is not None,
            "disturbance": any(d.lateral or d.yaw for d in self.case.disturbance),
            "adhesion": self.case.adhesion is not None,
        }
        problems = [
            ConfigProblem(self.case.name, k, "missing", f"needed: {needed[k]}") for k, on in there.items() if not on
        ]
        problems += simulated_axles(self.case, self.command)
        if problems:
            raise ConfigError(problems)

    @property
    def title(self) -> str:
        return f"{self.case.name}: lateral motion during a slide"

    def cases(self) -> Mapping[str, Case]:
        return {"rig": self.case, "track": track_case(self.case)}

    def rounds(self, done: Done) -> Iterator[Round]:
        runs = self.runs()
        yield {LABELS[key]: job(whole_run, case) for key, case in runs.items()}
        if LABELS["rig"] not in done:
            return
        begin = _slide({key: done[label] for key, label in LABELS.items() if label in done})
        yield {
            _repeated(key, number): job(run_measured, case, begin)
            for key in REPEATED
            for number, case in enumerate(nearly_the_same(runs[key]), 1)
        }

    def runs(self) -> dict[str, Case]:
        """The cases that are run, by key of LABELS."""
        track = track_case(self.case)
        rigid: dict[str, object] = {"support.mounting": None, "support.changes": None}
        centred: dict[str, object] = {"disturbance": []}
        dry: dict[str, object] = {"adhesion.rail": "dry", "adhesion.piece": []}
        stiff = whole_creep_slope(track)
        return {
            "rig": self.case,
            "rig_centred": self.case.with_changes(centred),
            "rig_rigid": self.case.with_changes(rigid),
            "rig_rigid_centred": self.case.with_changes({**rigid, **centred}),
            "rig_dry": self.case.with_changes(dry),
            "track": track,
            "track_dry": track.with_changes(dry),
            "track_paper": track.with_changes({"contact.creep": "kalker_saturated"}),
            "track_unbraked": unbraked(track),
            "track_stiff": stiff,
            "track_stiff_unbraked": unbraked(stiff),
            "track_polach_stiff_unbraked": unbraked(stiff).with_changes({"contact.creep": CLEAN_POLACH}),
        }

    def collect(self, done: Done) -> Found | None:
        if LABELS["rig"] not in done:
            return None
        again = {key: [done[name] for name in map(partial(_repeated, key), range(1, MEMBERS)) if name in done]
                 for key in REPEATED}  # fmt: skip
        return Found({key: done[label] for key, label in LABELS.items() if label in done}, again)

    def statuses(self, results: Found) -> Sequence[str]:
        return [run.attrs["status"] for run in results.runs.values()]

    # --------------------------------------------------------------------------------------------------- numbers

    def numbers(self, results: Found) -> dict[str, Any]:
        begin = _slide(results.runs)
        left = {key: self.guidance_of(results.runs[key]) for key in GUIDED if key in results.runs}
        runs = {key: run_numbers(run, begin) for key, run in results.runs.items()}
        return {
            "case": self.case.name,
            "slide_begins_s": begin,
            "runs": runs,
            "ensemble": {
                key: ensemble_numbers([runs[key], *others]) for key, others in results.repeated.items() if others
            },
            "guidance": {key: guidance_numbers(found) for key, found in left.items() if found is not None},
        }

    def guidance_of(self, run: xr.Dataset) -> Guidance | None:
        """Lateral creep of the sliding axles of a run; None where no wheel slid while it moved sideways."""
        return guidance(run, lateral_creep_coefficient(self.case, run))

    def summary(self, results: Found, numbers: Numbers) -> list[str]:
        lines = [*control_text(numbers), *hunting_text(numbers)]
        lines += guidance_text(numbers)
        ended = {key: run for key, run in results.runs.items() if run.attrs["status"] not in COMPLETED}
        return lines + [f"{LABELS[key]}: {run.attrs['status_message']}" for key, run in ended.items()]

    def shown(self, results: Found) -> Mapping[str, xr.Dataset]:
        return {LABELS[key]: results.runs[key] for key in ("track", "rig") if key in results.runs}

    def files(self, results: Found, numbers: Numbers) -> Mapping[str, Any]:
        return {f"{key}.nc": run for key, run in results.runs.items()}

    def sections(self, results: Found, numbers: Numbers) -> list[Section]:
        shown = {LABELS[key]: run for key, run in numbers["runs"].items()}
        table = QUANTITIES.list_table(shown, [quantity.name for quantity in RUN])
        again = {LABELS[key]: one for key, one in numbers["ensemble"].items()}
        caption = f"mean of {MEMBERS} runs whose disturbances differ by 10⁻⁹, and its standard error"
        repeated = [QUANTITIES.list_table(again, [q.name for q in ENSEMBLE], caption)] if again else []
        sections = [Section("Numbers", [table, *repeated])]
        sections += [Section(title, [Picture(*picture)]) for title, *picture in _pictures(results.runs)]
        return [*sections, Section("Lateral guidance of a sliding wheel", self._guidance_blocks(results, numbers))]

    def _guidance_blocks(self, results: Found, numbers: Numbers) -> list[Block]:
        text = (
            "On a wheel that slides along the track at a speed v_s far above its lateral speed v_y, friction opposes the "
            "sliding: F_y = −F v_y/v_s, viscous and weak, where a rolling wheel has f₂₂/V. Kalker's theory saturated by its "
            "length keeps the direction of the linear force, so that its slope is near f₂₂/f₁₁; the exact theory and FASTSIM "
            "turn to Coulomb's. The parts of spin on left and right cancel in an axle."
        )
        found = {key: self.guidance_of(results.runs[key]) for key in numbers["guidance"]}
        if not found:
            return [Text(text), Text("No wheel slid while it moved sideways.")]
        entries = {LABELS[key]: numbers["guidance"][key] for key in found}
        pictures = [
            Picture(f"guidance_{key}", figures.viscous(one.expected, one.force, one.slope),
                    f"{LABELS[key]}: axles whose wheels slide faster than 1 m/s, each sample.")
            for key, one in found.items() if one is not None
        ]  # fmt: skip
        return [Text(text), QUANTITIES.table(entries, [q.name for q in GUIDANCE], head="run"), *pictures]


def _repeated(key: str, number: int) -> str:
    """Name of the job of another member of an ensemble."""
    return f"{LABELS[key]}, again {number}"


def _slide(results: Mapping[str, xr.Dataset]) -> float:
    """When the wheels begin to slide, on track where that was run [s]."""
    return slide_begins(results.get("track", results["rig"]))


def _pictures(results: Mapping[str, xr.Dataset]) -> list[tuple[str, str, Any, str]]:
    """Title of the section, and what a Picture takes."""
    shown = {LABELS[k]: results[k] for k in ("rig", "rig_rigid", "rig_dry", "track", "track_dry") if k in results}
    motion = {label: (run["time"].to_numpy(), leading_lateral(run)) for label, run in shown.items()}
    sizes = {label: amplitudes_over_time(*series) for label, series in motion.items()}
    slips = {label: (run["time"], 100.0 * train_slip(run).isel(axle=0)) for label, run in shown.items()}
    rigs = {LABELS[key]: results[key] for key in ("rig", "rig_rigid", "rig_centred") if key in results}
    forces = {
        LABELS[key]: (run["time"], 1e-3 * creep_force(run, "x")[:, 0], 1e-3 * creep_force(run, "y")[:, 0])
        for key, run in results.items()
        if key in ("rig", "track")
    }
    return [
        ("Disturbance of the control", "disturbed_control", figures.disturbed_control(rigs, wheel_radius(results["rig"])),
         "Leading wheelset: tracking error, and sliding of the real wheel on its roller."),
        ("Lateral motion", "motion", figures.motions(motion, _slide(results)),
         "Displacement of the leading wheelset; dashed: the wheels of the train on track begin to slide."),
        ("Hunting and slide", "amplitudes", figures.amplitudes(sizes, slips),
         "Half of peak to peak in windows of 0.4 s, and slip against the train; on the rig that of the virtual wheels."),
        ("Creep forces", "creep_forces", figures.creep_forces(forces),
         "Leading left wheel: along and across the track. Sliding uses up the friction along the track."),
    ]  # fmt: skip
