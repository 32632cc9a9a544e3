"""What does the rig change? One vehicle on several supports, side by side.

vehicle or case, supports by name -> [compared_cases] -> label -> Case -> [CompareStudy]
    -> modes, critical speeds, effects of the rollers, forces, contact characteristics
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
from rollerrig.analysis.hunting import HuntingSettings, hunting_case
from rollerrig.analysis.wheel_rail_forces import filtered, wheel_forces
from rollerrig.cases import CATALOG_RIG, CATALOG_TRACK, leading_wheelset, on_rig, restrained_along_track, with_head_of
from rollerrig.config import Case, ConfigError, Rig, Vehicle, load_any, load_support
from rollerrig.config.errors import nearest, show_value
from rollerrig.config.load.case import build_case
from rollerrig.config.read import CatalogKind, Document, catalog_names
from rollerrig.config.write.toml import plain
from rollerrig.contact_analysis import conicity_table, shift_table
from rollerrig.plot import amplitude_over_speed
from rollerrig.plot.compare import disturbed_over_time, modes_side_by_side
from rollerrig.plot.contact import characteristics_figure
from rollerrig.plot.modes import hunting_frequencies
from rollerrig.study import critical_speeds as speeds
from rollerrig.study.assessment import Interval, change_in_words
from rollerrig.study.frame import Outcome, Study
from rollerrig.study.jobs import Chains, Done, Progress, Round, job, whole_modes, whole_run
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

DISTURBED = {
    "guiding_force": 1e-3,
    "guiding_force_sum": 1e-3,
    "longitudinal_creep_force": 1e-3,
    "wheel_unloading": 1e2,
    "derailment_quotient": 1.0,
    "wear_number": 1.0,
}
"""Signal whose largest magnitude of the leading wheelset is reported of the disturbed run -> factor to its unit."""


def disturbed(case: Case, speed: float, settings: HuntingSettings, progress: Progress | None = None) -> xr.Dataset:
    """Filtered wheel-rail forces after a lateral offset at a speed [m/s], with the motion of the leading wheelset."""
    run = whole_run(hunting_case(case, speed, settings), progress)
    leading = leading_wheelset(case).name
    motion, creep = run["lateral"].sel(body=leading, drop=True), run["longitudinal_creep_force"]
    forces = filtered(wheel_forces(run)).assign(lateral=motion, longitudinal_creep_force=creep)
    return forces.assign_attrs(status=run.attrs["status"], leading=leading, config_toml=run.attrs["config_toml"])


def of_leading(run: xr.Dataset) -> xr.Dataset:
    """A disturbed run's forces on its leading wheelset alone, the left wheel first."""
    leading = str(run.attrs["leading"])
    return run.sel(wheel=[f"{leading}_left", f"{leading}_right"], wheelset=leading)


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

DISTURBED_DURATION = 2.0  # length of the run whose wheel forces are compared [s]

DISTURBED_SHARE = 0.7
"""It runs at the speed of the range nearest to this part of the lowest critical speed: stable on all supports."""

SHIFT, AMPLITUDES = 8e-3, tuple(1e-4 * k for k in range(5, 71))
"""Lateral shift and amplitudes of the contact characteristics [m]."""

AT_MM = (1.0, 2.0, 3.0, 4.0, 5.0)  # amplitudes at which conicities are reported [mm]


@dataclass
class Results:
    """What was computed, by label of the support; parts that Ctrl-C cut off are missing."""

    modes: dict[str, xr.Dataset]  # Datasets of `stability`
    linear: dict[str, LinearCriticalSpeed]  # linear critical speeds in RANGE_KMH, whatever the range of the modes
    states: dict[str, RollingState]  # steady rolling at the lowest speed
    shifts: dict[str, xr.Dataset]  # Datasets of `shift_table`
    disturbed: dict[str, xr.Dataset]  # forces and motion of the leading wheelset in the disturbed run
    conicity: dict[str, xr.Dataset]  # Datasets of `conicity_table`
    over_radius: speeds.Scans  # linear critical speeds over the rollers' radius
    effects: dict[On, LinearCriticalSpeed]  # and with effects of the rollers switched off
    by_disturbance: dict[str, CriticalSpeedByDisturbance]  # critical speeds by disturbance, with their runs
    disturbed_kmh: float  # speed of the disturbed run [km/h]; NaN if it was not run

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
    writes = ("modes.csv", "runs.csv", "wheels.csv", "critical_speeds.csv", "roller_effects.csv", "disturbed_*.nc")
    formats = ("svg", "png")
    round_ends = (0.25, 0.9)

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
            jobs[f"contact {label}"] = job(shift_table, case, SHIFT)
            jobs[f"linear critical speed {label}"] = job(scan_linear, case, RANGE_KMH)
        yield {**jobs, **speeds.roller_jobs(self.rig, self.parts, self.radii)}
        started = dict.fromkeys(self.supports, run_speeds(self.speeds_kmh))
        yield speeds.disturbance_chains(self.supports, started, self.bracket_kmh, self.hunting)
        kmh = self._disturbed_kmh(done)
        settings = HuntingSettings(self.hunting.disturbance, DISTURBED_DURATION, 2e-3, 1e-5, 1e-8)
        yield {f"disturbed {label}": job(disturbed, case, kmh / 3.6, settings) for label, case in self.supports.items()}

    def _disturbed_kmh(self, done: Done) -> float:
        found = speeds.brackets(list(self.supports), self.hunting, done)
        critical = [done[f"linear critical speed {label}"].speed_kmh for label in self.supports]
        critical += [3.6 * end for one in found.values() for end in (one.decays, one.persists)]
        lowest = min((v for v in critical if math.isfinite(v)), default=self.speeds_kmh[-1])
        return min(self.speeds_kmh, key=lambda v: abs(v - DISTURBED_SHARE * lowest))

    def collect(self, done: Done) -> Results | None:
        if not done:
            return None
        modes, linear, states, shifts, ran = (
            {label: done[f"{kind} {label}"] for label in self.supports if f"{kind} {label}" in done}
            for kind in ("modes", "linear critical speed", "steady rolling", "contact", "disturbed")
        )
        conicity = {
            label: conicity_table(shift, [a for a in AMPLITUDES if a <= float(shift["lateral"][-1])])
            for label, shift in shifts.items()
        }
        rollers = speeds.roller_results(self.rig, self.parts, self.radii, done)
        runs = speeds.brackets(list(self.supports), self.hunting, done)
        speed = self._disturbed_kmh(done) if ran else math.nan
        return Results(modes, linear, states, shifts, ran, conicity, *rollers, runs, speed)

    def numbers(self, results: Results) -> dict[str, Any]:
        return {
            "vehicle": self._first.vehicle.data.name,
            "cut": self._first.vehicle.cut,
            "supports": {label: self._support(results, label) for label in self.supports},
            "disturbed_kmh": results.disturbed_kmh,
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
        if label in results.conicity:
            table = results.conicity[label]
            for mm in (mm for mm in AT_MM if mm <= 1e3 * float(table["amplitude"][-1])):
                found[f"conicity_{mm:g}mm"] = float(table["conicity"].sel(amplitude=1e-3 * mm, method="nearest"))
        if label in results.disturbed:
            run = of_leading(results.disturbed[label])
            found["disturbed"] = {name: factor * float(abs(run[name]).max()) for name, factor in DISTURBED.items()}
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
        tables = {name: rows for name, rows in found.items() if len(rows) > 1}
        return tables | {f"disturbed_{label}.nc": run for label, run in results.disturbed.items()}

    def sections(self, results: Results, numbers: Numbers) -> list[Section]:
        parts: dict[str, list[Block]] = {
            "Critical speeds": self._critical(results),
            "Modes": [Picture("modes", modes_side_by_side(results.modes), CAPTIONS["modes"])] if results.modes else [],
            "Radius of the rollers": self._radius(results),
            "Effects of the rollers": self._effects(results),
            "Wheel forces": [*self._steady(results, numbers), *self._disturbed(results, numbers)],
            "Contact characteristics": self._characteristics(results, numbers),
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
        rig = self.rig.support.data
        marked = rig.roller_radius if isinstance(rig, Rig) else math.nan
        figure = speeds.radius_figure(results.over_radius, marked)
        return [speeds.radius_table(results.over_radius, caption), Picture("radius", figure, CAPTIONS["radius"])]

    def _effects(self, results: Results) -> list[Block]:
        if not results.effects:
            return []
        split = effect_split(results.effects)
        caption = "Track less rig, by switching the four effects of a roller (contact.roller_effects)."
        picture = Picture("roller_effects", speeds.effects_figure(split), CAPTIONS["roller_effects"])
        return [picture, speeds.effects_table(split, caption)]

    def _steady(self, results: Results, numbers: Numbers) -> list[Block]:
        wheels = {on: numbers["supports"][on]["wheels"] for on in results.states}
        entries = {
            f"{wheel}, {on}": own[wheel] for wheel in next(iter(wheels.values()), ()) for on, own in wheels.items()
        }
        caption = f"Steady rolling at {self.speeds_kmh[0]:g} km/h."
        return [self.quantities.table(entries, "supports.*.wheels.*", caption, "wheel, on")] if entries else []

    def _disturbed(self, results: Results, numbers: Numbers) -> list[Block]:
        if not results.disturbed:
            return []
        caption = f"Largest magnitudes at {results.disturbed_kmh:g} km/h, where it is stable on all supports."
        entries = {label: numbers["supports"][label]["disturbed"] for label in results.disturbed}
        figure = disturbed_over_time({label: of_leading(run) for label, run in results.disturbed.items()})
        table = self.quantities.table(entries, list(DISTURBED), caption, "on")
        return [Picture("disturbed", figure, CAPTIONS["disturbed"]), table]

    def _characteristics(self, results: Results, numbers: Numbers) -> list[Block]:
        if not results.conicity:
            return []
        entries = {label: numbers["supports"][label] for label in results.conicity}
        caption = "Equivalent conicity (EN 15302) over the amplitude; on rollers with the rollers' own radii."
        table = self.quantities.table(entries, [f"conicity_{mm:g}mm" for mm in AT_MM], caption, "on")
        figure = characteristics_figure(results.shifts, results.conicity)
        return [table, Picture("characteristics", figure, CAPTIONS["characteristics"])]


CAPTIONS = {  # picture -> what it shows
    "modes": "Frequency and damping of the modes over speed: one colour per mode, one line style per support. Drawn are hunting "
    "and the modes that differ most; all are in modes.csv.",
    "hunting": "Frequency of hunting: linear mode (lines, cross where its damping vanishes) and limit cycles of the runs from a "
    "disturbance (markers).",
    "amplitude": "Lateral amplitude at the end of each run from a disturbance: filled where the motion persists, open where it "
    "decays. Dashed: linear critical speeds.",
    "radius": "Linear critical speed over the radius of the rollers; horizontal: on track.",
    "roller_effects": "Loss of critical speed from track to rig.",
    "disturbed": "The leading wheelset after the offset. Y is low-pass filtered at 20 Hz, ΣY averaged over 2 m of distance "
    "besides (EN 14363); motion and longitudinal force are unfiltered.",
    "characteristics": "Contact characteristics of the leading wheelset without load. Without yaw the wheels touch rail and "
    "roller in the same points; the rolling radii of the rollers differ.",
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
