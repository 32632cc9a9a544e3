"""The paper's bogie with the paper's own contact and with the exact one, side by side.

plan -> [exact_jobs, exact_cases] -> jobs -> [exact_results] -> beside those of the paper's contact: table, sentences

The paper's own contact is Hertz' ellipse at each minimum of the gap, with Kalker's linear theory saturated by friction. The exact
one is a non-elliptical patch with Kalker's theory of rolling contact: `strips` and `table`, what every other study uses.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import xarray as xr

from rollerrig.analysis import CriticalSpeedByDisturbance, LinearCriticalSpeed
from rollerrig.analysis.critical_speed import scan_linear
from rollerrig.analysis.traction import with_theory
from rollerrig.config import Case
from rollerrig.study import critical_speeds as speeds
from rollerrig.study.interval import Interval
from rollerrig.study.jobs import Done, Job, job, whole_run
from rollerrig.study.paper_plan import (
    EXACT,
    MATERIALS,
    OWN,
    PAPER_CRITICAL_KMH,
    RIG,
    VARIANTS,
    VEHICLE,
    PaperPlan,
    case_of,
    traction_case,
)
from rollerrig.study.quantities import Quantity
from rollerrig.study.report import Table
from rollerrig.wording import number

KEY = "exact_contact"
CONTACTS = {OWN: "the paper's: hertz, kalker saturated", EXACT: "exact: strips, table"}
"""Contact -> what it is called in tables."""

ALL, BY = f"{KEY}.materials.*", speeds.by_disturbance_quantities
EXACT_QUANTITIES = [
    Quantity(f"{ALL}.linear.*.critical_speed_kmh", "linear, with the exact contact, of bogie and vehicle; null: none", "km/h"),
    Quantity(f"{ALL}.linear.*.frequency_hz", "its frequency", "Hz"),
    *BY(f"{ALL}.by_disturbance"),
    *BY(f"{ALL}.vehicle_on_track"),
    Quantity(f"{KEY}.traction", "null: not computed"),
    Quantity(f"{KEY}.traction.speed_kmh", "figure 8 with the exact contact at the last output time", "km/h"),
    Quantity(f"{KEY}.traction.*.sliding_mmps", "of a right wheel there", "mm/s"),
    Quantity(f"{KEY}.traction.*.longitudinal_creep_force_n", "on a right wheel there", "N"),
    Quantity(f"{KEY}.traction.*.longitudinal_force_n", "with the part of the normal force along the track", "N"),
    Quantity(f"{KEY}.traction.*.vertical_force_n", "on a right wheel there", "N"),
]  # fmt: skip


@dataclass
class ExactContact:
    """What was computed with the exact contact; parts that Ctrl-C cut off are missing.

    Attributes:
        linear: material -> variant -> linear critical speed.
        runs: variant -> material -> critical speed by disturbance.
        traction: the wheels of figure 8.
    """

    linear: dict[str, dict[str, LinearCriticalSpeed]] = field(default_factory=dict)
    runs: dict[str, dict[str, CriticalSpeedByDisturbance]] = field(default_factory=dict)
    traction: xr.Dataset | None = None

    def linear_kmh(self, material: str, variant: str) -> float:
        """Linear critical speed [km/h]; NaN: none, or not computed."""
        found = self.linear.get(material, {}).get(variant)
        return math.nan if found is None else found.speed_kmh

    def by_disturbance(self, material: str, variant: str) -> Interval:
        """Where the critical speed by disturbance lies [km/h]; without ends if it was not computed."""
        found = self.runs.get(variant, {}).get(material)
        return Interval(-math.inf, math.inf) if found is None else Interval.of_bracket(found)


def exact_jobs(plan: PaperPlan) -> dict[str, Job]:
    """Linear critical speeds and the traction run."""
    scanned = [v / 3.6 for v in plan.linear_kmh]
    jobs = {
        f"{EXACT} linear {material}, {variant}": job(scan_linear, (case_of(variant, material, EXACT), scanned))
        for material in MATERIALS
        for variant in VARIANTS
    }
    return {**jobs, f"{EXACT} traction": job(whole_run, traction_case(plan, EXACT))}


def exact_cases(plan: PaperPlan) -> tuple[dict[str, Case], dict[str, tuple[float, ...]]]:
    """Cases of the runs from a disturbance and their first speeds [km/h], by label."""
    places = {_label(variant, m): (variant, m) for m in MATERIALS for variant in (VEHICLE, RIG)}
    cases = {label: case_of(variant, m, EXACT) for label, (variant, m) in places.items()}
    return cases, {label: plan.runs_kmh[m] for label, (_, m) in places.items()}


def _label(variant: str, material: str) -> str:
    return f"{EXACT} {variant} {material}"


def exact_results(plan: PaperPlan, done: Done) -> ExactContact:
    """From the results of the jobs."""
    found = ExactContact()
    for material in MATERIALS:
        for variant in VARIANTS:
            if (name := f"{EXACT} linear {material}, {variant}") in done:
                found.linear.setdefault(material, {})[variant] = done[name]
        for variant in (RIG, VEHICLE):
            label = _label(variant, material)
            for one in speeds.brackets([label], plan.hunting, done).values():
                found.runs.setdefault(variant, {})[material] = one
    if (run := done.get(f"{EXACT} traction")) is not None:
        found.traction = with_theory(run, traction_case(plan, EXACT))
    return found


def exact_numbers(found: ExactContact, traction: Mapping[str, Any] | None) -> dict[str, Any]:
    """Values by key of EXACT_QUANTITIES."""
    materials: dict[str, Any] = {}
    for material, variants in found.linear.items():
        materials[material] = {
            "linear": {
                variant: {
                    "critical_speed_kmh": one.speed_kmh,
                    "frequency_hz": math.nan if one.onset is None else one.onset.frequency,
                }
                for variant, one in variants.items()
            }
        }
    for key, variant in (("by_disturbance", RIG), ("vehicle_on_track", VEHICLE)):
        for material, one in found.runs.get(variant, {}).items():
            materials.setdefault(material, {})[key] = speeds.disturbance_numbers(one)
    return {"materials": materials, "traction": traction}


def side_by_side(rows: Mapping[tuple[str, str, str], tuple[str, float, Interval | None]], offset: float) -> Table:
    """Critical speeds with either contact.

    Args:
        rows: material in words, vehicle and support, contact -> linear critical speed as text, its frequency
            [Hz], by disturbance [km/h].
        offset: of the leading wheelset [m].
    """
    cells = [
        (
            material,
            variant,
            CONTACTS[contact],
            linear,
            f"{number(frequency, 3)} Hz" if math.isfinite(frequency) else "",
            "" if by is None else by.text("km/h", 1),
        )
        for (material, variant, contact), (linear, frequency, by) in rows.items()
    ]
    header = (
        "material",
        "vehicle and support",
        "contact",
        "linear critical speed",
        "its frequency",
        "by disturbance: decays … persists",
    )
    caption = (
        "Critical speeds with the paper's own contact and with the exact one. By disturbance: from a lateral offset of "
        f"{1e3 * offset:g} mm of the leading wheelset."
    )
    return Table(header, cells, caption)


def paper_speed_sentence(material: str, linear: Mapping[str, float], by: Mapping[str, Interval]) -> str:
    """What the paper's critical speed is with either contact.

    Args:
        material: in words.
        linear: contact -> linear critical speed of the bogie on the rig [km/h].
        by: contact -> critical speed by disturbance [km/h].
    """

    def one(contact: str) -> str:
        small = f"{linear[contact]:z.1f} km/h" if math.isfinite(linear[contact]) else "none in the range"
        large = by[contact].text("km/h", 1) if by[contact].known else "not computed"
        return f"{small} for small motions and {large} from the offset"

    return (
        f"The paper's bogie hunts above {PAPER_CRITICAL_KMH:g} km/h; here with {material} the critical speed is {one(OWN)} with "
        f"the paper's own contact, {one(EXACT)} with the exact one."
    )
