"""Hertz and the paper's creep law beside CONTACT's exact results, pose by pose.

For each pose the right (or left) wheel is lowered until its patches carry the normal force of the reference, so that the
comparison is one of contact theories and not of how friction helps to carry the weight on a steep flange.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rollerrig import _core
from rollerrig.assembly.laws import creep_law
from validation.pressed_wheel import PressedWheel, press
from validation.reference import POISSON_RATIO, SHEAR_MODULUS, benchmark_contact, mm, rows

FRICTION = 0.3
FILES = {
    "contact_rail_shift_10kN.csv": "right wheel on rail, shifted, no yaw",
    "contact_roller_shift_R500_10kN.csv": "right wheel on a roller of 500 mm radius, shifted, no yaw",
    "contact_manchester_a22.csv": "Manchester contact benchmark A-2.2: yaw 2.4 mrad per mm of shift, both wheels",
}


@dataclass(frozen=True)
class Comparison(PressedWheel):
    """One pose; `reference` is the row of the file."""

    reference: dict

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
    wheel = press(
        contact,
        (0.0, -row["y_ws"] * mm),
        -row["yaw"],
        row["roll"],
        row["Fn"],
        right=row["side"] == "right",
        normal=normal,
    )
    return Comparison(wheel.patches, -wheel.height, wheel.normal, row)


def comparisons(file: str, normal: str = "hertz") -> list[Comparison]:
    """All poses of a reference file."""
    contact = benchmark_contact(0.5 if "roller" in file else None, normal)
    return [compare(contact, row, normal) for row in rows(file)]
