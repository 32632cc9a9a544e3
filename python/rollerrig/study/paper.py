"""The paper's two studies: critical speed of a bogie on rollers (figure 7) and traction (figure 8).

plan -> [PaperStudy] -> modes, ramps, runs from a disturbance, traction -> figures, checks against theory, report
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from matplotlib.figure import Figure

from rollerrig.analysis import CriticalSpeedByDisturbance, HuntingRun, hunting_table, ramp_run
from rollerrig.analysis.contact_state import contact_state
from rollerrig.analysis.critical_speed import scan_linear
from rollerrig.analysis.traction import with_theory
from rollerrig.config import Case, Rig
from rollerrig.plot import amplitude_over_speed, hunting_over_time, ramp_over_speed, traction_forces, traction_sliding
from rollerrig.plot.modes import hunting_frequencies
from rollerrig.study import critical_speeds as speeds
from rollerrig.study import paper_tables as tables
from rollerrig.study import paper_text as text
from rollerrig.study.frame import Study
from rollerrig.study.jobs import Done, Round, job, whole_modes, whole_run
from rollerrig.study.paper_checks import FRONT, REAR, energy_checks, traction_checks
from rollerrig.study.paper_plan import (
    FULL,
    MATERIALS,
    RIG,
    TABLE_PARTS,
    VARIANTS,
    VEHICLE,
    PaperPlan,
    Results,
    case_of,
    rig_case,
    traction_case,
)
from rollerrig.study.quantities import Numbers, Quantities, Quantity
from rollerrig.study.report import Block, Picture, Section, Table, Text, check_table, number

BODY = "front_frame"
WHEELS = {FRONT: "front right wheel", REAR: "rear right wheel"}
LABELS = {"steel": "Steel", "paper": "Paper's material, G = 10 GPa"}

ALL, BY = "materials.*", speeds.by_disturbance_quantities
QUANTITIES = Quantities(
    Quantity(f"{ALL}.linear.*.critical_speed_kmh", "linear, of the bogie on rig and track and the vehicle; null: none", "km/h"),
    Quantity(f"{ALL}.linear.*.frequency_hz", "its frequency", "Hz"),
    Quantity(f"{ALL}.merging_criterion.*", "linear critical speed of the bogie on the rig per merging criterion", "km/h"),
    Quantity(f"{ALL}.onset_wavelength_m", "of the limit cycle at the lowest speed at which it was found", "m"),
    Quantity(f"{ALL}.contact.patches", "per wheel in steady rolling on the rig", "", "patches per wheel"),
    Quantity(f"{ALL}.contact.approach_um", "of the deepest patch", "µm", "deepest approach", 3),
    Quantity(f"{ALL}.contact.creep_stiffness_n", "sum of f₁₁ of a wheel", "N", "Σ f₁₁ of a wheel", 3, ("MN", 1e-6)),
    Quantity(f"{ALL}.contact.wavelength_m", "of slow hunting", "m", "wavelength of slow hunting"),
    BY(f"{ALL}.by_disturbance"),
    BY(f"{ALL}.vehicle_on_track"),
    speeds.roller_quantities(f"{ALL}.critical_speed_over_radius_kmh", f"{ALL}.roller_effects"),
    Quantity("traction", "null: not computed"),
    Quantity("traction.speed_kmh", "figure 8 at the last output time", "km/h"),
    Quantity("traction.*.sliding_mmps", "of a right wheel there", "mm/s"),
    Quantity("traction.*.longitudinal_force_n", "on a right wheel there", "N"),
    Quantity("traction.*.vertical_force_n", "on a right wheel there", "N"),
    Quantity("checks", "empty: nothing was computed that could be checked"),
    Quantity("checks.*.*", "name, value, expected, deviation and tolerance (absolute or relative), passed, its reason"),
    Quantity("checks_passed", "number of checks that passed"),
    Quantity("checks_failed", "number of checks that failed"),
)  # fmt: skip

CAPTIONS = {
    "figure_7a_ramp": "Figure 7a. Lateral displacement of the bogie frame over speed while the rollers are slowly sped up (dark) "
    "from a disturbed start and slowed down again (light). Triangles: lateral perturbations.",
    "figure_7a_time_steel": "Figure 7a, at constant speeds, steel. Lateral displacement of the bogie frame after a "
    "lateral offset of the leading wheelset.",
    "figure_7a_time_paper": "Figure 7a, at constant speeds, paper's material, drawn likewise.",
    "figure_7a_amplitude": "Amplitude at the end of each run at constant speed. Filled: the oscillation persists; open: it "
    "decays. Dashed lines: linear critical speeds.",
    "figure_7b_steel": "Figure 7b, steel. Frequency of the lateral oscillation of the (front) bogie frame, whole vehicle on the "
    "rails against bogie on the rig: of the runs from a disturbance, as in the paper (markers: open where it decays, "
    "filled where it persists), and of the linear model's hunting mode (lines, cross where its damping vanishes).",
    "figure_7b_paper": "Figure 7b, paper's material, drawn likewise.",
    "radius_steel": "Steel. Linear critical speed over the radius of the rollers; horizontal: on track.",
    "radius_paper": "Paper's material. Linear critical speed over the radius of the rollers; horizontal: on track.",
    "roller_effects": "Steel. Loss of linear critical speed of the bogie from track to rig.",
    "figure_8a": "Figure 8a. Absolute sliding of the right wheels on their rollers (longitudinal, mean of the patches weighted "
    "with normal force), torque and speed. Dotted: slope of the creep law at the start × force × speed.",
    "figure_8b": "Figure 8b. Longitudinal and vertical contact force on the right wheels. Dotted: closed forms from the balance "
    "of wheelset, roller and frame.",
}
"""Picture -> what it shows."""


@dataclass(frozen=True)
class PaperStudy(Study[Results]):
    """Both studies of the paper.

    Attributes:
        chosen: what is computed.
    """

    chosen: PaperPlan = FULL

    command = "paper"
    quantities = QUANTITIES
    formats = ("svg", "png")
    round_ends = (0.2, 0.8)

    @property
    def title(self) -> str:
        return "A bogie on a roller rig: critical speed and traction"

    def cases(self) -> Mapping[str, Case]:
        return {"figure 7 (steel)": rig_case("steel"), "figure 8": traction_case(self.chosen)}

    def rounds(self, done: Done) -> Iterator[Round]:
        plan, jobs, first = self.chosen, {}, {}
        scanned = [v / 3.6 for v in plan.linear_kmh]
        cases, started = {}, {}
        for material in MATERIALS:
            rig = rig_case(material)
            for variant in VARIANTS:
                jobs[f"modes {material}, {variant}"] = job(whole_modes, case_of(variant, material), plan.linear_kmh)
            jobs[f"contact {material}"] = job(contact_state, rig)
            for value in plan.criteria:
                changed = rig.with_changes({"contact.normal.merging_criterion": value})
                jobs[f"merging {material} {value:g}"] = job(scan_linear, (changed, scanned))
            jobs |= speeds.roller_jobs(rig, TABLE_PARTS, plan.radii, plan.linear_kmh, f" {material}")
            first[f"ramp {material}"] = job(ramp_run, (rig, plan.ramps[material], plan.hunting))
            for variant, case in ((VEHICLE, case_of(VEHICLE, material)), (RIG, rig)):
                cases[f"{variant} {material}"], started[f"{variant} {material}"] = case, plan.runs_kmh[material]
        yield jobs
        first["traction"] = job(whole_run, traction_case(plan))
        for more in speeds.disturbance_rounds(cases, started, plan.bracket_kmh, plan.hunting, done):
            yield {**first, **more}
            first = {}

    def collect(self, done: Done) -> Results | None:
        plan = self.chosen

        def named(kind: str, names: Mapping[str, Any]) -> dict[Any, Any]:
            return {key: done[name] for key, label in names.items() if (name := f"{kind} {label}") in done}

        def of(variant: str) -> dict[str, CriticalSpeedByDisturbance]:
            found = speeds.brackets([f"{variant} {m}" for m in MATERIALS], plan.hunting, done)
            return {label.removeprefix(f"{variant} "): one for label, one in found.items()}

        modes = {m: named("modes", {v: f"{m}, {v}" for v in VARIANTS}) for m in MATERIALS}
        radii = {m: speeds.over_radius(done, TABLE_PARTS, plan.radii, f" {m}") for m in MATERIALS}
        splits = {m: speeds.effect_split(done, f" {m}") for m in MATERIALS}
        run, case, runs = done.get("traction"), traction_case(plan), of(RIG)
        theory = None if run is None else with_theory(run, case)
        checks = [] if run is None or theory is None else [*traction_checks(run, theory, case)]
        ramps = named("ramp", {m: m for m in MATERIALS})
        for material in MATERIALS:
            own = [one.motion for one in runs[material].runs] if material in runs else []
            checks += energy_checks(material, own, ramps.get(material))
        return Results(
            modes={material: found for material, found in modes.items() if found},
            merging={m: named("merging", {b: f"{m} {b:g}" for b in plan.criteria}) for m in MATERIALS},  # type: ignore[misc]
            contact=named("contact", {m: m for m in MATERIALS}),
            ramps=ramps,
            runs=runs,
            vehicle_runs=of(VEHICLE),
            over_radius={material: one for material, one in radii.items() if one is not None},
            effects={material: one for material, one in splits.items() if one is not None},
            traction=run,
            theory=theory,
            checks=checks,
        )

    def limitations(self) -> list[str]:
        fixed = (
            "The frame settles on the contacts while the car body is fixed, as in the paper: the wheel loads are about 0.1 % "
            "below their static values."
        )
        return [fixed, *super().limitations()]

    def sources(self, results: Results) -> Mapping[str, str]:
        return {
            "paper": "M. Malvezzi, E. Meli, L. Pugi: Simulation of degraded wheel/rail adhesion conditions on a railway roller "
            "rig for the evaluation of the effect of wheel/roller contact on control performance, 2010"
        }

    # --------------------------------------------------------------------------------------------------- numbers

    def numbers(self, results: Results) -> dict[str, Any]:
        return {
            "materials": {material: self._material(results, material) for material in results.modes},
            "traction": None if results.theory is None else tables.traction_numbers(results.theory),
            "checks": [check.as_dict() for check in results.checks],
            "checks_passed": sum(check.passed for check in results.checks),
            "checks_failed": sum(not check.passed for check in results.checks),
        }

    def _material(self, results: Results, material: str) -> dict[str, Any]:
        found: dict[str, Any] = {
            "linear": {
                variant: {
                    "critical_speed_kmh": results.linear_kmh(material, variant),
                    "frequency_hz": float(modes.attrs["linear_critical_frequency_hz"]),
                }
                for variant, modes in results.modes[material].items()
            },
            "merging_criterion": {f"{b:g}": scan.speed_kmh for b, scan in results.merging.get(material, {}).items()},
            "onset_wavelength_m": text.onset_wavelength(results, material),
        }
        if material in results.contact:
            contact = results.contact[material]
            found["contact"] = {
                "patches": contact.patches,
                "approach_um": 1e6 * contact.approach,
                "creep_stiffness_n": contact.creep_stiffness,
                "wavelength_m": contact.wavelength,
            }
        for key, brackets in (("by_disturbance", results.runs), ("vehicle_on_track", results.vehicle_runs)):
            if material in brackets:
                found[key] = speeds.disturbance_numbers(brackets[material])
        if material in results.over_radius:
            found["critical_speed_over_radius_kmh"] = speeds.radius_numbers(results.over_radius[material])
        if material in results.effects:
            found["roller_effects"] = speeds.effect_numbers(results.effects[material])
        return found

    def summary(self, results: Results, numbers: Numbers) -> list[str]:
        return text.summary(results, numbers, self.chosen)

    def files(self, results: Results, numbers: Numbers) -> Mapping[str, Any]:
        found: dict[str, Any] = {}
        for material, variants in results.modes.items():
            for variant, modes in variants.items():
                found[f"data/modes_{material}_{variant.replace(' ', '_')}.nc"] = modes
        found |= {f"data/ramp_{material}.nc": ramp for material, ramp in results.ramps.items()}
        for material, one in results.runs.items():
            found |= {f"data/run_{material}_{3.6 * run.speed:.2f}_kmh.nc": run.motion for run in one.runs}
            found[f"data/figure_7_runs_{material}.csv"] = tables.run_columns(one)
        for material, one in results.vehicle_runs.items():
            found[f"data/figure_7b_vehicle_runs_{material}.csv"] = tables.run_columns(one)
        if results.modes:
            found["data/figure_7b_linear.csv"] = tables.frequency_rows(results)
        if results.traction is not None and results.theory is not None:
            found["data/traction.nc"] = results.traction
            found["data/figure_8.csv"] = tables.traction_columns(results.theory)
        return found

    # ---------------------------------------------------------------------------------------------------- report

    def sections(self, results: Results, numbers: Numbers) -> list[Section]:
        drawn = {name: Picture(name, figure, CAPTIONS[name]) for name, figure in figures(results).items()}

        def pictures(*names: str) -> list[Block]:
            return [drawn[name] for name in names if name in drawn] or [Text("Not computed.")]

        def texts(lines: list[str]) -> list[Block]:
            return [Text(line) for line in lines]

        radii, effects = results.over_radius, results.effects
        changes = [
            speeds.radius_table(table, f"Linear critical speeds, {text.NAMES[m]}: bogie (car body fixed) and vehicle.")
            for m, table in radii.items()
        ]
        splits = [
            speeds.effects_table(split, f"Track less rig, {text.NAMES[m]}, bogie: effects of the rollers switched.")
            for m, split in effects.items()
        ]
        passed = f"{numbers['checks_passed']} of {len(results.checks)} checks passed."
        stability: list[Block] = [
            self._critical(results),
            *texts(text.critical_paragraphs(results)),
            Text(text.ramp_text(self.chosen)),
            *pictures("figure_7a_ramp"),
            Text(text.CONSTANT_SPEED),
            *pictures("figure_7a_time_steel", "figure_7a_time_paper", "figure_7a_amplitude"),
            *texts(text.frequency_paragraphs(results, self.chosen)),
            *pictures("figure_7b_steel", "figure_7b_paper"),
        ]
        rig = [*texts(text.rig_paragraphs(results)), *changes, *pictures("radius_steel", "radius_paper"), *splits]
        return [
            Section("Figure 7: stability", stability),
            Section("What the rig changes", [*rig, *pictures("roller_effects")]),
            Section("Which material fits the paper", self._fit(results, numbers)),
            Section("Figure 8: traction", [Text(text.TRACTION), *pictures("figure_8a", "figure_8b")]),
            Section("Checks", [Text(passed), check_table(results.checks)] if results.checks else [Text("No checks.")]),
            Section("Solver and contact", [tables.solver_table(results), tables.counter_table(results)]),
            Section("Parameters", tables.parameters(self.chosen)),
        ]

    def _critical(self, results: Results) -> Table:
        rows = []
        for material, variants in results.modes.items():
            for variant, modes in variants.items():
                frequency = float(modes.attrs["linear_critical_frequency_hz"])
                found = {RIG: results.runs, VEHICLE: results.vehicle_runs}.get(variant, {}).get(material)
                by = f"{text.kmh(3.6 * found.decays, 1)} … {text.kmh(3.6 * found.persists, 1)}" if found else ""
                linear = text.kmh(results.linear_kmh(material, variant), 1)
                rows.append((text.NAMES[material], variant, linear, f"{number(frequency, 3)} Hz", by))
        size = 1e3 * self.chosen.hunting.disturbance
        header = (
            "material",
            "vehicle and support",
            "linear critical speed",
            "its frequency",
            "by disturbance: decays … persists",
        )
        return Table(header, rows, f"By disturbance: from a lateral offset of {size:g} mm of the leading wheelset.")

    def _fit(self, results: Results, numbers: Numbers) -> list[Block]:
        blocks: list[Block] = [Text(line) for line in text.fit_paragraphs(results)] or [Text("Not computed.")]
        if results.contact:
            entries = {text.NAMES[m]: numbers["materials"][m]["contact"] for m in results.contact if m in results.modes}
            names = ("patches", "approach_um", "creep_stiffness_n", "wavelength_m")
            blocks.append(QUANTITIES.table(entries, names, "Steady rolling on the rig, small motions.", "material"))
        if any(results.merging.values()):
            rows = [
                [f"{b:g}", *(speeds.linear_cell(results.merging[m].get(b)) for m in MATERIALS)]
                for b in self.chosen.criteria
            ]
            caption = (
                "Linear critical speed [km/h] of the bogie on the rig over the merging criterion of adjacent patches."
            )
            blocks.append(Table(("merging criterion", *(text.NAMES[m] for m in MATERIALS)), rows, caption))
        return blocks


# --------------------------------------------------------------------------------------------------------- figures


def figures(results: Results) -> dict[str, Figure]:
    """All figures for which something was computed, by name."""
    found: dict[str, Figure] = {}
    if results.ramps:
        lines = {
            LABELS[m]: {"linear": results.linear_kmh(m), "by disturbance": results.by_disturbance_kmh(m)}
            for m in results.ramps
        }
        found["figure_7a_ramp"] = ramp_over_speed({LABELS[m]: ramp for m, ramp in results.ramps.items()}, BODY, lines)
    by_speed = {m: hunting_table(one.runs, one.disturbance) for m, one in results.runs.items()}
    for material, one in results.runs.items():
        chosen = [(3.6 * run.speed, run.motion) for run in around_onset(one.runs, one.speed)]
        found[f"figure_7a_time_{material}"] = hunting_over_time(chosen, BODY, LABELS[material])
    if by_speed:
        critical = {f"linear, {m}": results.linear_kmh(m) for m in by_speed}
        found["figure_7a_amplitude"] = amplitude_over_speed({LABELS[m]: t for m, t in by_speed.items()}, critical)
    for material, modes in results.modes.items():
        runs = {RIG: by_speed[material]} if material in by_speed else {}
        if material in results.vehicle_runs:
            vehicle = results.vehicle_runs[material]
            runs[VEHICLE] = hunting_table(vehicle.runs, vehicle.disturbance)
        found[f"figure_7b_{material}"] = hunting_frequencies(modes, runs, LABELS[material])
    rig = rig_case(MATERIALS[0]).support.data
    assert isinstance(rig, Rig)
    for material, table in results.over_radius.items():
        found[f"radius_{material}"] = speeds.radius_picture("", table, rig.roller_radius, "").figure
    if MATERIALS[0] in results.effects:
        found["roller_effects"] = speeds.effects_picture("", results.effects[MATERIALS[0]], "").figure
    if results.theory is not None:
        found["figure_8a"] = traction_sliding(results.theory, WHEELS)
        found["figure_8b"] = traction_forces(results.theory, WHEELS)
    return found


def around_onset(runs: list[HuntingRun], onset: float, count: int = 6) -> list[HuntingRun]:
    """Runs on both sides of the onset [m/s] and further away, by speed; spread evenly if there is no onset."""
    if not math.isfinite(onset):
        return runs[:: max(1, math.ceil(len(runs) / count))]
    below = [run for run in runs if run.speed < onset]
    above = [run for run in runs if run.speed >= onset]
    far_below = [run for run in below[:-1] if run.speed < onset - 8 / 3.6]
    far_above = [run for run in above[1:] if run.speed > onset + 8 / 3.6]
    picked = below[-1:] + above[:1] + far_below[-1:] + far_above[:1] + far_above[2:3] + far_above[-1:]
    unique = {run.speed: run for run in picked}
    return [unique[speed] for speed in sorted(unique)][:count]
