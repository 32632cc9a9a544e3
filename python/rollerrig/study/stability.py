"""The stability of one case: modes over speed, limit cycles, critical speeds.

Case, speeds -> [StabilityStudy] -> stability.nc, tables of modes, shapes and limit cycles, report
"""

import itertools
import json
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Annotated, Any

import numpy as np
import xarray as xr

from rollerrig import plot
from rollerrig.analysis import SPEEDS_KMH
from rollerrig.analysis.bifurcation import bifurcation
from rollerrig.analysis.critical_speed import HIGHEST_KMH, LinearCriticalSpeed, scan_linear
from rollerrig.analysis.limit_cycle import Diagram
from rollerrig.analysis.limit_cycle_runs import LimitCycleSettings, limit_cycle_table, settling_run
from rollerrig.analysis.mode_table import stability as modes_over_speed
from rollerrig.analysis.stability_sensitivity import parameter_rows, stability_sensitivity
from rollerrig.cases import as_case
from rollerrig.config import Case, Track
from rollerrig.config.schema.contact import NORMAL_LAWS
from rollerrig.plot.modes import shape_speed, shown_modes
from rollerrig.results.termination import in_words
from rollerrig.simulation.starting_state import StartError
from rollerrig.study import limit_cycles as cycles
from rollerrig.study.frame import Outcome, Study, dataset_rows
from rollerrig.study.jobs import Chains, Done, Job, Progress, Round, job
from rollerrig.study.limit_cycles import cycle_chains, cycle_diagram
from rollerrig.study.options import Option, command
from rollerrig.study.quantities import Numbers
from rollerrig.study.report import VIEW, Block, Picture, Section, Table, Text

TABLES = ("modes", "shapes", "limit_cycles", "contact_effects", "branch", "sensitivity")
ABOVE, BRANCH = "linear critical speed above the range", "branch of limit cycles"
SENSITIVITY = "sensitivity of the linear critical speed"

SUSPENSION_WORDS = ("car body", "bogie", "bogies", "front bogie", "rear bogie")
"""How the names of those modes begin whose shapes are drawn together."""

MODE_COLUMNS = {  # column of modes.csv -> variable
    "speed_kmh": "speed",
    "mode": "mode",
    "growth_rate_per_s": "growth_rate",
    "frequency_hz": "frequency",
    "damping": "damping",
}

SHAPE_COLUMNS = {  # column of shapes.csv -> variable
    **{name: MODE_COLUMNS[name] for name in ("speed_kmh", "mode")},
    "body": "body",
    "direction": "direction",
    "amplitude": "shape_amplitude",
    "phase_deg": "shape_phase",
    "energy_share": "energy_share",
}


def line_sentences(case: Case) -> list[str]:
    """That the modes of a line of several segments are those of its first one; nothing for a line of one or none."""
    line = case.support.data.line if isinstance(case.support.data, Track) else None
    if line is None or len(line.segments) < 2:
        return []
    return [
        f"The line of this case has {len(line.segments)} segments. Everything here belongs to the first, "
        f"{in_words(line.segments[0])}, continued without end: for a curve give a track that begins with it."
    ]


def mode_rows(modes: xr.Dataset) -> list[list[object]]:
    """Table of all modes over speed, header first."""
    return dataset_rows(modes, MODE_COLUMNS, "speed", "mode")


def mode_table(modes: xr.Dataset) -> Table:
    """Frequency and damping of the modes shown, at the lowest, a middle and the highest speed."""
    picks = sorted({0, modes.sizes["speed"] // 2, modes.sizes["speed"] - 1})
    rows = []
    for name in shown_modes(modes):
        pairs = zip(*(modes[what].sel(mode=name).to_numpy()[picks] for what in ("frequency", "damping")), strict=True)
        rows.append([name, *(f"{frequency:.2f},  {100 * damping:.1f}" for frequency, damping in pairs)])
    header = ["mode", *(f"{modes['speed'][k]:g} km/h: f [Hz], damping [%]" for k in picks)]
    return Table(header, rows, "Frequency and damping; all modes at all speeds are in modes.csv.")


def shape_blocks(modes: xr.Dataset) -> list[Block]:
    """Pictures and tables of the mode shapes."""
    speed, shown = shape_speed(modes), shown_modes(modes)
    blocks: list[Block] = [
        Text(
            f"All at {speed:g} km/h, the speed of the table nearest to the linear critical one, or the highest. Displacements "
            f"are not to scale; outlines are schematic, dashed in their design position: wheelset red, bogie blue, car body "
            "green. x points forward, y to the left. In the tables: displacement amplitudes in m and rad, the largest 1, phase "
            "in degrees, without parts below 0.02. All modes at all speeds are in shapes.csv."
        )
    ]
    critical = modes.attrs["linear_critical_mode"] or modes.attrs["hunting_mode"]
    oscillates = critical and float(modes["frequency"].sel(mode=critical, speed=speed)) > 0.0
    if drawn := [n for n in shown if (oscillates and n == critical) or n.startswith(SUSPENSION_WORDS)]:
        caption = "The critical mode and those of the suspension, each in the view that shows most of it."
        blocks.append(Picture("mode_shapes", plot.mode_shapes(modes, drawn, speed), caption))
    ordered = sorted(shown, key=lambda name: not name.startswith("hunting"))
    return [*blocks, *(_shape_table(modes.sel(speed=speed, mode=name)) for name in ordered)]


def _shape_table(mode: xr.Dataset) -> Table:
    rows = []
    for body in mode["body"].to_numpy():
        own = (mode[name].sel(body=body).to_numpy() for name in ("shape_amplitude", "shape_phase"))
        cells = [f"{a:.2f} ∠ {round(float(p)):d}°" if a >= 0.02 else "" for a, p in zip(*own, strict=True)]
        rows.append([str(body).replace("_", " "), *cells])
    caption = f"{mode['mode'].item()}, {float(mode['frequency']):.2f} Hz at {float(mode['speed']):g} km/h"
    return Table(["body", *mode["direction"].to_numpy().tolist()], rows, caption)


BRANCH_COLUMNS = {  # column of branch.csv -> variable, and factor
    "amplitude_mm": ("amplitude", 1e3),
    "speed_kmh": ("speed", 1.0),
    "frequency_hz": ("frequency", 1.0),
    "multiplier": ("multiplier", 1.0),
    "speed_slope_kmh_per_mm": ("speed_slope", 1.0),
}


def branch_numbers(branch: xr.Dataset) -> dict[str, Any]:
    """The branch of `bifurcation`: nonlinear critical speed, folds, why it ends, its limit cycles."""
    points = [
        {
            **{key: factor * float(branch[name][i]) for key, (name, factor) in BRANCH_COLUMNS.items()},
            "stable": bool(branch["stable"][i]),
        }
        for i in range(branch.sizes["cycle"])
    ]
    attributes = branch.attrs
    lowest, ended = float(attributes["nonlinear_critical_speed_kmh"]), str(attributes["ended"])
    folds = json.loads(attributes["folds"])
    return {"nonlinear_critical_speed_kmh": lowest, "folds": folds, "ended": ended, "points": points}


def branch_sentences(branch: Mapping[str, Any], linear_kmh: float) -> list[str]:
    """The nonlinear critical speed, how the branch begins and where it ends."""
    if not branch["points"]:
        return [f"The branch of limit cycles cannot be followed, it ends {branch['ended']}."]
    begin, kind = ("Stable", "supercritical") if branch["points"][0]["stable"] else ("Unstable", "subcritical")
    lowest = branch["nonlinear_critical_speed_kmh"]
    found = "not found, none is stable as far as it was followed" if lowest is None else f"{lowest:.2f} km/h"
    return [
        f"Nonlinear critical speed, the lowest with a stable limit cycle on the branch: {found}.",
        f"{begin} limit cycles begin at the linear critical speed, {linear_kmh:.2f} km/h ({kind}). The branch ends "
        f"{branch['ended']}.",
    ]


CONTACT = "contact model"
CREEP_LAWS = ("kalker_saturated", "table")  # the paper's and the exact one; what lies between them is in the theory

COUNTERPART = {"rig": ("track", "uic60_track"), "track": ("rig", "full_scale_rig")}
"""Kind of support -> the other kind, and the catalogue's support of that kind."""

CONTACT_SETTINGS = LimitCycleSettings(longest=8.0)


def contact_effect_jobs(
    case: Case, speeds_kmh: Sequence[float], run_speed_kmh: float, creeps: Sequence[str] = CREEP_LAWS
) -> dict[str, Job]:
    """A job per normal contact and creep law, on the case's own support and on the catalogue's of the other kind.

    The critical speed is looked for in a range [km/h], the run from a lateral offset has one speed [km/h].
    """
    own, speeds = case.support.data.kind, tuple(speeds_kmh)
    other, support = COUNTERPART[own]
    cases = {own: case, other: case.with_changes({"support.use": support})}
    every = itertools.product(cases, NORMAL_LAWS, creeps)
    return {
        f"{CONTACT} {', '.join(one)}": job(contact_effect, cases[one[0]], one, speeds, run_speed_kmh) for one in every
    }


def contact_effect(
    case: Case,
    names: tuple[str, str, str],
    speeds_kmh: Sequence[float],
    run_speed_kmh: float,
    progress: Progress | None = None,
) -> dict[str, Any]:
    """Linear critical speed, and the limit cycle at one speed from a lateral offset, with one contact model."""
    support, normal, creep = names
    chosen = case.with_changes({"contact.normal": normal, "contact.creep": creep})
    linear = scan_linear(chosen, speeds_kmh)
    if linear.problem:
        raise StartError(linear.problem)
    point, _ = settling_run(chosen, CONTACT_SETTINGS, CONTACT_SETTINGS.disturbance, run_speed_kmh / 3.6, None, progress)
    return {
        "support": support,
        "normal": normal,
        "creep": creep,
        "linear_critical_speed_kmh": linear.speed_kmh,
        "frequency_hz": linear.onset.frequency if linear.onset else math.nan,
        "run_speed_kmh": run_speed_kmh,
        "limit_cycle_mm": 1e3 * point.amplitude,
        "guiding_force_kn": 1e-3 * point.guiding_force,
        "status": point.status,
    }


MOST_CYCLE_SPEEDS = 20  # runs are made at no more speeds than this, spread over the range


@dataclass(frozen=True)
class Results:
    """Modes over speed, limit-cycle diagram, contact models, branch, sensitivity; None and empty where not asked for.

    `above` is the linear critical speed above the range of the modes, where that has none.
    """

    modes: xr.Dataset
    above: LinearCriticalSpeed | None
    diagram: Diagram | None
    contact: Sequence[Mapping[str, Any]]
    branch: xr.Dataset | None
    sensitivity: xr.Dataset | None


@dataclass(frozen=True)
class StabilityStudy(Study[Results]):
    """Modes over speed and the limit-cycle diagram; attributes as the arguments of `stability`.

    Runs are made at no more than MOST_CYCLE_SPEEDS of the speeds.
    """

    case: Case
    speeds_kmh: tuple[float, ...]
    with_limit_cycles: bool = True
    settings: LimitCycleSettings = field(default_factory=LimitCycleSettings)
    contacts_kmh: float | None = None
    branch: float | None = None
    sensitivity: bool = False

    command = "stability"
    heading = "Stability: {case.name}"
    assumes = (
        "The linear model is exact for small motions around steady rolling; it includes neither flange contact nor "
        "saturation beyond its slope.",
        "Rollers or rails are speed-controlled at each speed; torques keep their value at time 0.",
    )
    writes = ("stability.nc", *(f"{name}.csv" for name in TABLES), VIEW)
    formats = ("svg",)

    @property
    def round_ends(self) -> tuple[float, ...]:  # type: ignore[override]
        """The modes take a tenth of the runs."""
        return (0.08, 0.1, 1.0) if self.with_limit_cycles else (0.8, 1.0)

    def rounds(self, done: Done) -> Iterator[Round | Chains]:
        yield {"modes": job(modes_over_speed, self.case, self.speeds_kmh)}
        attributes, top = done["modes"].attrs, self.speeds_kmh[-1]
        linear = attributes["linear_critical_speed_kmh"]
        none = not math.isfinite(linear)
        search = none and not json.loads(attributes["grows_at_lowest_speed"]) and top < HIGHEST_KMH
        yield {ABOVE: job(scan_linear, self.case, (top, HIGHEST_KMH))} if search else {}
        if self.with_limit_cycles:
            yield cycle_chains(self.case, cycle_speeds(self.speeds_kmh), self.settings)
        if self.contacts_kmh is not None:
            yield contact_effect_jobs(self.case, self.speeds_kmh, self.contacts_kmh)
        if self.branch is not None and not none:
            yield {BRANCH: job(bifurcation, self.case, self.speeds_kmh, self.branch)}
        linear = done[ABOVE].speed_kmh if search else linear
        if self.sensitivity and math.isfinite(linear):
            yield {SENSITIVITY: job(stability_sensitivity, self.case, None, (0.99 * linear, 1.01 * linear))}

    def collect(self, done: Done) -> Results | None:
        if "modes" not in done:
            return None
        modes, above, diagram = done["modes"], done.get(ABOVE), None
        if self.with_limit_cycles:
            linear = above.speed_kmh if above else float(modes.attrs["linear_critical_speed_kmh"])
            found = cycle_diagram(cycle_speeds(self.speeds_kmh), linear, self.settings, done)
            diagram = found if found.up or found.down else None
        contact = [result for name, result in done.items() if name.startswith(CONTACT)]
        return Results(modes, above, diagram, contact, done.get(BRANCH), done.get(SENSITIVITY))

    def numbers(self, results: Results) -> dict[str, Any]:
        attributes = results.modes.attrs
        oscillates = results.modes["frequency"] > 0.05
        found = {
            "case": self.case.name,
            "speeds_kmh": results.modes["speed"].to_numpy().round(9),
            **{key: attributes[key] for key in (f"linear_critical_{n}" for n in ("speed_kmh", "frequency_hz", "mode"))},
            "linear_searched_to_kmh": float(results.modes["speed"][-1]),
            **{key: json.loads(attributes[key]) for key in ("crossings", "grows_at_lowest_speed", "diverging")},
            "least_damping": results.modes["damping"].where(oscillates).min("mode").to_numpy(),
        }
        if results.above is not None and not results.above.problem:
            onset = results.above.onset
            found["linear_searched_to_kmh"] = HIGHEST_KMH
            if onset is not None:
                found |= {"linear_critical_speed_kmh": results.above.speed_kmh, "linear_critical_mode": onset.name}
                found["linear_critical_frequency_hz"] = onset.frequency
        if results.diagram is not None:
            found["limit_cycles"] = cycles.cycle_numbers(results.diagram, self.settings)
        if results.contact:
            found["contact_effects"] = results.contact
        if results.branch is not None:
            found["branch"] = branch_numbers(results.branch)
        if results.sensitivity is not None:
            change = results.sensitivity["critical_speed_change"]
            relative = change / results.sensitivity.attrs["linear_critical_speed_kmh"]
            found["sensitivity"] = parameter_rows(
                results.sensitivity, {"change_kmh": change, "relative_change": relative}
            )
        return found

    def summary(self, results: Results, numbers: Numbers) -> list[str]:
        speeds, lines = numbers["speeds_kmh"], line_sentences(self.case)
        if numbers["grows_at_lowest_speed"]:
            growing = ", ".join(numbers["grows_at_lowest_speed"])
            lines.append(f"Unstable already at {speeds[0]:g} km/h, the lowest speed: {growing}.")
        if numbers["linear_critical_speed_kmh"] is not None or not numbers["grows_at_lowest_speed"]:
            lines.append(_linear_sentence(numbers, results.above))
        lines += [
            f"{one['name'].capitalize()} grows without oscillating, at up to {one['growth_rate_per_s']:.2g} 1/s: the "
            "vehicle is not restrained; on rollers it needs a longitudinal restraint, e.g. locked = ['x'] for its car body."
            for one in numbers["diverging"]
        ]
        if self.branch is not None and not math.isfinite(results.modes.attrs["linear_critical_speed_kmh"]):
            lines.append("No branch of limit cycles: it begins at the linear critical speed; ask for speeds around it.")
        if results.branch is not None:
            lines += branch_sentences(numbers["branch"], numbers["linear_critical_speed_kmh"])
        if numbers.get("sensitivity"):
            most = numbers["sensitivity"][0]
            change = f"{most['change_kmh']:+.2g} km/h if that is 1 % larger"
            lines.append(f"It is moved most by {most['parameter']}: {change}.")
        return lines if results.diagram is None else [*lines, *cycles.continuation_sentences(results.diagram)]

    def shown(self, results: Results) -> Mapping[str, xr.Dataset]:
        return {f"modes of {self.case.name}": results.modes}

    def files(self, results: Results, numbers: Numbers) -> Mapping[str, Any]:
        modes, data = results.modes, results.modes
        if results.diagram is not None:
            data = modes.merge(limit_cycle_table(results.diagram), combine_attrs="drop_conflicts")
        found = {"stability.nc": data, "modes.csv": mode_rows(modes)}
        found["shapes.csv"] = dataset_rows(modes, SHAPE_COLUMNS, "speed", "mode", "body", "direction")
        tables = {name: numbers[name] for name in ("contact_effects", "sensitivity") if name in numbers}
        tables |= {f"{name}.points": numbers[name]["points"] for name in ("limit_cycles", "branch") if name in numbers}
        for key, rows in tables.items():
            found[f"{key.removesuffix('.points')}.csv"] = self.quantities.csv(rows, f"{key}.*")
        return found

    def sections(self, results: Results, numbers: Numbers) -> list[Section]:
        runs = None if results.diagram is None else limit_cycle_table(results.diagram)
        found = [Section("Modes", self._modes(results.modes, runs, numbers))]
        if results.sensitivity is not None and numbers["sensitivity"]:
            blocks = self._sensitivity(results.sensitivity, numbers)
            found.append(Section("What moves the linear critical speed", blocks))
        if results.diagram is not None:
            points = numbers["limit_cycles"]["points"]
            blocks = cycles.cycle_blocks(results.diagram, results.modes, self.settings, points)
            found.append(Section("Limit cycles", blocks))
        if results.branch is not None and numbers["branch"]["points"]:
            found.append(Section("Branch of limit cycles", self._branch(results.branch, numbers)))
        found.append(Section("Mode shapes", shape_blocks(results.modes)))
        if results.contact:
            text = (
                "The same vehicle with each normal contact and creep law. The limit cycle is the end of a run from a "
                f"lateral offset of {1e3 * CONTACT_SETTINGS.disturbance:g} mm of the leading wheelset."
            )
            table = self.quantities.table(numbers["contact_effects"], "contact_effects.*")
            found.append(Section("Effect of the contact model", [Text(text), table]))
        return found

    def _sensitivity(self, found: xr.Dataset, numbers: Numbers) -> list[Block]:
        caption = (
            "Change of the linear critical speed by each stiffness and damping of the suspension, 1 % larger; numbers that equal "
            "elements share change together. Small ones are in the table alone."
        )
        table = self.quantities.table(numbers["sensitivity"], "sensitivity.*", "All of them; values in SI.")
        return [Picture("sensitivity", plot.tornado_diagram(found), caption), table]

    def _branch(self, branch: xr.Dataset, numbers: Numbers) -> list[Block]:
        caption = (
            "Limit cycles that begin at the linear critical speed, found as periodic solutions. Between two stable ones lies an "
            "unstable one: a disturbance beyond it goes to the one above. Branches that do not begin there are not found."
        )
        drawn = Picture("branch", plot.bifurcation_diagram(branch), caption)
        multiplier = "Largest magnitude of a Floquet multiplier: what is left of a small deviation after one period."
        return [drawn, self.quantities.table(numbers["branch"]["points"], "branch.points.*", multiplier)]

    def _modes(self, modes: xr.Dataset, runs: xr.Dataset | None, numbers: Numbers) -> list[Block]:
        drawn = (
            ("frequency", plot.frequency_over_speed(modes, runs), "Frequency over speed, without heavily damped modes."),
            ("damping", plot.damping_over_speed(modes), "Damping ratio over speed; below zero a small disturbance grows."),
            ("damping_map", plot.damping_map(modes), "Damping of all oscillations, with their frequency at the highest speed."),
            ("root_locus", plot.root_locus(modes), "Root locus: eigenvalues over speed, the modes of the first figure."),
        )  # fmt: skip
        names = ["crossings.*.speed_kmh", "mode", "crossings.*.frequency_hz", "grows"]
        where = f"from {modes['speed'][0]:g} to {modes['speed'][-1]:g} km/h"
        crossings: Block = Text(f"No oscillation begins or ends to grow {where}.")
        if numbers["crossings"]:
            caption = "Speeds at which an oscillation begins or ends to grow."
            crossings = self.quantities.table(numbers["crossings"], names, caption)
        return [*(Picture(*one) for one in drawn), crossings, mode_table(modes)]


def _linear_sentence(numbers: Numbers, above: LinearCriticalSpeed | None) -> str:
    """The linear critical speed, or how far it was looked for."""
    low, high = numbers["speeds_kmh"][0], numbers["speeds_kmh"][-1]
    asked = f"from {low:g} to {high:g} km/h" if high > low else f"at {low:g} km/h"
    if (critical := numbers["linear_critical_speed_kmh"]) is not None:
        mode, frequency = numbers["linear_critical_mode"], numbers["linear_critical_frequency_hz"]
        beyond = f" It is above the speeds asked for, {asked}." if above is not None else ""
        return f"Linear critical speed: {critical:.1f} km/h, {mode}, {frequency:.2f} Hz.{beyond}"
    searched = f", nor above up to {numbers['linear_searched_to_kmh']:g} km/h" if above and not above.problem else ""
    problem = f" Not looked for above: {above.problem}" if above and above.problem else ""
    return f"No linear critical speed {asked}{searched}: all oscillations are damped.{problem}"


def cycle_speeds(speeds_kmh: tuple[float, ...]) -> list[float]:
    """Speeds at which runs are made: the first, the last and at most 18 between them, as even as the list allows."""
    count = min(len(speeds_kmh), MOST_CYCLE_SPEEDS)
    picks = np.unique(np.round(np.linspace(0, len(speeds_kmh) - 1, count)).astype(int))
    return [float(speeds_kmh[k]) for k in picks]


@command
def stability(
    case: Case | str,
    speeds_kmh: Sequence[float] = SPEEDS_KMH,
    *,
    limit_cycles: bool = True,
    disturbance: Annotated[float, Option("disturbance_mm", "mm", 0.01, 20.0)] = 3e-3,
    perturbation: Annotated[float, Option("perturbation_mm", "mm", 0.001, 20.0)] = 1e-4,
    longest: Annotated[float, Option(least=2.0, most=600.0)] = 16.0,
    tolerance_kmh: Annotated[float, Option(least=0.01, most=100.0)] = 1.0,
    processes: Annotated[int, Option(least=1, most=2, default=2)] = 1,
    contacts_kmh: Annotated[float | None, Option(least=1.0, most=600.0)] = None,
    branch: Annotated[float | None, Option("branch_mm", "mm", 0.05, 50.0)] = None,
    sensitivity: bool = False,
    progress: Progress | None = None,
) -> Outcome[Results]:
    """Eigenvalues, damping, frequency and mode shapes over speed; limit cycles; critical speeds.

    Args:
        case: case: a name of the catalogue or a TOML file.
        speeds_kmh: speeds [km/h], rising.
        limit_cycles: also run at up to 20 of the speeds, stepped up and down, for limit cycles.
        disturbance: lateral offset of the leading wheelset that starts the downward sweep [m].
        perturbation: the same for the upward sweep [m].
        longest: a run that has not settled by then ends [s].
        tolerance_kmh: to which the critical speed by continuation is found [km/h].
        processes: with 2, the two sweeps run at a time.
        contacts_kmh: also compare the contact models, on rig and track, with a run at this speed [km/h].
        branch: also follow the limit cycles, stable and unstable, from the linear critical speed up to this amplitude [m].
        sensitivity: also draw how each stiffness and damping of the suspension moves the linear critical speed.
        progress: called with the fraction done and a short text.
    """
    settings = LimitCycleSettings(disturbance, perturbation, longest=longest, tolerance_kmh=tolerance_kmh)
    study = StabilityStudy(as_case(case), tuple(speeds_kmh), limit_cycles, settings, contacts_kmh, branch, sensitivity)
    return study.outcome(processes, progress)
