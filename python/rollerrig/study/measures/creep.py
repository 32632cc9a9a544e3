"""Of the creep law of a case, on the contact patch of its leading wheelset."""

from __future__ import annotations

import numpy as np

from rollerrig import _core
from rollerrig.config import Case
from rollerrig.config.schema.plan import CreepMeasure
from rollerrig.contact_analysis.static_contact import contact_table
from rollerrig.contact_laws import core_law

QUANTITIES = {
    "longitudinal_force": ("1", "creep force on the wheel along the track over the normal force"),
    "lateral_force": ("1", "creep force on the wheel across the track over the normal force"),
    "semi_axis_along": ("m", "semi-axis of the patch along the rolling direction"),
    "semi_axis_across": ("m", "semi-axis across it"),
    "normal_force": ("N", "of the patch"),
}


def measure(case: Case, options: CreepMeasure) -> dict[str, float]:
    """Forces of the case's creep law at given creepages on the patch with the largest normal force, wheelset centred."""
    table = contact_table(case, [(0.0, 0.0)])
    patch = table.isel(row=int(np.argmax(table["normal"].to_numpy())))
    a, b, normal = (float(patch[name]) for name in ("a", "b", "normal"))
    creepage = np.array([[options.longitudinal, options.lateral, options.spin]])
    material = case.contact.material
    elastic = material.shear_modulus, material.poisson_ratio
    force = _core.creep_forces(
        creepage, a, b, normal, case.contact.friction.mu_0, *elastic, core_law(case.contact.creep)
    )[0]
    return {
        "longitudinal_force": float(force[0]) / normal,
        "lateral_force": float(force[1]) / normal,
        "semi_axis_along": a,
        "semi_axis_across": b,
        "normal_force": normal,
    }
