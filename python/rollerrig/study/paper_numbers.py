"""The numbers of the paper study: the registry of its quantities, and their values for summary.json.

results of PaperStudy -> [numbers_of] -> values by key of QUANTITIES
"""

from __future__ import annotations

from typing import Any

import xarray as xr

from rollerrig.study import critical_speeds as speeds
from rollerrig.study.checks import counts
from rollerrig.study.contact_sensitivity import sensitivity_numbers, sensitivity_quantities
from rollerrig.study.paper_contacts import EXACT_QUANTITIES, KEY, exact_numbers
from rollerrig.study.paper_results import Results
from rollerrig.study.paper_text import onset_wavelength
from rollerrig.study.quantities import Quantities, Quantity

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
    EXACT_QUANTITIES,
    sensitivity_quantities("critical_speed_by_contact_model"),
    speeds.roller_quantities(f"{ALL}.critical_speed_over_radius_kmh", f"{ALL}.roller_effects"),
    Quantity("traction", "null: not computed"),
    Quantity("traction.speed_kmh", "figure 8 at the last output time", "km/h"),
    Quantity("traction.*.sliding_mmps", "of a right wheel there", "mm/s"),
    Quantity("traction.*.longitudinal_creep_force_n", "on a right wheel there", "N"),
    Quantity("traction.*.longitudinal_force_n", "the same with the part of the normal force that points along the track", "N"),
    Quantity("traction.*.vertical_force_n", "on a right wheel there", "N"),
    Quantity("checks", "empty: nothing was computed that could be checked"),
    Quantity("checks.*.*", "name, value or both ends of its interval, expected, largest deviation and tolerance (absolute or "
             "relative), kind, its reason, verdict: passed where the whole value agrees, failed where nothing of it does"),
    Quantity("checks_passed", "number of checks that passed"),
    Quantity("checks_failed", "number of checks that failed"),
    Quantity("checks_not_decided", "number of checks whose interval agrees in part only"),
)  # fmt: skip


def numbers_of(results: Results) -> dict[str, Any]:
    """What goes into summary.json."""
    traction = results.exact.traction
    return {
        "materials": {material: _material(results, material) for material in results.modes},
        KEY: exact_numbers(results.exact, None if traction is None else traction_numbers(traction)),
        "critical_speed_by_contact_model": sensitivity_numbers(results.sensitivity),
        "traction": None if results.theory is None else traction_numbers(results.theory),
        "checks": [check.as_dict() for check in results.checks],
        **counts(results.checks),
    }


def _material(results: Results, material: str) -> dict[str, Any]:
    found: dict[str, Any] = {
        "linear": {
            variant: {
                "critical_speed_kmh": results.linear_kmh(material, variant),
                "frequency_hz": float(modes.attrs["linear_critical_frequency_hz"]),
            }
            for variant, modes in results.modes[material].items()
        },
        "merging_criterion": {f"{b:g}": scan.speed_kmh for b, scan in results.merging.get(material, {}).items()},
        "onset_wavelength_m": onset_wavelength(results, material),
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


def traction_numbers(study: xr.Dataset) -> dict[str, Any]:
    """Figure 8 at its end."""
    end = study.isel(time=-1)
    numbers: dict[str, Any] = {"speed_kmh": 3.6 * float(end["speed"])}
    for wheel in (wheel for wheel in map(str, end["wheel"].to_numpy()) if wheel.endswith("right")):
        own = end.sel(wheel=wheel)
        numbers[wheel] = {
            "sliding_mmps": 1e3 * float(own["sliding"]),
            "longitudinal_creep_force_n": float(own["longitudinal_creep_force"]),
            "longitudinal_force_n": float(own["longitudinal_force"]),
            "vertical_force_n": float(own["vertical_force"]),
        }
    return numbers
