"""Hertz and the paper's creep law beside CONTACT's exact results, pose by pose.

For each pose the right (or left) wheel is lowered until its patches carry the normal force of the reference, so that the
comparison is one of contact theories and not of how friction helps to carry the weight on a steep flange.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq

from rollerrig import _core
from rollerrig.contact_laws import creep_law
from validation.reference import POISSON_RATIO, SHEAR_MODULUS, benchmark_contact, mm, rows

FRICTION = 0.3
FILES = {
    "contact_rail_shift_10kN.csv": "right wheel on rail, shifted, no yaw",
    "contact_roller_shift_R500_10kN.csv": "right wheel on a roller of 500 mm radius, shifted, no yaw",
    "contact_manchester_a22.csv": "Manchester contact benchmark A-2.2: yaw 2.4 mrad per mm of shift, both wheels",
}


@dataclass(frozen=True)
class Comparison:
    """One pose; lengths in mm, forces in N; `reference` is the row of the file."""

    reference: dict
    patches: list[_core.StaticPatch]
    height: float
    normal: float

    @property
    def largest(self) -> _core.StaticPatch:
        return max(self.patches, key=lambda patch: patch.normal)

    @property
    def angle(self) -> float:
        return abs(self.largest.angle)

    @property
    def approach(self) -> float:
        return max(patch.approach for patch in self.patches) / mm

    @property
    def area(self) -> float:
        return float(sum(patch.weight * patch.area for patch in self.patches) / mm**2)

    @property
    def width(self) -> float:
        """Loaded width of all patches."""
        return float(sum(patch.weight * patch.width for patch in self.patches) / mm)

    @property
    def pressure(self) -> float:
        return max(patch.peak_pressure for patch in self.patches) / 1e6

    @property
    def abscissa(self) -> float:
        """Of the patches' common centre on the wheel, weighted with force."""
        return sum(patch.wheel_s * patch.normal for patch in self.patches) / self.normal / mm

    @property
    def centre(self) -> float:
        """The same in the track's coordinates: distance from its middle."""
        return float(sum(abs(patch.point[1]) * patch.normal for patch in self.patches) / self.normal / mm)

    @property
    def pressure_centre(self) -> float:
        """Of the reference's pressures; its contact reference point, `ycp`, is weighted with the interpenetration."""
        return abs(self.reference["ypn_tr"])

    @property
    def reference_abscissa(self) -> float:
        return self.reference["ycp_w"] * (1 if self.reference["side"] == "right" else -1)

    def ratio(self, ours: str, theirs: str) -> float:
        return float(getattr(self, ours) / self.reference[theirs] - 1)

    def creep_force(self) -> np.ndarray | None:
        """Fx and Fs of the paper's law [N] in the reference's signs at the reference's creepages; one patch only."""
        if len(self.patches) > 1:
            return None
        r, patch = self.reference, self.largest
        mirror = 1 if r["side"] == "right" else -1
        creepage = [-r["cksi"], mirror * r["ceta"], mirror * r["cphi"] / mm]
        force = _core.creep_forces(
            np.array([creepage]), patch.a, patch.b, patch.normal, FRICTION, SHEAR_MODULUS, POISSON_RATIO,
            creep_law("kalker_saturated"),
        )[0]  # fmt: skip
        return np.array([-force[0], mirror * force[1]])

    @property
    def creep_error(self) -> float:
        """Error of the tangential force over mu N; NaN with several patches."""
        force = self.creep_force()
        if force is None:
            return float("nan")
        return float(
            np.hypot(force[0] - self.reference["Fx"], force[1] - self.reference["Fs"]) / (FRICTION * self.normal)
        )


def compare(contact: _core.StaticWheelsetContact, row: dict, normal: str) -> Comparison:
    right = row["side"] == "right"
    y, yaw, roll = -row["y_ws"] * mm, -row["yaw"], row["roll"]

    def patches(z: float) -> list[_core.StaticPatch]:
        if normal == "hertz":  # the paper's bare rule
            return contact.minima(0.0, y, z, yaw, roll, right, 0.0)
        return contact.patches(0.0, y, z, yaw, roll, right)

    touch = contact.touch_height(0.0, y, yaw, roll, right)
    z = brentq(lambda z: sum(patch.normal for patch in patches(z)) - row["Fn"], touch - 0.4 * mm, touch, xtol=1e-13)
    found = patches(z)
    return Comparison(row, found, -z / mm, sum(patch.normal for patch in found))


def comparisons(file: str, normal: str = "hertz") -> list[Comparison]:
    """All poses of a reference file."""
    contact = benchmark_contact(0.5 if "roller" in file else None, normal)
    return [compare(contact, row, normal) for row in rows(file)]
