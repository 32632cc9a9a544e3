"""The paper report: sections, tables, where each number comes from.

PaperResults, pictures -> [page] -> report.Page
"""

from __future__ import annotations

import json
import math

from rollerrig import __version__
from rollerrig.config import Rig
from rollerrig.report import Check, Figure, Page, Preformatted, Section, Table, Text, check_table, number
from rollerrig.report.page import Block
from rollerrig.studies.compare.critical import cause_rows, table_rows
from rollerrig.studies.paper.compute import PaperResults
from rollerrig.studies.paper.figures import CAPTIONS
from rollerrig.studies.paper.plan import MATERIALS, VARIANTS, VEHICLE, rig_case, traction_case
from rollerrig.studies.paper.text import (
    LEFT_OUT,
    NAMES,
    critical_paragraphs,
    fit_paragraphs,
    frequency_paragraphs,
    kmh,
    lead,
    ramp_text,
    rig_paragraphs,
)

TITLE = "A bogie on a roller rig: critical speed and traction"


def paper_page(results: PaperResults, pictures: dict[str, bytes], checks: list[Check]) -> Page:
    """The whole report."""
    sections = [
        Section("Figure 7: stability", stability_blocks(results, pictures)),
        Section("What the rig changes", rig_blocks(results, pictures)),
        Section("Which material fits the paper", fit_blocks(results)),
        Section("Figure 8: traction", traction_blocks(pictures)),
        Section("Checks", check_blocks(checks)),
        Section("Solver and contact", [solver_table(results), counter_table(results)]),
        Section("Parameters", parameter_blocks(results)),
        Section("What the model leaves out", [Text("• " + line) for line in LEFT_OUT]),
    ]
    footer = (
        f"rollerrig {__version__}. After M. Malvezzi, E. Meli, L. Pugi: Simulation of degraded wheel/rail adhesion "
        f"conditions on a railway roller rig for the evaluation of the effect of wheel/roller contact on control "
        f"performance, 2010."
    )
    return Page(TITLE, lead(results), sections, footer)


def _pictures(pictures: dict[str, bytes], *names: str) -> list[Block]:
    return [Figure(pictures[name], CAPTIONS[name]) for name in names if name in pictures] or [Text("Not computed.")]


def stability_blocks(results: PaperResults, pictures: dict[str, bytes]) -> list[Block]:
    """Figure 7."""
    return [
        critical_table(results),
        *(Text(text) for text in critical_paragraphs(results)),
        Text(ramp_text(results)),
        *_pictures(pictures, "figure_7a_ramp"),
        Text(
            "At constant speeds the leading wheelset is held aside and released. Runs are repeated between the "
            "highest speed at which the motion dies out and the lowest at which it goes on, until the two are "
            "close. Near the highest speeds the flanges strike and the motion becomes irregular: its amplitude is "
            "meaningful, its course is not, since the smallest change alters it."
        ),
        *_pictures(pictures, "figure_7a_time_steel", "figure_7a_time_paper", "figure_7a_amplitude"),
        *(Text(text) for text in frequency_paragraphs(results)),
        *_pictures(pictures, "figure_7b_steel", "figure_7b_paper"),
    ]


def rig_blocks(results: PaperResults, pictures: dict[str, bytes]) -> list[Block]:
    """What the rig changes: critical speeds over the rollers' radius, and the loss split into its causes."""
    blocks: list[Block] = [Text(text) for text in rig_paragraphs(results)]
    for material, table in results.tables.items():
        header, rows = table_rows(table)
        blocks.append(
            Table(header, rows, f"Linear critical speeds, {NAMES[material]}: bogie (car body held) and vehicle.")
        )
    blocks += _pictures(pictures, "radius_steel", "radius_paper")
    for material, causes in results.causes.items():
        header, rows = cause_rows(causes)
        blocks.append(
            Table(header, rows, f"Track less rig, {NAMES[material]}, bogie: effects of the rollers switched.")
        )
    return [*blocks, *_pictures(pictures, "causes")]


def critical_table(results: PaperResults) -> Table:
    """Linear critical speed of each variant, that by disturbance of the rig."""
    rows = []
    for material in MATERIALS:
        for variant in VARIANTS:
            modes = results.modes.get(material, {}).get(variant)
            if modes is None:
                continue
            frequency = float(modes.attrs["linear_critical_frequency_hz"])
            by_disturbance = ""
            found = {"bogie on the rig": results.runs, VEHICLE: results.vehicle_runs}.get(variant, {}).get(material)
            if found is not None:
                by_disturbance = f"{kmh(3.6 * found.decays, 1)} … {kmh(3.6 * found.persists, 1)}"
            rows.append(
                (
                    NAMES[material],
                    variant,
                    kmh(results.linear_kmh(material, variant), 1),
                    f"{frequency:.2f} Hz" if math.isfinite(frequency) else "–",
                    by_disturbance,
                )
            )
    header = ("material", "what runs", "linear critical speed", "its frequency", "by disturbance: decays … persists")
    size = 1e3 * results.plan.hunting.disturbance
    return Table(
        header, rows, f"Critical speeds. By disturbance: from a lateral offset of {size:g} mm of the leading wheelset."
    )


def fit_blocks(results: PaperResults) -> list[Block]:
    """Steel or G = 10 GPa?"""
    blocks: list[Block] = [Text(text) for text in fit_paragraphs(results)] or [Text("Not computed.")]
    if results.contact:
        header = (
            "material",
            "patches per wheel",
            "deepest approach [µm]",
            "Σ f₁₁ of a wheel [MN]",
            "wavelength of slow hunting [m]",
        )
        rows = [
            (NAMES[m], c.patches, f"{1e6 * c.approach:.1f}", f"{1e-6 * c.creep_stiffness:.2f}", f"{c.wavelength:.2f}")
            for m, c in results.contact.items()
        ]
        blocks.append(Table(header, rows, "Steady rolling on the rig, small motions."))
    if results.barriers:
        names = list(results.barriers)
        values = [
            (f"{barrier:g}", *(kmh(3.6 * results.barriers[m][barrier], 1) for m in names))
            for barrier in results.plan.barriers
        ]
        caption = (
            "Linear critical speed of the bogie on the rig over contact.merging_criterion, the rule for two patches that "
            "become one."
        )
        blocks.append(Table(("merge barrier", *(NAMES[m] for m in names)), values, caption))
    return blocks


def traction_blocks(pictures: dict[str, bytes]) -> list[Block]:
    """Figure 8."""
    return [
        Text(
            "No torque for one second, then a linear rise to the maximum at 5 s, then constant. The rollers turn "
            "freely, so they and the wheelsets are spun up; the motors stand on the frame, which feels the opposite "
            "torque. The sliding does not start from zero: the two patches of each wheel have different rolling "
            "radii and work against each other even without torque, and what is drawn is their mean, weighted with "
            "normal force."
        ),
        *_pictures(pictures, "figure_8a", "figure_8b"),
    ]


def check_blocks(checks: list[Check]) -> list[Block]:
    """The table of checks, with the count of those that passed."""
    if not checks:
        return [Text("Nothing was computed that could be checked.")]
    passed = sum(check.passed for check in checks)
    return [Text(f"{passed} of {len(checks)} checks passed."), check_table(checks)]


def _audited(results: PaperResults) -> list[tuple[str, dict[str, object]]]:
    """All runs whose counts are shown, with their attributes."""
    found: list[tuple[str, dict[str, object]]] = []
    for material in MATERIALS:
        if material in results.ramps:
            found.append((f"ramp, {NAMES[material]}", results.ramps[material].attrs))
        for run in results.runs[material].runs if material in results.runs else []:
            found.append((f"{3.6 * run.speed:.1f} km/h, {NAMES[material]}", run.motion.attrs))
    if results.traction is not None:
        found.append(("traction", results.traction.attrs))
    return found


def solver_table(results: PaperResults) -> Table:
    """What each run cost and how its energy balances."""
    header = ("run", "ended", "steps", "rejected", "smallest step [s]", "energy turned over [kJ]", "relative residual")
    rows = []
    for name, attributes in _audited(results):
        statistics = json.loads(str(attributes["solver_statistics"]))
        rows.append(
            (
                name,
                attributes["status"],
                int(statistics["steps"]),
                int(statistics["rejected_steps"]),
                number(float(statistics["smallest_step"]), 2),
                f"{1e-3 * float(str(attributes['energy_turned_over_j'])):.1f}",
                number(float(str(attributes["energy_relative_residual"])), 2),
            )
        )
    return Table(
        header,
        rows,
        "Integration, and the energy audit: work in − change of stored energy − heat, over the energy turned over.",
    )


COUNTERS = {
    "checked": "wheels looked at",
    "several_patches": "with several patches",
    "overlapping": "pairs of overlapping patches",
    "faded": "faded patches",
    "limited_curvature": "limited curvatures",
    "clamped_aspect": "a/b outside Kalker's table",
    "lost": "wheels without contact",
}
"""Counter of the core -> column of the table."""


def counter_table(results: PaperResults) -> Table:
    """What happened in the contacts of each run."""
    rows = []
    for name, attributes in _audited(results):
        counters = json.loads(str(attributes["contact_counters"]))
        rows.append((name, *(int(counters.get(key, 0)) for key in COUNTERS)))
    return Table(("run", *COUNTERS.values()), rows, "Contact model, summed over accepted steps and wheels.")


def parameter_blocks(results: PaperResults) -> list[Block]:
    """What was assumed; the whole configurations folded away."""
    case, traction = rig_case("steel"), traction_case(results.plan)
    rig = case.support.data
    assert isinstance(rig, Rig)
    soft = rig_case("paper").contact.material
    steel = case.contact.material
    settings = results.plan.hunting
    bodies = [(b.name, b.mass, *b.inertia) for b in case.vehicle.data.bodies_in(case.vehicle.part)]
    rows = [
        ("vehicle", case.vehicle.data.description),
        ("its source", case.vehicle.data.source),
        (
            "wheel",
            f"S1002, radius {1e3 * case.vehicle.data.wheel.radius:g} mm, back to back "
            f"{1e3 * case.vehicle.data.wheel.back_to_back:g} mm",
        ),
        ("rig", rig.description),
        ("its source", rig.source),
        (
            "roller",
            f"radius {1e3 * rig.roller_radius:g} mm, spin inertia of a pair {rig.roller_inertia[1]:g} kg m², "
            f"{rig.coupling}",
        ),
        ("steel", f"G = {1e-9 * steel.shear_modulus:.2f} GPa, ν = {steel.poisson_ratio:g}"),
        ("paper's material", f"G = {1e-9 * soft.shear_modulus:.2f} GPa, ν = {soft.poisson_ratio:g}; {soft.source}"),
        ("friction", f"{case.contact.friction:g}"),
        ("creep law, normal law", f"{case.contact.creep}, {case.contact.normal}"),
        ("merge barrier", f"{case.contact.merging_criterion:g}"),
        (
            "runs of figure 7",
            f"rodas4, tolerance {settings.relative_tolerance:g} relative, {settings.absolute_tolerance:g} m, "
            f"{settings.duration:g} s",
        ),
        (
            "run of figure 8",
            f"{traction.time.method}, tolerance {traction.time.relative_tolerance:g} relative, from "
            f"{3.6 * traction.motion.speed:g} km/h",
        ),
    ]
    return [
        Table(("parameter", "value"), rows),
        Table(
            ("body", "mass [kg]", "Ixx [kg m²]", "Iyy [kg m²]", "Izz [kg m²]"), bodies, "Bodies; the car body is held."
        ),
        Preformatted("The whole configuration of figure 7 (steel)", case.to_toml()),
        Preformatted("The whole configuration of figure 8", traction.to_toml()),
    ]
