"""What the paper study has found, from the results of its jobs.

plan, results of the jobs -> [results_of] -> Results with the checks against theory
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import xarray as xr

from rollerrig.analysis import CriticalSpeedByDisturbance, LinearCriticalSpeed
from rollerrig.analysis.contact_state import ContactState
from rollerrig.analysis.roller_effects import CriticalSpeedOverRadius, EffectSplit
from rollerrig.analysis.traction import with_theory
from rollerrig.study import critical_speeds as speeds
from rollerrig.study.checks import Check
from rollerrig.study.interval import Interval
from rollerrig.study.jobs import Done
from rollerrig.study.paper_checks import energy_checks, order_check, traction_checks
from rollerrig.study.paper_contacts import ExactContact, exact_results
from rollerrig.study.paper_plan import (
    MATERIALS,
    NAMES,
    RIG,
    TABLE_PARTS,
    VARIANTS,
    VEHICLE,
    PaperPlan,
    contact_model_cases,
    traction_case,
)


@dataclass
class Results:
    """What was computed, by material; parts that Ctrl-C cut off are missing.

    Attributes:
        modes: material -> variant -> Dataset of `stability`.
        merging: material -> merging criterion -> linear critical speed on the rig.
        contact: the wheels' contact in steady rolling on the rig.
        ramps: Datasets of `ramp_run`.
        runs: critical speed by disturbance on the rig, with its runs.
        vehicle_runs: the same of the whole vehicle on track.
        exact: the critical speeds and the traction with the exact contact.
        sensitivity: the same of the bogie, steel, by label of `sensitivity_cases`.
        over_radius: critical speeds over the rollers' radius.
        effects: of the rollers on the bogie's critical speed.
        traction: the traction run, all signals.
        theory: the same wheels beside the closed forms.
    """

    modes: dict[str, dict[str, xr.Dataset]]
    merging: dict[str, dict[float, LinearCriticalSpeed]]
    contact: dict[str, ContactState]
    ramps: dict[str, xr.Dataset]
    runs: dict[str, CriticalSpeedByDisturbance]
    vehicle_runs: dict[str, CriticalSpeedByDisturbance]
    exact: ExactContact
    sensitivity: dict[str, CriticalSpeedByDisturbance]
    over_radius: dict[str, CriticalSpeedOverRadius]
    effects: dict[str, EffectSplit]
    traction: xr.Dataset | None
    theory: xr.Dataset | None
    checks: list[Check]

    def linear_kmh(self, material: str, variant: str = RIG) -> float:
        """Linear critical speed [km/h]; NaN if there is none or it was not computed."""
        modes = self.modes.get(material, {}).get(variant)
        return math.nan if modes is None else float(modes.attrs["linear_critical_speed_kmh"])

    def by_disturbance(self, material: str, variant: str = RIG) -> Interval:
        """Where the critical speed by disturbance lies [km/h]; without ends if it was not computed."""
        found = (self.runs if variant == RIG else self.vehicle_runs).get(material)
        return Interval(-math.inf, math.inf) if found is None else Interval.of_bracket(found)


def results_of(plan: PaperPlan, done: Done) -> Results:
    """Everything that can be said from what is done."""

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
        exact=exact_results(plan, done),
        sensitivity=speeds.brackets(list(contact_model_cases(plan)), plan.hunting, done),
        over_radius={material: one for material, one in radii.items() if one is not None},
        effects={material: one for material, one in splits.items() if one is not None},
        traction=run,
        theory=theory,
        checks=checks,
    )
    for m, variant in itertools.product(MATERIALS, (RIG, VEHICLE)):
        name = f"{NAMES[m]}, {variant}"
        checks += order_check(name, found.by_disturbance(m, variant), found.linear_kmh(m, variant))
    return found
