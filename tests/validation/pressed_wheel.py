"""A wheel lowered on its roller or rail until its patches carry a force, and what can be measured on them.

    pose, force -> [height found by bisection] -> patches: approach, pressure, centre, length, width, area

One patch or several; the two readings of a patch that is about to divide count with their blending weights.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from rollerrig import _core
from validation.reference import mm

Array = NDArray[np.float64]


@dataclass(frozen=True)
class PressedWheel:
    """Lengths in mm, forces in N, pressures in N/mm2."""

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
    def length(self) -> float:
        """Of all patches, from the foremost end to the hindmost."""
        ahead = max(patch.point[0] + 0.5 * patch.length for patch in self.patches)
        return float(ahead - min(patch.point[0] - 0.5 * patch.length for patch in self.patches)) / mm

    @property
    def pressure(self) -> float:
        return max(patch.peak_pressure for patch in self.patches) / 1e6

    @property
    def point(self) -> Array:
        """The patches' common centre on the rail or roller, weighted with force."""
        return sum(patch.normal * np.array(patch.point) for patch in self.patches) / self.normal / mm

    @property
    def direction(self) -> Array:
        """Of the resultant, out of the rail or roller."""
        force = sum(patch.normal * np.array(patch.direction) for patch in self.patches)
        return force / np.linalg.norm(force)


def press(
    contact: _core.StaticWheelsetContact,
    place: tuple[float, float],
    yaw: float,
    roll: float,
    force: float,
    *,
    right: bool = False,
    normal: str = "strips",
) -> PressedWheel:
    """At a place (x, y) of the wheelset [m] and its angles [rad], by a sum of the patches' normal forces [N]."""

    def patches(z: float) -> list[_core.StaticPatch]:
        if normal == "hertz":  # the paper's bare rule
            return contact.minima(*place, z, yaw, roll, right, 0.0)
        return contact.patches(*place, z, yaw, roll, right)

    touch = contact.touch_height(*place, yaw, roll, right)
    z = brentq(lambda z: sum(patch.normal for patch in patches(z)) - force, touch - 0.6 * mm, touch, xtol=1e-13)
    found = patches(z)
    return PressedWheel(found, z / mm, sum(patch.normal for patch in found))
