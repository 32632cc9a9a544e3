"""What does the rig change? One vehicle on several supports, side by side.

vehicle or case, supports by name -> [compared_cases] -> label -> Case -> [CompareStudy]
    -> modes, critical speeds, effects of the rollers, forces
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any, get_args

import xarray as xr

from rollerrig.analysis import SPEEDS_KMH
from rollerrig.analysis.control_loop import RollingState, rolling_state
from rollerrig.analysis.critical_speed import (
    ALL_OFF,
    ALL_ON,
    EFFECTS,
    RADII,
    RANGE_KMH,
    CriticalSpeedByDisturbance,
    LinearCriticalSpeed,
    On,
    effect_split,
    scan_linear,
)
from rollerrig.analysis.hunting import HuntingSettings
from rollerrig.cases import CATALOG_RIG, CATALOG_TRACK, on_rig, restrained_along_track, with_head_of
from rollerrig.config import Case, ConfigError, Rig, Vehicle, load_any, load_support
from rollerrig.config.errors import nearest, show_value
from rollerrig.config.load.case import build_case
from rollerrig.config.read import CatalogKind, Document, catalog_names
from rollerrig.config.write.toml import plain
from rollerrig.plot import amplitude_over_speed
from rollerrig.plot.compare import modes_side_by_side
from rollerrig.plot.modes import hunting_frequencies
from rollerrig.study import critical_speeds as speeds
from rollerrig.study.assessment import Interval, change_in_words
from rollerrig.study.frame import Outcome, Study
from rollerrig.study.jobs import Chains, Done, Progress, Round, job, whole_modes
from rollerrig.study.options import Option, Processes, command
from rollerrig.study.quantities import Numbers
from rollerrig.study.report import Block, Picture, Section, Table, Text
from rollerrig.study.stability import MODE_COLUMNS, mode_rows

SHORTHANDS = {"rig": CATALOG_RIG, "track": CATALOG_TRACK}
"""What `--on rig,track` means where VEHICLE is no case with a support of that kind."""

MATERIAL, FRICTION = "steel", 0.3  # contact of a vehicle that comes without a case


def compared_cases(
    vehicle: str, on: Sequence[str], cut: str | None = None, *, allow_code: bool = False
) -> dict[str, Case]:
    """One case per support, each named once; of a case its contact is kept. Arguments as of `compare`.

    Returns:
        Label (as the user named the support, without folder and suffix) -> case at a constant speed, without torques and
        disturbances; the vehicle is restrained along the track.

    Raises:
        ConfigError: all mistakes found.
    """
    labels = [Path(support).name.removesuffix(".toml") for support in on]
    if not all(labels) or len(set(labels)) < len(labels):
        raise ConfigError.of(vehicle, "on", show_value(",".join(on)), "name each support once, like rig,track")
    base = _base(vehicle, allow_code)
    name = base.vehicle.data.name if isinstance(base, Case) else base.name
    return {
        label: restrained_along_track(_case(base, f"{name}_on_{label}", _support(support, base), cut, vehicle))
        for label, support in zip(labels, on, strict=True)
    }


def _base(source: str, allow_code: bool) -> Case | Vehicle:
    needed = "needed: a vehicle or a case, of the catalogue or a TOML file"
    is_file = source.endswith(".toml") or "/" in source or Path(source).exists()
    if not is_file and not any(source in catalog_names(kind) for kind in get_args(CatalogKind)):
        vehicles, cases = catalog_names("vehicle"), catalog_names("case")
        has = f"the catalogue has the vehicles {', '.join(vehicles)} and the cases {', '.join(cases)}"
        raise ConfigError.of(source, "", "no such file", f"{needed}; {has}", nearest(source, (*vehicles, *cases)))
    kind, found = load_any(source, allow_code=allow_code)
    if isinstance(found, Case | Vehicle):
        return found
    raise ConfigError.of(source, "", f"a {kind}, not a vehicle", needed)


def _support(name: str, base: Case | Vehicle) -> dict[str, Any]:
    """Raw tables of a support; 'rig' and 'track' are the case's own, or its counterpart with the same head."""
    own = base.support.data if isinstance(base, Case) else None
    if name not in SHORTHANDS:
        return dict(plain(load_support(name)))
    if own is not None and own.kind == name:
        return dict(plain(own))
    found = load_support(SHORTHANDS[name])
    return dict(plain(found if own is None else with_head_of(found, own)))


def _case(base: Case | Vehicle, name: str, support: Mapping[str, Any], cut: str | None, source: str) -> Case:
    contact = {"material": MATERIAL, "friction": FRICTION}
    bare = {"vehicle": {"data": plain(base)}, "contact": contact, "time": {"duration": 6.0}}
    raw = plain(base) if isinstance(base, Case) else bare
    raw |= {"name": name, "description": name.partition("_on_")[0].replace("_", " ")}
    raw |= {"support": {"data": dict(support)}, "motion": {"speed": "100 km/h"}}
    raw["vehicle"]["cut"] = cut or (base.vehicle.cut if isinstance(base, Case) else "vehicle")
    for key in ("axle_torque", "disturbance"):
        raw.pop(key, None)
    return build_case(Document(raw, source, Path()), allow_code=True)  # that of the case was asked for when it was read


STEADY = {  # key of `supports.*.wheels` -> signal in steady rolling, and factor
    "vertical_force_kn": ("vertical_force", 1e-3),
    "lateral_force_kn": ("lateral_force", 1e-3),
    "longitudinal_creep_force_n": ("longitudinal_creep_force", 1.0),
    "patches": ("patch_count", 1),
}


def wheel_numbers(state: RollingState) -> dict[str, dict[str, float]]:
    """Per wheel the numbers of `supports.*.wheels`."""
    found: dict[str, dict[str, float]] = {}
    for wheel, stiffness in state.creep_stiffness.items():
        own = state.wheels.sel(wheel=wheel)
        found[wheel] = {key: factor * own[name].item() for key, (name, factor) in STEADY.items()}
        found[wheel]["lateral_force_kn"] *= -1.0 if wheel.endswith("left") else 1.0  # outwards
        found[wheel] |= {
            "approach_um": 1e6 * float(own["patch_approach"].max()),
            "patch_ab_mm2": 1e6 * float((own["patch_a"] * own["patch_b"]).max()),
            "creep_stiffness_mn": 1e-6 * stiffness,
        }
    return found


LEAST_RUN_STEP = 20.0
"""Runs are made at speeds at least this far apart [km/h]; further runs narrow the critical speeds down."""


@dataclass
class Results:
    """What was computed, by label of the support; parts that Ctrl-C cut off are missing."""

    modes: dict[str, xr.Dataset]  # Datasets of `stability`
    linear: dict[str, LinearCriticalSpeed]  # linear critical speeds in RANGE_KMH, whatever the range of the modes
    states: dict[str, RollingState]  # steady rolling at the lowest speed
    over_radius: speeds.Scans  # linear critical speeds over the rollers' radius
    effects: dict[On, LinearCriticalSpeed]  # and with effects of the rollers switched off
    by_disturbance: dict[str, CriticalSpeedByDisturbance]  # critical speeds by disturbance, with their runs

    def linear_kmh(self, label: str) -> float:
        """Linear critical speed [km/h]; NaN if there is none or it was not computed."""
        return self.linear.get(label, LinearCriticalSpeed()).speed_kmh

    def by_disturbance_kmh(self, label: str) -> Interval:
        """Between which speeds the critical speed by disturbance lies [km/h]."""
        return Interval.of_bracket(self.by_disturbance.get(label))


def between(found: CriticalSpeedByDisturbance | None) -> str:
    """The critical speed by disturbance in words."""
    speeds_kmh = Interval.of_bracket(found)
    if found is None:
        return "not computed"
    if not speeds_kmh.known:
        return "not found: no run was decided"
    undecided = math.isnan(found.decays) and any(run.speed < found.persists for run in found.ended_early)
    return speeds_kmh.text("km/h", 1) + (", or not at all: runs below were not decided" if undecided else "")


@dataclass(frozen=True)
class CompareStudy(Study[Results]):
    """One vehicle on several supports."""

    supports: Mapping[str, Case]  # label -> case at a constant speed, of `compared_cases`
    speeds_kmh: tuple[float, ...]  # of the modes [km/h], rising; runs are made at those at least LEAST_RUN_STEP apart
    parts: tuple[str, ...] = ()  # cuts of the vehicle in the table of critical speeds
    radii: tuple[float, ...] = RADII  # of its rollers [m]
    bracket_kmh: float = 3.0  # width to which the critical speeds by disturbance are narrowed down [km/h]
    hunting: HuntingSettings = field(default_factory=HuntingSettings)  # disturbance, length and tolerances of the runs

    command = "compare"
    writes = ("modes.csv", "runs.csv", "wheels.csv", "critical_speeds.csv", "roller_effects.csv")
    formats = ("svg", "png")
    round_ends = (0.25, 1.0)

    @property
    def title(self) -> str:
        vehicle = self._first.vehicle
        return f"{vehicle.data.name}, {speeds.words(vehicle.cut)}: {' and '.join(self.supports)} side by side"

    @property
    def _first(self) -> Case:
        return next(iter(self.supports.values()))

    @property
    def rig(self) -> Case:
        """The first case on rollers; else the first case on the catalogue's rig with rollers of its rail's head."""
        rigs = (case for case in self.supports.values() if isinstance(case.support.data, Rig))
        return next(rigs, None) or on_rig(self._first)

    def cases(self) -> Mapping[str, Case]:
        return self.supports

    def rounds(self, done: Done) -> Iterator[Round | Chains]:
        jobs = {}
        for label, case in self.supports.items():
            jobs[f"modes {label}"] = job(whole_modes, case, self.speeds_kmh)
            jobs[f"steady rolling {label}"] = job(rolling_state, case, self.speeds_kmh[0] / 3.6)
            jobs[f"linear critical speed {label}"] = job(scan_linear, case, RANGE_KMH)
        yield {**jobs, **speeds.roller_jobs(self.rig, self.parts, self.radii)}
        started = dict.fromkeys(self.supports, run_speeds(self.speeds_kmh))
        yield speeds.disturbance_chains(self.supports, started, self.bracket_kmh, self.hunting)

    def collect(self, done: Done) -> Results | None:
        if not done:
            return None
        modes, linear, states = (
            {label: done[f"{kind} {label}"] for label in self.supports if f"{kind} {label}" in done}
            for kind in ("modes", "linear critical speed", "steady rolling")
        )
        rollers = speeds.roller_results(self.rig, self.parts, self.radii, done)
        return Results(modes, linear, states, *rollers, speeds.brackets(list(self.supports), self.hunting, done))

    def numbers(self, results: Results) -> dict[str, Any]:
        return {
            "vehicle": self._first.vehicle.data.name,
            "cut": self._first.vehicle.cut,
            "supports": {label: self._support(results, label) for label in self.supports},
            "critical_speed_over_radius_kmh": speeds.radius_numbers(results.over_radius),
            "roller_effects": effect_split(results.effects) if results.effects else None,
        }

    def _support(self, results: Results, label: str) -> dict[str, Any]:
        support = self.supports[label].support.data
        found: dict[str, Any] = {"support": support.name, "roller_radius_m": getattr(support, "roller_radius", None)}
        if label in results.linear:
            onset = results.linear[label].onset
            found["linear_critical_speed_kmh"] = results.linear_kmh(label)
            found["linear_critical_frequency_hz"] = onset.frequency if onset else None
            found["linear_critical_mode"] = onset.name if onset else ""
        if label in results.by_disturbance:
            found["by_disturbance"] = speeds.disturbance_numbers(results.by_disturbance[label])
        if label in results.states:
            found["wheels"] = wheel_numbers(results.states[label])
        return found

    def summary(self, results: Results, numbers: Numbers) -> list[str]:
        lines = []
        for label, scan in results.linear.items():
            found, cell = results.by_disturbance.get(label), speeds.linear_cell(scan)
            text = f"On {label}: linear critical speed {cell}{' km/h' if cell[0].isdigit() else ''}"
            lines.append(f"{text}, by disturbance {between(found)}.")
            if found and found.ended_early:
                lines.append(f"On {label}: {speeds.ended_early_sentence(found)}")
        *others, last = self.supports
        for label in others:
            linear = results.linear_kmh(label) / results.linear_kmh(last)
            by = results.by_disturbance_kmh(label).over(results.by_disturbance_kmh(last))
            ratios = {"linear": Interval(linear, linear), "by disturbance": by}
            parts = [f"{change_in_words(ratio)} ({kind})" for kind, ratio in ratios.items() if ratio.bounded]
            if parts:
                lines.append(f"Against {last}, the critical speed on {label} is {' and '.join(parts)}.")
        ends_known = {ALL_ON, ALL_OFF} <= results.effects.keys()
        return [*lines, speeds.effects_sentence(effect_split(results.effects))] if ends_known else lines

    def files(self, results: Results, numbers: Numbers) -> Mapping[str, Any]:
        on = {label: numbers["supports"][label] for label in self.supports}.items()
        modes = [[label, *row] for label, one in results.modes.items() for row in mode_rows(one)[1:]]
        effects = [[*(int(e in on) for e in EFFECTS), scan.speed_kmh] for on, scan in results.effects.items()]
        found: dict[str, Sequence[Sequence[object]]] = {
            "modes.csv": [["on", *MODE_COLUMNS], *modes],
            "runs.csv": _rows(
                [{"on": n, **run} for n, one in on for run in one.get("by_disturbance", {}).get("runs", [])]
            ),
            "wheels.csv": _rows(
                [{"on": n, "wheel": w, **row} for n, one in on for w, row in one.get("wheels", {}).items()]
            ),
            "critical_speeds.csv": speeds.radius_rows(results.over_radius),
            "roller_effects.csv": [[*EFFECTS, "linear_critical_speed_kmh"], *effects],
        }
        return {name: rows for name, rows in found.items() if len(rows) > 1}

    def sections(self, results: Results, numbers: Numbers) -> list[Section]:
        parts: dict[str, list[Block]] = {
            "Critical speeds": self._critical(results),
            "Modes": [Picture("modes", modes_side_by_side(results.modes), CAPTIONS["modes"])] if results.modes else [],
            "Radius of the rollers": self._radius(results),
            "Effects of the rollers": self._effects(results),
            "Wheel forces": self._steady(results, numbers),
        }
        return [Section(title, blocks or [Text("Not computed.")]) for title, blocks in parts.items()]

    def _critical(self, results: Results) -> list[Block]:
        rows = []
        for label in self.supports:
            scan, found = results.linear.get(label), results.by_disturbance.get(label)
            cycle = next((run.final for run in found.runs if run.persists), None) if found else None
            amplitude = f"{1e3 * cycle.amplitude:.2f} mm, {cycle.frequency:.2f} Hz" if cycle else "–"
            mode = (f"{scan.onset.frequency:.2f}", scan.onset.name) if scan and scan.onset else ("–", "–")
            rows.append((label, speeds.linear_cell(scan), *mode, between(found), amplitude))
        header = ("on", "linear critical speed [km/h]", "frequency [Hz]", "mode", "by disturbance", "limit cycle there")
        offset, duration = 1e3 * self.hunting.disturbance, self.hunting.duration
        definition = (
            f"By disturbance: runs of {duration:g} s, less where the amplitude stands still before, after a lateral offset of "
            f"{offset:g} mm of the leading wheelset."
        )
        blocks: list[Block] = [Table(header, rows, definition)]
        tables = {label: one.table for label, one in results.by_disturbance.items()}
        persists = any(bool((table["persists"] == 1).any()) for table in tables.values())
        if persists or any(modes.attrs["hunting_mode"] for modes in results.modes.values()):
            blocks.append(Picture("hunting", hunting_frequencies(results.modes, tables), CAPTIONS["hunting"]))
        if tables:
            top = self.speeds_kmh[-1] * 1.1
            lines = {f"linear, {label}": v for label in results.linear if (v := results.linear_kmh(label)) < top}
            blocks.append(Picture("amplitude", amplitude_over_speed(tables, lines), CAPTIONS["amplitude"]))
        return blocks

    def _radius(self, results: Results) -> list[Block]:
        if not results.over_radius:
            return []
        caption = "Linear critical speeds: rollers and track with the head and gauge of the rig compared."
        return [speeds.radius_table(results.over_radius, caption)]

    def _effects(self, results: Results) -> list[Block]:
        if not results.effects:
            return []
        caption = "Track less rig, by switching the four effects of a roller (contact.roller_effects)."
        return [speeds.effects_table(effect_split(results.effects), caption)]

    def _steady(self, results: Results, numbers: Numbers) -> list[Block]:
        wheels = {on: numbers["supports"][on]["wheels"] for on in results.states}
        entries = {
            f"{wheel}, {on}": own[wheel] for wheel in next(iter(wheels.values()), ()) for on, own in wheels.items()
        }
        caption = f"Steady rolling at {self.speeds_kmh[0]:g} km/h."
        return [self.quantities.table(entries, "supports.*.wheels.*", caption, "wheel, on")] if entries else []


CAPTIONS = {  # picture -> what it shows
    "modes": "Frequency and damping of the modes over speed: one colour per mode, one line style per support. Drawn are hunting "
    "and the modes that differ most; all are in modes.csv.",
    "hunting": "Frequency of hunting: linear mode (lines, cross where its damping vanishes) and limit cycles of the runs from a "
    "disturbance (markers).",
    "amplitude": "Lateral amplitude at the end of each run from a disturbance: filled where the motion persists, open where it "
    "decays. Dashed: linear critical speeds.",
}


def _rows(entries: Sequence[Mapping[str, Any]]) -> list[list[object]]:
    """Entries of the summary as rows of a CSV file, header first."""
    return [list(entries[0]), *(list(entry.values()) for entry in entries)] if entries else []


def run_speeds(speeds_kmh: Sequence[float]) -> list[float]:
    """Speeds of the runs: at least LEAST_RUN_STEP apart [km/h]."""
    chosen = [speeds_kmh[0]]
    for speed in speeds_kmh[1:]:
        if speed - chosen[-1] >= LEAST_RUN_STEP - 1e-9:
            chosen.append(speed)
    return chosen


@command
def compare(
    vehicle: str,
    on: Annotated[Sequence[str], Option(commas=True)] = ("rig", "track"),
    *,
    speeds_kmh: Sequence[float] = SPEEDS_KMH,
    cut: str | None = None,
    radii: Annotated[Sequence[float], Option("radii_m", "", 0.05, 1e6)] = (0.46, 0.725, 1.0, 2.0, 5.0, 10.0),
    disturbance: Annotated[float, Option("disturbance_mm", "mm", 0.01, 20.0)] = 3e-3,
    duration: Annotated[float, Option(least=1.0, most=600.0)] = 6.0,
    processes: Processes = 1,
    allow_code: bool = False,
    progress: Progress | None = None,
    **hunting: float,
) -> Outcome[Results]:
    """One vehicle on several supports side by side: modes, critical speeds, limit cycles, forces, effects of the rollers.

    Args:
        vehicle: vehicle or case: a name of the catalogue or a TOML file.
        on: supports: 'rig', 'track', names of the catalogue or files.
        speeds_kmh: speeds [km/h], rising.
        cut: part of the vehicle; by default all of it, or what the case has.
        radii: radii of the rollers in the table of critical speeds [m].
        disturbance: lateral offset of the leading wheelset in the runs [m].
        duration: length of each of these runs [s], at least; less where the amplitude stands still before.
        processes: runs at a time; more than 1 asks a script for `if __name__ == "__main__":`.
        allow_code: also take controllers from outside the folder of the case that names them.
        progress: called with the fraction done and a short text.
        **hunting: others of `HuntingSettings`.

    Raises:
        ConfigError: a vehicle or support is unknown or cannot be used.
    """
    cases = compared_cases(vehicle, on, cut, allow_code=allow_code)
    parts = tuple(next(iter(cases.values())).vehicle.data.cut_names()[::-1])
    settings = HuntingSettings(disturbance=disturbance, duration=duration, **hunting)
    study = CompareStudy(cases, tuple(speeds_kmh), parts, tuple(sorted(set(radii))), hunting=settings)
    return study.outcome(processes, progress)
