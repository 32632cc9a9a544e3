"""The paper's two studies: critical speed of a bogie on rollers (figure 7) and traction (figure 8).

plan -> [PaperStudy] -> modes, ramps, runs from a disturbance, traction -> figures, checks against theory, report
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from rollerrig.analysis import CriticalSpeedByDisturbance, ramp_run
from rollerrig.analysis.contact_state import contact_state
from rollerrig.analysis.critical_speed import scan_linear
from rollerrig.analysis.traction import with_theory
from rollerrig.config import Case
from rollerrig.study import critical_speeds as speeds
from rollerrig.study import paper_tables as tables
from rollerrig.study import paper_text as text
from rollerrig.study.checks import check_table, counts_text
from rollerrig.study.contact_sensitivity import sensitivity_table
from rollerrig.study.frame import Study
from rollerrig.study.jobs import Done, Round, job, whole_modes, whole_run
from rollerrig.study.paper_checks import energy_checks, order_check, traction_checks
from rollerrig.study.paper_figures import CAPTIONS, figures
from rollerrig.study.paper_fit import fit_paragraphs, fit_table
from rollerrig.study.paper_numbers import QUANTITIES, numbers_of
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
    contact_model_cases,
    rig_case,
    traction_case,
)
from rollerrig.study.quantities import Numbers
from rollerrig.study.report import Block, Mark, Picture, Section, Table, Text
from rollerrig.wording import number


@dataclass(frozen=True)
class PaperStudy(Study[Results]):
    """Both studies of the paper.

    Attributes:
        chosen: what is computed.
    """

    chosen: PaperPlan = FULL

    command = "paper"
    quantities = QUANTITIES
    writes = ("data/*.nc", "data/*.csv")
    formats = ("svg", "png")
    round_ends = (0.2, 0.8)

    @property
    def title(self) -> str:
        return "A bogie on a roller rig: critical speed and traction"

    @property
    def mark(self) -> Mark | None:
        return self.chosen.mark

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
        models = contact_model_cases(plan)
        cases, started = cases | models, started | dict.fromkeys(models, plan.sensitivity_kmh)
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
        found = Results(
            modes={material: found for material, found in modes.items() if found},
            merging={m: named("merging", {b: f"{m} {b:g}" for b in plan.criteria}) for m in MATERIALS},  # type: ignore[misc]
            contact=named("contact", {m: m for m in MATERIALS}),
            ramps=ramps,
            runs=runs,
            vehicle_runs=of(VEHICLE),
            sensitivity=speeds.brackets(list(contact_model_cases(plan)), plan.hunting, done),
            over_radius={material: one for material, one in radii.items() if one is not None},
            effects={material: one for material, one in splits.items() if one is not None},
            traction=run,
            theory=theory,
            checks=checks,
        )
        for m, variant in itertools.product(MATERIALS, (RIG, VEHICLE)):
            name = f"{text.NAMES[m]}, {variant}"
            checks += order_check(name, found.by_disturbance(m, variant), found.linear_kmh(m, variant))
        return found

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
        return numbers_of(results)

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
        passed = counts_text(results.checks)
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
                by = results.by_disturbance(material, variant).text("km/h", 1) if found else ""
                linear = text.linear(results.linear_kmh(material, variant), self.chosen)
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
        blocks: list[Block] = [Text(line) for line in fit_paragraphs(results)] or [Text("Not computed.")]
        table = fit_table(results)
        blocks += [table] if table else []
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
        if results.sensitivity:
            blocks.append(sensitivity_table(results.sensitivity))
        return blocks
