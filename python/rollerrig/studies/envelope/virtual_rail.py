"""What the reproduced rail gives at most, and from which slip on a wheel slides on it.

case of a point, patch of a wheel -> [virtual rail] -> peak of the creep curve

Adhesion falls with slip, (A1), while creep needs slip to build up, (A4): the peak lies below the adhesion at no slip.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rollerrig import _core
from rollerrig.assembly import AssembledModel
from rollerrig.bench.virtual_train import rail_contact
from rollerrig.config import Case, Condition
from rollerrig.config.schema.contact_law import PolachReduction
from rollerrig.creep import creep_law, creep_law_of

Array = NDArray[np.float64]

SLIDES = (1.2, 0.005)
"""A wheel slides on the reproduced rail beyond so many times the slip of the creep curve's peak, and so much more [-]."""

_SLIPS = np.geomspace(1e-4, 0.5, 160)


@dataclass(frozen=True)
class Patch:
    """One ellipse that stands for all patches of a wheel on the rail: semi-axes [m] and load [N]."""

    a: float
    b: float
    load: float


def patch_of(model: AssembledModel) -> Patch:
    """The patch of the virtual train's wheels.

    Raises:
        StartError: the vehicle has no equilibrium on track.
    """
    found = rail_contact(model)
    return Patch(found["a"], found["b"], found["wheel_load"])


def rail_shape(case: Case) -> Condition:
    """How the virtual rail's adhesion falls with slip, (A1); without [adhesion] it does not."""
    return Condition(mu_0=1.0) if case.adhesion is None else case.adhesion.rail


def adhesion_at(case: Case, adhesion: Array | float, slip: Array | float) -> Array:
    """Adhesion at a slip, (A1).

    Args:
        case: whose rail and speed it is.
        adhesion: at no slip [-].
        slip: over the train's speed [-].
    """
    rail = rail_shape(case)
    falls = (1.0 - rail.A) * np.exp(-rail.B * np.asarray(slip) * case.motion.speed) + rail.A
    return np.asarray(adhesion * falls)


def creep_peak(case: Case, patch: Patch, adhesion: float) -> tuple[float, float]:
    """Slip and force over load at the peak of the creep curve of the reproduced rail.

    Args:
        case: whose rail, creep law and speed it is.
        patch: of a wheel.
        adhesion: at no slip [-].

    Returns:
        The slip from which on adhesion is all used, and the largest force over the load [-].
    """
    rail, contact = rail_shape(case), case.contact
    if contact.creep == "polach":
        reduction = PolachReduction(k_A=rail.k_A, k_S=rail.k_S)
        law, left = creep_law("polach", polach=reduction), 1.0
    else:  # as stiff as a creepage smaller by (A4)
        law, left = creep_law_of(contact), 0.5 * (rail.k_A + rail.k_S)
    shear, poisson = contact.material.shear_modulus, contact.material.poisson_ratio

    def force(slip: float, friction: float) -> float:
        creepage = np.array([[-left * slip, 0.0, 0.0]])
        row = _core.creep_forces(creepage, patch.a, patch.b, patch.load, max(friction, 1e-6), shear, poisson, law)
        return float(row[0, 0]) / patch.load

    forces = np.array([force(s, m) for s, m in zip(_SLIPS, adhesion_at(case, adhesion, _SLIPS), strict=True)])
    largest = float(forces.max())
    return float(_SLIPS[np.flatnonzero(forces >= (1.0 - 1e-6) * largest)[0]]), largest


def grip_slip(case: Case, patch: Patch, adhesion: float) -> float:
    """Slip of a virtual wheel up to which it grips [-]: somewhat beyond that of the peak, where a wheel cannot stay."""
    return SLIDES[0] * creep_peak(case, patch, adhesion)[0] + SLIDES[1]
