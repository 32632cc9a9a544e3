"""Tables of the paper study: rows of its CSV files, solver, contact and parameters in the report.

results of PaperStudy -> [paper_tables] -> rows, tables
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from typing import Any

import xarray as xr
from numpy.typing import ArrayLike

from rollerrig.analysis import CriticalSpeedByDisturbance, hunting_table
from rollerrig.config import Rig
from rollerrig.study.interval import Interval
from rollerrig.study.paper_contacts import side_by_side
from rollerrig.study.paper_plan import EXACT, MATERIALS, NAMES, OWN, RIG, VEHICLE, PaperPlan, rig_case, traction_case
from rollerrig.study.paper_results import Results
from rollerrig.study.paper_text import linear as linear_text
from rollerrig.study.report import Block, Table
from rollerrig.study.run import CONTACT
from rollerrig.wording import number


def critical(results: Results, plan: PaperPlan) -> list[Block]:
    """Critical speeds with the paper's own contact and with the exact one; nothing where none was computed."""
    rows: dict[tuple[str, str, str], tuple[str, float, Interval | None]] = {}
    for material, variants in results.modes.items():
        for variant, modes in variants.items():
            known = {RIG: results.runs, VEHICLE: results.vehicle_runs}.get(variant, {})
            by = results.by_disturbance(material, variant) if material in known else None
            linear = linear_text(results.linear_kmh(material, variant), plan)
            rows[NAMES[material], variant, OWN] = linear, float(modes.attrs["linear_critical_frequency_hz"]), by
            exact = results.exact.linear.get(material, {}).get(variant)
            if exact is not None:
                known = results.exact.runs.get(variant, {})
                by = results.exact.by_disturbance(material, variant) if material in known else None
                frequency = math.nan if exact.onset is None else exact.onset.frequency
                rows[NAMES[material], variant, EXACT] = linear_text(exact.speed_kmh, plan), frequency, by
    return [side_by_side(rows, plan.hunting.disturbance)] if rows else []


def run_columns(found: CriticalSpeedByDisturbance) -> dict[str, ArrayLike]:
    """Runs at constant speed."""
    table = hunting_table(found.runs, found.disturbance)
    columns = {
        "speed_kmh": "speed",
        "amplitude_m": "amplitude",
        "frequency_hz": "oscillation_frequency",
        "decay_frequency_hz": "decay_frequency",
        "rate_at_end_per_s": "rate_at_end",
        "persists": "persists",
    }
    return {column: table[name].to_numpy() for column, name in columns.items()}


def frequency_rows(results: Results) -> list[list[object]]:
    """Frequency and damping of hunting over speed, header first."""
    rows: list[list[object]] = [["material", "variant", "speed_kmh", "hunting_frequency_hz", "hunting_damping"]]
    for material, variants in results.modes.items():
        for variant, modes in variants.items():
            for k, speed in enumerate(modes["speed"].to_numpy().tolist()):
                hunting = (float(modes[name][k]) for name in ("hunting_frequency", "hunting_damping"))
                rows.append([material, variant, speed, *hunting])
    return rows


TRACTION_UNITS = {"sliding": "mps", "longitudinal_creep_force": "n", "longitudinal_force": "n", "vertical_force": "n"}


def traction_columns(study: xr.Dataset) -> dict[str, ArrayLike]:
    """Sliding and forces of all wheels beside the closed forms over time."""
    columns = {"time_s": study["time"], "speed_mps": study["speed"], "torque_nm": study["torque"]}
    for wheel in map(str, study["wheel"].to_numpy()):
        for name, unit in TRACTION_UNITS.items():
            for kind in ("", "_theory"):
                columns[f"{wheel}.{name}{kind}_{unit}"] = study[f"{name}{kind}"].sel(wheel=wheel)
    return {name: column.to_numpy() for name, column in columns.items()}


def _audited(results: Results) -> Iterator[tuple[str, dict[str, Any]]]:
    """All runs whose counts are shown, with their attributes."""
    for material in MATERIALS:
        if material in results.ramps:
            yield f"ramp, {NAMES[material]}", results.ramps[material].attrs
        for run in results.runs[material].runs if material in results.runs else []:
            yield f"{3.6 * run.speed:z.1f} km/h, {NAMES[material]}", run.motion.attrs
    if results.traction is not None:
        yield "traction", results.traction.attrs


def solver_table(results: Results) -> Table:
    """Cost and energy balance of each run."""
    header = ("run", "ended", "steps", "rejected", "smallest step [s]", "energy turned over [kJ]", "relative residual")
    rows = []
    for name, attributes in _audited(results):
        counts = json.loads(attributes["solver_statistics"])
        steps = int(counts["steps"]), int(counts["rejected_steps"]), number(float(counts["smallest_step"]), 2)
        energy = f"{1e-3 * float(attributes['energy_turned_over_j']):z.1f}"
        residual = number(float(attributes["energy_relative_residual"]), 2)
        rows.append((name, attributes["status"], *steps, energy, residual))
    caption = (
        "Integration, and the energy audit: work in - change of stored energy - heat, over the energy turned over."
    )
    return Table(header, rows, caption)


def counter_table(results: Results) -> Table:
    """What happened in the contacts of each run."""
    names = [quantity.name for quantity in CONTACT if quantity.name != "negative_dissipation"]
    found = [(name, json.loads(attributes["contact_counters"])) for name, attributes in _audited(results)]
    rows = [(name, *(int(counters.get(key, 0)) for key in names)) for name, counters in found]
    header = ("run", *(name.replace("_", " ") for name in names))
    return Table(header, rows, "Contact model, summed over accepted steps and wheels.")


def parameters(plan: PaperPlan) -> list[Block]:
    """What was assumed."""
    case, traction, soft = rig_case("steel"), traction_case(plan), rig_case("paper").contact.material
    rig, vehicle, steel = case.support.data, case.vehicle.data, case.contact.material
    assert isinstance(rig, Rig)
    wheel = f"S1002, radius {1e3 * vehicle.wheel.radius:g} mm, back to back {1e3 * vehicle.wheel.back_to_back:g} mm"
    roller = (
        f"radius {1e3 * rig.roller_radius:g} mm, spin inertia of a pair {rig.roller_inertia[1]:g} kg m², {rig.coupling}"
    )
    runs = f"tolerance {plan.hunting.relative_tolerance:g} relative, {plan.hunting.absolute_tolerance:g} m"
    method = f"{traction.time.method}, tolerance {traction.time.relative_tolerance:g} relative"
    rows = [
        ("vehicle", vehicle.description),
        ("its source", vehicle.source),
        ("wheel", wheel),
        ("rig", rig.description),
        ("its source", rig.source),
        ("roller", roller),
        ("steel", f"G = {1e-9 * steel.shear_modulus:z.2f} GPa, ν = {steel.poisson_ratio:g}"),
        ("paper's material", f"G = {1e-9 * soft.shear_modulus:z.2f} GPa, ν = {soft.poisson_ratio:g}; {soft.source}"),
        ("friction", f"{case.contact.friction.mu_0:g}"),
        ("creep law, normal law", f"{case.contact.creep.kind}, {case.contact.normal.kind}".replace("_", " ")),
        ("merging criterion", f"{getattr(case.contact.normal, 'merging_criterion', 0.0):g}"),
        ("runs of figure 7", f"rodas4, {runs}, {plan.hunting.duration:g} s"),
        ("run of figure 8", f"{method}, from {3.6 * traction.motion.speed:g} km/h"),
    ]
    bodies = [(b.name.replace("_", " "), b.mass, *b.inertia) for b in vehicle.bodies_in(case.vehicle.part)]
    header = ("body", "mass [kg]", "Ixx [kg m²]", "Iyy [kg m²]", "Izz [kg m²]")
    return [Table(("parameter", "value"), rows), Table(header, bodies, "Bodies; the car body is fixed.")]
