"""The paper's two studies: critical speed of a bogie on rollers (figure 7) and traction (figure 8).

plan -> [PaperStudy] -> modes, ramps, runs from a disturbance, traction -> figures, checks against theory, report
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import xarray as xr

from rollerrig.analysis import ramp_run
from rollerrig.analysis.contact_state import contact_state
from rollerrig.analysis.critical_speed import scan_linear
from rollerrig.config import Case
from rollerrig.study import critical_speeds as speeds
from rollerrig.study import paper_tables as tables
from rollerrig.study import paper_text as text
from rollerrig.study.checks import check_table, counts_text
from rollerrig.study.frame import Study
from rollerrig.study.jobs import Done, Round, job, whole_modes, whole_run
from rollerrig.study.paper_compared import compared
from rollerrig.study.paper_contacts import exact_cases, exact_jobs
from rollerrig.study.paper_figures import CAPTIONS, figures
from rollerrig.study.paper_fit import fit_blocks
from rollerrig.study.paper_numbers import QUANTITIES, numbers_of
from rollerrig.study.paper_plan import (
    FULL,
    MATERIALS,
    NAMES,
    RIG,
    TABLE_PARTS,
    VARIANTS,
    VEHICLE,
    PaperPlan,
    case_of,
    contact_model_cases,
    rig_case,
    traction_case,
)
from rollerrig.study.paper_results import Results, results_of
from rollerrig.study.quantities import Numbers
from rollerrig.study.report import VIEW, Block, Mark, Picture, Section, Text


@dataclass(frozen=True)
class PaperStudy(Study[Results]):
    """Both studies of the paper.

    Attributes:
        chosen: what is computed.
    """

    chosen: PaperPlan = FULL

    command = "paper"
    quantities = QUANTITIES
    writes = ("data/*.nc", "data/*.csv", VIEW)
    formats = ("svg", "png")
    round_ends = (0.2, 0.8)

    @property
    def title(self) -> str:
        return "Malvezzi, Meli and Pugi (2010): critical speed and traction of a bogie on a roller rig"

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
        beside, begun = exact_cases(plan)
        cases, started = cases | beside, started | begun
        first |= exact_jobs(plan)
        models = contact_model_cases(plan)
        cases, started = cases | models, started | dict.fromkeys(models, plan.sensitivity_kmh)
        yield jobs
        first["traction"] = job(whole_run, traction_case(plan))
        for more in speeds.disturbance_rounds(cases, started, plan.bracket_kmh, plan.hunting, done):
            yield {**first, **more}
            first = {}

    def collect(self, done: Done) -> Results | None:
        return results_of(self.chosen, done)

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

    def shown(self, results: Results) -> Mapping[str, xr.Dataset]:
        return (
            {} if results.traction is None else {"the bogie on free rollers under traction, figure 8": results.traction}
        )

    # ---------------------------------------------------------------------------------------------------- report

    def sections(self, results: Results, numbers: Numbers) -> list[Section]:
        drawn = {name: Picture(name, figure, CAPTIONS[name]) for name, figure in figures(results).items()}

        def pictures(*names: str) -> list[Block]:
            return [drawn[name] for name in names if name in drawn] or [Text("Not computed.")]

        def texts(lines: list[str]) -> list[Block]:
            return [Text(line) for line in lines]

        radii, effects = results.over_radius, results.effects
        changes = [
            speeds.radius_table(table, f"Linear critical speeds, {NAMES[m]}: bogie (car body fixed) and vehicle.")
            for m, table in radii.items()
        ]
        splits = [
            speeds.effects_table(split, f"Track less rig, {NAMES[m]}, bogie: effects of the rollers switched.")
            for m, split in effects.items()
        ]
        passed = counts_text(results.checks)
        stability: list[Block] = [
            *tables.critical(results, self.chosen),
            *texts([*text.contact_sentences(results), *text.critical_paragraphs(results)]),
            Text(text.ramp_text(self.chosen)),
            *pictures("figure_7a_ramp"),
            Text(text.CONSTANT_SPEED),
            *pictures("figure_7a_time_steel", "figure_7a_time_paper", "figure_7a_amplitude"),
            *texts(text.frequency_paragraphs(results, self.chosen)),
            *pictures("figure_7b_steel", "figure_7b_paper"),
        ]
        rig = [*texts(text.rig_paragraphs(results)), *changes, *pictures("radius_steel", "radius_paper"), *splits]
        return [
            compared(results, numbers, self.chosen),
            Section("Figure 7: stability", stability),
            Section("What the rig changes", [*rig, *pictures("roller_effects")]),
            Section("Which material fits the paper", fit_blocks(results, numbers, self.chosen)),
            Section("Figure 8: traction", [Text(text.TRACTION), *pictures("figure_8a", "figure_8b")]),
            Section("Checks", [Text(passed), check_table(results.checks)] if results.checks else [Text("No checks.")]),
            Section("Solver and contact", [tables.solver_table(results), tables.counter_table(results)], folded=True),
            Section("Parameters", tables.parameters(self.chosen), folded=True),
        ]
