"""What does the rig change? One vehicle on several supports, side by side.

vehicle or case, supports by name -> [compared_cases] -> label -> Case -> [CompareStudy]
    -> modes, critical speeds, effects of the rollers, forces, contact characteristics
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from rollerrig.analysis import CriticalSpeedByDisturbance, HuntingSettings, LinearCriticalSpeed, hunting_table
from rollerrig.analysis.control_loop import RollingState, rolling_state
from rollerrig.analysis.critical_speed import RADII, RANGE_KMH, CriticalSpeedOverRadius, EffectSplit, scan_linear
from rollerrig.analysis.hunting import hunting_case
from rollerrig.analysis.wheel_rail_forces import filtered, wheel_forces
from rollerrig.cases import CATALOG_RIG, CATALOG_TRACK, leading_wheelset, on_rig, restrained_along_track, with_head_of
from rollerrig.config import Case, ConfigError, Rig, Vehicle, load_any, load_support
from rollerrig.config.errors import nearest
from rollerrig.config.load.case import build_case
from rollerrig.config.read import Document, catalog_names
from rollerrig.config.write.toml import plain
from rollerrig.contact_analysis import conicity_table, shift_table
from rollerrig.plot import amplitude_over_speed
from rollerrig.plot.compare import disturbed_over_time, modes_side_by_side
from rollerrig.plot.contact import characteristics_figure
from rollerrig.plot.modes import hunting_frequencies
from rollerrig.study import critical_speeds as speeds
from rollerrig.study.assessment import Interval, change_in_words
from rollerrig.study.frame import Study
from rollerrig.study.jobs import Done, Progress, Round, job, whole_modes, whole_run
from rollerrig.study.quantities import Numbers, Quantities
from rollerrig.study.report import Block, Picture, Section, Table, Text
from rollerrig.study.stability import MODE_COLUMNS, mode_rows

SHORTHANDS = {"rig": CATALOG_RIG, "track": CATALOG_TRACK}
"""What `--on rig,track` means where VEHICLE is no case with a support of that kind."""

MATERIAL, FRICTION = "steel", 0.3
"""Contact of a vehicle that comes without a case."""


def compared_cases(
    vehicle: str, on: Sequence[str], cut: str | None = None, *, allow_code: bool = False
) -> dict[str, Case]:
    """One case per support: 'rig', 'track', names of the catalogue or files, each once; of a case its contact is kept.

    Args:
        vehicle: a vehicle of the catalogue or a file; or a case.
        on: supports.
        cut: part of the vehicle; of a case by default its own, of a vehicle all of it.
        allow_code: whether controllers that a case names may lie outside its own folder.

    Returns:
        Label (as the user named the support, without folder and suffix) -> case at a constant speed, without torques and
        disturbances; the vehicle is restrained along the track.

    Raises:
        ConfigError: all mistakes found.
    """
    base = _base(vehicle, allow_code)
    name = base.vehicle.data.name if isinstance(base, Case) else base.name
    cases = {}
    for support in on:
        label = Path(support).name.removesuffix(".toml")
        cases[label] = restrained_along_track(_case(base, f"{name}_on_{label}", _support(support, base), cut, vehicle))
    return cases


def _base(source: str, allow_code: bool) -> Case | Vehicle:
    names = (*catalog_names("vehicle"), *catalog_names("case"))
    needed = "needed: a vehicle or a case, of the catalogue or a TOML file"
    is_file = source.endswith(".toml") or "/" in source or Path(source).exists()
    kinds = ("vehicle", "support", "profile", "material", "case", "programme")
    if not is_file and not any(source in catalog_names(kind) for kind in kinds):
        allowed = f"{needed}; the catalogue has the vehicles {', '.join(catalog_names('vehicle'))} and the cases "
        allowed += ", ".join(catalog_names("case"))
        raise ConfigError.of(source, "", "no such file", allowed, nearest(source, names))
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
    if isinstance(base, Case):
        raw = plain(base)
        chosen = cut or base.vehicle.cut
    else:
        contact = {"material": MATERIAL, "friction": FRICTION}
        raw = {"vehicle": {"data": plain(base)}, "contact": contact, "time": {"duration": 6.0}}
        chosen = cut or "vehicle"
    raw |= {"name": name, "description": name.partition("_on_")[0].replace("_", " ")}
    raw["support"] = {"data": dict(support)}
    raw["vehicle"]["cut"] = chosen
    raw["motion"] = {"speed": "100 km/h"}
    for key in ("axle_torque", "disturbance"):
        raw.pop(key, None)
    return build_case(Document(raw, source, Path()), allow_code=True)  # that of the case was asked for when it was read


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
    return (
        filtered(wheel_forces(run))
        .assign(lateral=motion, longitudinal_creep_force=creep)
        .assign_attrs(status=run.attrs["status"], leading=leading, config_toml=run.attrs["config_toml"])
    )


def wheel_numbers(state: RollingState) -> dict[str, dict[str, float]]:
    """Per wheel the numbers of `supports.*.wheels`."""
    found = {}
    for wheel in map(str, state.wheels["wheel"].to_numpy()):
        own = state.wheels.sel(wheel=wheel)
        outwards = -1.0 if wheel.endswith("left") else 1.0
        found[wheel] = {
            "vertical_force_kn": 1e-3 * float(own["vertical_force"]),
            "lateral_force_kn": outwards * 1e-3 * float(own["lateral_force"]),
            "longitudinal_creep_force_n": float(own["longitudinal_creep_force"]),
            "patches": int(own["patch_count"]),
            "approach_um": 1e6 * float(own["patch_approach"].max()),
            "patch_ab_mm2": 1e6 * float((own["patch_a"] * own["patch_b"]).max()),
            "creep_stiffness_mn": 1e-6 * state.creep_stiffness[wheel],
        }
    return found


def disturbed_numbers(run: xr.Dataset) -> dict[str, float]:
    """Largest magnitudes of the leading wheelset, by the names of DISTURBED."""
    leading, found = str(run.attrs["leading"]), {}
    for name, factor in DISTURBED.items():
        values = run[name]
        if "wheel" in values.dims:
            values = values.sel(wheel=[f"{leading}_left", f"{leading}_right"])
        if "wheelset" in values.dims:
            values = values.sel(wheelset=leading)
        found[name] = factor * float(np.abs(values).max())
    return found


LEAST_RUN_STEP = 20.0
"""Runs are made at speeds at least this far apart [km/h]; further runs narrow the critical speeds down."""

DISTURBED_DURATION = 2.0
"""Length of the run whose wheel forces are compared [s]."""

DISTURBED_SHARE = 0.7
"""It runs at the speed of the range nearest to this part of the lowest critical speed: stable on all supports."""

SHIFT, AMPLITUDES = 8e-3, tuple(1e-4 * k for k in range(5, 71))
"""Lateral shift and amplitudes of the contact characteristics [m]."""

AT_MM = (1.0, 2.0, 3.0, 4.0, 5.0)
"""Amplitudes at which conicities are reported [mm]."""

QUANTITIES = Quantities("compare")


@dataclass
class Results:
    """What was computed, by label of the support; parts that Ctrl-C cut off are missing."""

    modes: dict[str, xr.Dataset]  # Datasets of `stability`
    linear: dict[str, LinearCriticalSpeed]  # linear critical speeds in RANGE_KMH, whatever the range of the modes
    states: dict[str, RollingState]  # steady rolling at the lowest speed
    shifts: dict[str, xr.Dataset]  # Datasets of `shift_table`
    conicity: dict[str, xr.Dataset]  # Datasets of `conicity_table`
    over_radius: CriticalSpeedOverRadius | None  # critical speeds over the rollers' radius
    effects: EffectSplit | None  # of the rollers on the critical speed
    by_disturbance: dict[str, CriticalSpeedByDisturbance]  # critical speeds by disturbance, with their runs
    disturbed: dict[str, xr.Dataset]  # filtered forces of the disturbed run, with the motion of the leading wheelset
    disturbed_kmh: float  # its speed [km/h]; NaN if it was not run

    def linear_kmh(self, label: str) -> float:
        """Linear critical speed [km/h]; NaN if there is none or it was not computed."""
        return self.linear[label].speed_kmh if label in self.linear else math.nan

    def by_disturbance_kmh(self, label: str) -> Interval:
        """Between which speeds the critical speed by disturbance lies [km/h]."""
        return Interval.of_bracket(self.by_disturbance.get(label))


def between(found: CriticalSpeedByDisturbance) -> str:
    """The critical speed by disturbance in words."""
    speeds_kmh = Interval.of_bracket(found)
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
    quantities = QUANTITIES
    writes = ("modes.csv", "runs.csv", "wheels.csv", "critical_speeds.csv", "roller_effects.csv", "disturbed_*.nc")
    formats = ("svg", "png")
    round_ends = (0.25, 0.8)

    @property
    def title(self) -> str:
        vehicle = next(iter(self.supports.values())).vehicle
        return f"{vehicle.data.name}, {speeds.words(vehicle.cut)}: {' and '.join(self.supports)} side by side"

    @property
    def rig(self) -> Case:
        """The first case on rollers; else the first case on the catalogue's rig with rollers of its rail's head."""
        first = next(iter(self.supports.values()))
        return next((c for c in self.supports.values() if isinstance(c.support.data, Rig)), None) or on_rig(first)

    def cases(self) -> Mapping[str, Case]:
        return self.supports

    def rounds(self, done: Done) -> Iterator[Round]:
        jobs = {}
        scanned = [v / 3.6 for v in RANGE_KMH]
        for label, case in self.supports.items():
            jobs[f"modes {label}"] = job(whole_modes, case, self.speeds_kmh)
            jobs[f"steady rolling {label}"] = job(rolling_state, case, self.speeds_kmh[0] / 3.6)
            jobs[f"contact {label}"] = job(shift_table, case, SHIFT)
            jobs[f"linear critical speed {label}"] = job(scan_linear, (case, scanned))
        yield {**jobs, **speeds.roller_jobs(self.rig, self.parts, self.radii)}
        started = dict.fromkeys(self.supports, run_speeds(self.speeds_kmh))
        yield from speeds.disturbance_rounds(self.supports, started, self.bracket_kmh, self.hunting, done)
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
        over_radius, effects = speeds.over_radius(done, self.parts, self.radii), speeds.effect_split(done)
        runs = speeds.brackets(list(self.supports), self.hunting, done)
        speed = self._disturbed_kmh(done) if ran else math.nan
        return Results(modes, linear, states, shifts, conicity, over_radius, effects, runs, ran, speed)

    def numbers(self, results: Results) -> dict[str, Any]:
        first = next(iter(self.supports.values()))
        return {
            "vehicle": first.vehicle.data.name,
            "cut": first.vehicle.cut,
            "supports": {label: self._support(results, label) for label in self.supports},
            "disturbed_kmh": results.disturbed_kmh,
            "critical_speed_over_radius_kmh": speeds.radius_numbers(results.over_radius),
            "roller_effects": speeds.effect_numbers(results.effects),
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
            found["disturbed"] = disturbed_numbers(results.disturbed[label])
        return found

    def summary(self, results: Results, numbers: Numbers) -> list[str]:
        lines = []
        for label in (label for label in self.supports if label in results.linear):
            scan, found = results.linear[label], results.by_disturbance.get(label)
            cell = speeds.linear_cell(scan)
            text = f"On {label}: linear critical speed {cell}{' km/h' if scan.onset and cell[0].isdigit() else ''}"
            by = self._by_disturbance(results, label)
            lines.append(text + (f", by disturbance {by}." if found else "."))
            if found and found.ended_early:
                lines.append(f"On {label}: {speeds.ended_early_sentence(found)}")
        *others, last = self.supports
        for label in others:
            linear = results.linear_kmh(label) / results.linear_kmh(last)
            ratios = {
                "linear": Interval(linear, linear),
                "by disturbance": results.by_disturbance_kmh(label).over(results.by_disturbance_kmh(last)),
            }
            parts = [f"{change_in_words(ratio)} ({kind})" for kind, ratio in ratios.items() if ratio.bounded]
            if parts:
                lines.append(f"Against {last}, the critical speed on {label} is {' and '.join(parts)}.")
        if results.effects is not None and math.isfinite(results.effects.loss):
            lines.append(speeds.effects_sentence(results.effects))
        return lines

    def files(self, results: Results, numbers: Numbers) -> Mapping[str, Any]:
        on = {label: numbers["supports"][label] for label in self.supports}.items()
        wheels = [{"on": n, "wheel": w, **row} for n, one in on for w, row in one.get("wheels", {}).items()]
        runs = [{"on": n, **run} for n, one in on for run in one.get("by_disturbance", {}).get("runs", [])]
        found = {
            "modes.csv": [["on", *MODE_COLUMNS], *([n, *row] for n, m in results.modes.items() for row in mode_rows(m)[1:])],
            "runs.csv": _rows(runs),
            "wheels.csv": _rows(wheels),
            "critical_speeds.csv": speeds.radius_rows(results.over_radius),
            "roller_effects.csv": speeds.effect_rows(results.effects),
            **{f"disturbed_{label}.nc": run for label, run in results.disturbed.items()},
        }  # fmt: skip
        return {name: content for name, content in found.items() if not isinstance(content, list) or len(content) > 1}

    def sections(self, results: Results, numbers: Numbers) -> list[Section]:
        size, duration = 1e3 * self.hunting.disturbance, self.hunting.duration
        definition = (
            f"By disturbance: runs of {duration:g} s after a lateral offset of {size:g} mm of the leading wheelset."
        )
        modes = modes_side_by_side(results.modes) if results.modes else None
        missing: list[Block] = [Text("Not computed.")]
        return [
            Section("Critical speeds", [self._critical(results), Text(definition), *self._hunting(results)]),
            Section("Modes", [Picture("modes", modes, CAPTIONS["modes"])] if modes else missing),
            Section("Radius of the rollers", self._radius(results) or missing),
            Section(
                "Effects of the rollers", speeds.effects_blocks(results.effects, CAPTIONS["roller_effects"]) or missing
            ),
            Section("Wheel forces", self._forces(results, numbers) or missing),
            Section("Contact characteristics", self._characteristics(results, numbers) or missing),
        ]

    def _by_disturbance(self, results: Results, label: str) -> str:
        if label not in results.by_disturbance:
            return "not computed"
        return between(results.by_disturbance[label])

    def _critical(self, results: Results) -> Table:
        rows = []
        for label in self.supports:
            scan, found = results.linear.get(label), results.by_disturbance.get(label)
            onset = scan.onset if scan else None
            cycle = next((run for run in found.runs if run.persists), None) if found else None
            amplitude = f"{1e3 * cycle.final.amplitude:.2f} mm, {cycle.final.frequency:.2f} Hz" if cycle else "–"
            mode = (f"{onset.frequency:.2f}", onset.name) if onset else ("–", "–")
            rows.append((label, speeds.linear_cell(scan), *mode, self._by_disturbance(results, label), amplitude))
        header = ("on", "linear critical speed [km/h]", "frequency [Hz]", "mode", "by disturbance", "limit cycle there")
        return Table(header, rows)

    def _hunting(self, results: Results) -> list[Block]:
        tables = {
            label: hunting_table(found.runs, found.disturbance) for label, found in results.by_disturbance.items()
        }
        blocks: list[Block] = []
        persists = any(bool((table["persists"] == 1).any()) for table in tables.values())
        if persists or any(modes.attrs["hunting_mode"] for modes in results.modes.values()):
            blocks.append(Picture("hunting", hunting_frequencies(results.modes, tables), CAPTIONS["hunting"]))
        if tables:
            top = self.speeds_kmh[-1] * 1.1
            lines = {f"linear, {label}": v for label in results.linear if (v := results.linear_kmh(label)) < top}
            blocks.append(Picture("amplitude", amplitude_over_speed(tables, lines), CAPTIONS["amplitude"]))
        return blocks

    def _radius(self, results: Results) -> list[Block]:
        if results.over_radius is None:
            return []
        caption = "Linear critical speeds: rollers and track with the head and gauge of the rig compared."
        rig = self.rig.support.data
        marked = rig.roller_radius if isinstance(rig, Rig) else math.nan
        return [
            speeds.radius_table(results.over_radius, caption),
            speeds.radius_picture("radius", results.over_radius, marked, CAPTIONS["radius"]),
        ]

    def _forces(self, results: Results, numbers: Numbers) -> list[Block]:
        blocks: list[Block] = []
        supports = numbers["supports"]
        if results.states:
            names = next(iter(results.states.values())).creep_stiffness
            entries = {f"{wheel}, {on}": supports[on]["wheels"][wheel] for wheel in names for on in results.states}
            caption = f"Steady rolling at {self.speeds_kmh[0]:g} km/h."
            blocks.append(QUANTITIES.table(entries, "supports.*.wheels.*", caption, "wheel, on"))
        if results.disturbed:
            caption = (
                f"The leading wheelset after a lateral offset of {1e3 * self.hunting.disturbance:g} mm at "
                f"{results.disturbed_kmh:g} km/h, where it is stable on all supports; filtered as in EN 14363 but for the "
                "longitudinal force."
            )
            entries = {label: supports[label]["disturbed"] for label in results.disturbed}
            blocks.append(Picture("disturbed", disturbed_over_time(results.disturbed), CAPTIONS["disturbed"]))
            blocks.append(QUANTITIES.table(entries, list(DISTURBED), caption, "on"))
        return blocks

    def _characteristics(self, results: Results, numbers: Numbers) -> list[Block]:
        if not results.conicity:
            return []
        entries = {label: numbers["supports"][label] for label in results.conicity}
        caption = "Equivalent conicity (EN 15302) over the amplitude; on rollers with the rollers' own radii."
        figure = characteristics_figure(results.shifts, results.conicity)
        return [
            QUANTITIES.table(entries, [f"conicity_{mm:g}mm" for mm in AT_MM], caption, "on"),
            Picture("characteristics", figure, CAPTIONS["characteristics"]),
        ]


CAPTIONS = {
    "modes": "Frequency and damping of the modes over speed: one colour per mode, one line style per support. Drawn are hunting "
    "and the modes that differ most; all are in modes.csv.",
    "hunting": "Frequency of hunting: linear mode (lines, cross where its damping vanishes) and limit cycles of the runs from a "
    "disturbance (markers).",
    "amplitude": "Lateral amplitude at the end of each run from a disturbance: filled where the motion persists, open where it "
    "decays. Dashed: linear critical speeds.",
    "radius": "Linear critical speed over the radius of the rollers; horizontal: on track.",
    "roller_effects": "Loss of critical speed from track to rig.",
    "disturbed": "The leading wheelset after a lateral offset. Y is low-pass filtered at 20 Hz, ΣY averaged over 2 m of distance "
    "besides (EN 14363); motion and longitudinal force are unfiltered.",
    "characteristics": "Contact characteristics of the leading wheelset without load. Without yaw the wheels touch rail and "
    "roller in the same points; the rolling radii of the rollers differ.",
}
"""Picture -> what it shows."""


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
