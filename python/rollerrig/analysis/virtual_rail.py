"""The rail that a rig reproduces: its creep curve and the peak of it, from the core's laws.

Case, ellipse of a wheel, adhesion of the rail -> [creep_curve] -> friction and force over slip -> [creep_peak, rail_peak]
    -> [slipperiest_peak, available_adhesion] of the rail of a test
"""

import math
from dataclasses import dataclass

import numpy as np

from rollerrig import _core
from rollerrig.assembly.laws import adhesion_map, core_law
from rollerrig.assembly.model import AssembledModel
from rollerrig.common.arrays import Array
from rollerrig.config import Case, Condition
from rollerrig.config.schema.contact import ConstantFriction
from rollerrig.simulation.virtual_train import rail_patch

SLIDES = (1.2, 0.005)
"""A wheel slides on the virtual rail beyond so many times the slip at which the adhesion is used up, plus so much [-]."""

FULL_SLIDING = 0.98  # share of the friction limit from which a contact counts as sliding [-]

_SLIPS = np.geomspace(1e-4, 0.5, 160)


@dataclass(frozen=True)
class Patch:
    """One ellipse that stands for all patches of a wheel on the rail: semi-axes [m] and load [N]."""

    a: float
    b: float
    load: float


def patch_of(model: AssembledModel) -> Patch:
    """The patch of the virtual train's wheels; StartError: the vehicle has no equilibrium on track."""
    found = rail_patch(model)
    return Patch(found.a, found.b, found.load)


def rail_shape(case: Case) -> Condition:
    """The condition of the virtual rail; clean without [adhesion]."""
    clean = Condition(friction=ConstantFriction(kind="constant", mu_0=1.0))
    return clean if case.adhesion is None else case.adhesion.rail


def creep_curve(case: Case, patch: Patch, adhesion: float, slip: Array) -> tuple[Array, Array]:
    """Friction (A1) and longitudinal force over load of a wheel on the virtual rail, both [-], as the core computes them.

    Of rail, creep law and speed of the case, adhesion at no slip [-], and slips over the train's speed [-].
    """
    rail, contact, slip = rail_shape(case), case.contact, np.asarray(slip, dtype=np.float64)
    friction = _core.friction_at(
        core_law(rail.friction.model_copy(update={"mu_0": adhesion})), slip * case.motion.speed
    )
    law, reduction = core_law(contact.creep), (rail.k_A, rail.k_S)
    shear, poisson = contact.material.shear_modulus, contact.material.poisson_ratio
    ellipse = (patch.a, patch.b, patch.load)
    rows = [
        _core.creep_forces(np.array([[-s, 0.0, 0.0]]), *ellipse, max(m, 1e-6), shear, poisson, law, reduction=reduction)
        for s, m in zip(slip, friction, strict=True)
    ]
    return friction, np.array([float(row[0, 0]) for row in rows]) / patch.load


def creep_peak(case: Case, patch: Patch, adhesion: float) -> tuple[float, float]:
    """Slip at which FULL_SLIDING of the adhesion is used, and the largest force over load of the virtual rail [-]."""
    forces = creep_curve(case, patch, adhesion, _SLIPS)[1]
    largest = float(forces.max())
    return float(_SLIPS[np.flatnonzero(forces >= FULL_SLIDING * largest)[0]]), largest


def rail_peak(case: Case, patch: Patch, rail: Condition, speed: float) -> tuple[float, float]:
    """Peak of the creep curve of a rail, by its condition, at a speed of the train [m/s]: slip and force over load there [-]."""
    assert case.adhesion is not None
    motion = case.motion.model_copy(update={"speed": speed})
    own = case.model_copy(update={"motion": motion, "adhesion": case.adhesion.model_copy(update={"rail": rail})})
    at, peak = _SLIPS, (math.nan, math.nan)
    for _ in range(2):
        forces = creep_curve(own, patch, rail.friction.mu_0, at)[1]
        k = int(np.argmax(forces))
        peak = float(at[k]), float(forces[k])
        at = np.linspace(at[max(k - 1, 0)], at[min(k + 1, at.size - 1)], 41)
    return peak


def slipperiest_peak(case: Case, patch: Patch, speed: float) -> tuple[float, float]:
    """The same of the most slippery rail of a test, whose [adhesion] may have several along the way."""
    if case.adhesion is None:
        return math.inf, math.nan
    rails = {str(r): r for r in (case.adhesion.rail, *(piece.rail for piece in case.adhesion.piece))}
    return min((rail_peak(case, patch, rail, speed) for rail in rails.values()), key=lambda peak: peak[1])


def available_adhesion(case: Case, patch: Patch, places: Array, speeds: Array) -> Array:
    """Largest force over load that the rail gives an axle at any slip, at instants [-].

    Friction at no slip is that of each place, where conditions blend, too; the height of the peak over it is that of the
    condition whose piece the place is in, at six speeds and linear between.

    At places of the axle [m], or times [s] where the pieces of the rail begin at times, and speeds of the train there [m/s].
    """
    adhesion = case.adhesion
    assert adhesion is not None
    friction = _core.rail_friction(adhesion_map(adhesion), np.ascontiguousarray(places))
    begins = [piece.time if adhesion.over_time else piece.distance for piece in adhesion.piece]
    rails = (adhesion.rail, *(piece.rail for piece in adhesion.piece))
    inside = np.searchsorted(np.array(begins, dtype=float), places, side="right")
    grid = np.linspace(float(speeds.min()), float(speeds.max()), 6)
    found, known = np.array(friction, dtype=float), dict[str, Array]()
    for k in np.unique(inside):
        rail = rails[k]
        if str(rail) not in known:
            peaks = [rail_peak(case, patch, rail, float(speed))[1] for speed in grid]
            known[str(rail)] = np.array(peaks) / rail.friction.mu_0
        found[inside == k] *= np.interp(speeds[inside == k], grid, known[str(rail)])
    return found


def grip_slip(case: Case, patch: Patch, adhesion: float) -> float:
    """Slip of a virtual wheel up to which it grips [-]: somewhat beyond that at which the adhesion is used up."""
    return SLIDES[0] * creep_peak(case, patch, adhesion)[0] + SLIDES[1]
