"""What does the rig change? One vehicle on several supports, side by side.

cases by support -> [CompareStudy] -> modes, critical speeds, effects of the rollers, forces, contact characteristics
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import xarray as xr
from matplotlib.figure import Figure

from rollerrig.analysis import (
    CriticalSpeedByDisturbance,
    HuntingSettings,
    LinearCriticalSpeed,
    hunting_table,
)
from rollerrig.analysis.control_loop import RollingState, rolling_state
from rollerrig.analysis.critical_speed import RADII, RANGE_KMH, CriticalSpeedOverRadius, EffectSplit, scan_linear
from rollerrig.cases import on_rig
from rollerrig.config import Case, Rig
from rollerrig.contact_analysis import conicity_table, shift_table
from rollerrig.plot import amplitude_over_speed
from rollerrig.plot.compare import disturbed_over_time, modes_side_by_side
from rollerrig.plot.contact import characteristics_figure
from rollerrig.plot.modes import hunting_frequencies
from rollerrig.study import critical_speeds as speeds
from rollerrig.study.assessment import Interval, change_in_words
from rollerrig.study.frame import Study
from rollerrig.study.jobs import Done, Round, job, whole_modes
from rollerrig.study.quantities import Numbers, Quantities
from rollerrig.study.report import Block, Picture, Section, Table, Text
from rollerrig.study.runs.compare import DISTURBED, disturbed, disturbed_numbers, wheel_numbers
from rollerrig.study.stability import MODE_COLUMNS, mode_rows

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
    """What was computed, by label of the support; parts that Ctrl-C cut off are missing.

    Attributes:
        modes: Datasets of `stability`.
        linear: linear critical speeds in RANGE_KMH, whatever the range of the modes.
        states: steady rolling at the lowest speed.
        shifts: Datasets of `shift_table`.
        conicity: Datasets of `conicity_table`.
        over_radius: critical speeds over the rollers' radius.
        effects: of the rollers on the critical speed.
        by_disturbance: critical speeds by disturbance, with their runs.
        disturbed: filtered forces of the disturbed run, with the motion of the leading wheelset.
        disturbed_kmh: its speed [km/h]; NaN if it was not run.
    """

    modes: dict[str, xr.Dataset]
    linear: dict[str, LinearCriticalSpeed]
    states: dict[str, RollingState]
    shifts: dict[str, xr.Dataset]
    conicity: dict[str, xr.Dataset]
    over_radius: CriticalSpeedOverRadius | None
    effects: EffectSplit | None
    by_disturbance: dict[str, CriticalSpeedByDisturbance]
    disturbed: dict[str, xr.Dataset]
    disturbed_kmh: float

    def linear_kmh(self, label: str) -> float:
        """Linear critical speed [km/h]; NaN if there is none or it was not computed."""
        return self.linear[label].speed_kmh if label in self.linear else math.nan

    def by_disturbance_kmh(self, label: str) -> Interval:
        """Between which speeds the critical speed by disturbance lies [km/h]."""
        return Interval.of_bracket(self.by_disturbance.get(label))


@dataclass(frozen=True)
class CompareStudy(Study[Results]):
    """One vehicle on several supports.

    Attributes:
        supports: label -> case at a constant speed, of `compared_cases`.
        speeds_kmh: of the modes [km/h], rising; runs are made at those at least LEAST_RUN_STEP apart.
        parts: cuts of the vehicle in the table of critical speeds.
        radii: of its rollers [m].
        bracket_kmh: width to which the critical speeds by disturbance are narrowed down [km/h].
        hunting: disturbance, length and tolerances of the runs.
    """

    supports: Mapping[str, Case]
    speeds_kmh: tuple[float, ...]
    parts: tuple[str, ...] = ()
    radii: tuple[float, ...] = RADII
    bracket_kmh: float = 3.0
    hunting: HuntingSettings = field(default_factory=HuntingSettings)

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

    # --------------------------------------------------------------------------------------------------- numbers

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
            lines.append(text + (f", by disturbance {speeds.between(found)}." if found else "."))
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

    # ---------------------------------------------------------------------------------------------------- report

    def sections(self, results: Results, numbers: Numbers) -> list[Section]:
        size, duration = 1e3 * self.hunting.disturbance, self.hunting.duration
        definition = (
            f"By disturbance: runs of {duration:g} s after a lateral offset of {size:g} mm of the leading wheelset. The linear "
            "critical speed is that of small motions."
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
            Section("Contact characteristics", _characteristics(results, numbers) or missing),
            Section("What was compared", [self._supports()]),
        ]

    def _critical(self, results: Results) -> Table:
        rows = []
        for label in self.supports:
            scan, found = results.linear.get(label), results.by_disturbance.get(label)
            onset = scan.onset if scan else None
            cycle = next((run for run in found.runs if run.persists), None) if found else None
            amplitude = f"{1e3 * cycle.final.amplitude:.2f} mm, {cycle.final.frequency:.2f} Hz" if cycle else "–"
            mode = (f"{onset.frequency:.2f}", onset.name) if onset else ("–", "–")
            rows.append(
                (label, speeds.linear_cell(scan), *mode, speeds.between(found) if found else "not computed", amplitude)
            )
        header = ("on", "linear critical speed [km/h]", "frequency [Hz]", "mode", "by disturbance", "limit cycle there")
        return Table(header, rows)

    def _hunting(self, results: Results) -> list[Block]:
        tables = {
            label: hunting_table(found.runs, found.disturbance) for label, found in results.by_disturbance.items()
        }
        figures: dict[str, Figure] = {}
        persists = any(bool((table["persists"] == 1).any()) for table in tables.values())
        if persists or any(modes.attrs["hunting_mode"] for modes in results.modes.values()):
            figures["hunting"] = hunting_frequencies(results.modes, tables)
        if tables:
            top = self.speeds_kmh[-1] * 1.1
            lines = {f"linear, {label}": v for label in results.linear if (v := results.linear_kmh(label)) < top}
            figures["amplitude"] = amplitude_over_speed(tables, lines)
        return [Picture(name, figure, CAPTIONS[name]) for name, figure in figures.items()]

    def _radius(self, results: Results) -> list[Block]:
        if results.over_radius is None:
            return []
        caption = "Linear critical speeds: rollers and track with the head and gauge of the rig compared."
        rig = self.rig.support.data
        marked = rig.roller_radius if isinstance(rig, Rig) else math.nan
        return [
            speeds.radius_table(results.over_radius, caption),
            *(Text(line) for line in speeds.radius_sentences(results.over_radius)),
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

    def _supports(self) -> Table:
        rows = []
        for label, case in self.supports.items():
            support = case.support.data
            radius = support.roller_radius if isinstance(support, Rig) else math.inf
            rows.append((label, support.name, support.description, speeds.support_words(radius), support.source))
        first = next(iter(self.supports.values()))
        caption = (
            f"{first.vehicle.data.description}; {speeds.words(first.vehicle.cut)}, speed-controlled rollers and rails."
        )
        return Table(("label", "support", "description", "radius", "source"), rows, caption)


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


def _characteristics(results: Results, numbers: Numbers) -> list[Block]:
    if not results.conicity:
        return []
    entries = {label: numbers["supports"][label] for label in results.conicity}
    caption = "Equivalent conicity (EN 15302) over the amplitude; on rollers with the rollers' own radii."
    figure = characteristics_figure(results.shifts, results.conicity)
    return [
        QUANTITIES.table(entries, [f"conicity_{mm:g}mm" for mm in AT_MM], caption, "on"),
        Picture("characteristics", figure, CAPTIONS["characteristics"]),
    ]


def _rows(entries: Sequence[Mapping[str, Any]]) -> list[list[object]]:
    """Entries of the summary as rows of a CSV file, header first."""
    return [list(entries[0]), *(list(entry.values()) for entry in entries)] if entries else []


# ---------------------------------------------------------------------------------------------------- cases and jobs


def run_speeds(speeds_kmh: Sequence[float]) -> list[float]:
    """Speeds of the runs: at least LEAST_RUN_STEP apart [km/h]."""
    chosen = [speeds_kmh[0]]
    for speed in speeds_kmh[1:]:
        if speed - chosen[-1] >= LEAST_RUN_STEP - 1e-9:
            chosen.append(speed)
    return chosen
