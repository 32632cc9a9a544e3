"""Traction of one wheel over its creepage, as it is measured on locomotives: longitudinal creep alone, at one speed and load.

    wheel on its rail, friction, creep law -> [traction_coefficient] -> force over load, per creepage

Friction and force are the core's: friction at the slip velocity (A1), the creep law on Hertz' ellipse, on a rail with a condition
also its k_A and k_S (docs/theory/adhesion.md).
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.optimize import brentq

from rollerrig import _core
from rollerrig.assembly.laws import CoreLaw


@dataclass(frozen=True)
class LoadedWheel:
    """A wheel that rolls on a straight rail, its patch an ellipse of a given shape."""

    radius: float  # rolling radius [m]
    load: float  # vertical force [N]
    speed: float  # of the vehicle [m/s]
    a_over_b: float  # semi-axis of the patch along the rail over that across it [-]
    shear_modulus: float  # of wheel and rail [Pa]
    poisson_ratio: float  # of both [-]

    @cached_property
    def semi_axes(self) -> tuple[float, float]:
        """Semi-axes a, b of Hertz' ellipse [m]: the wheel's radius along, across it the curvature that gives a/b."""

        def axes(ratio: float) -> tuple[float, float]:
            along = 0.5 / self.radius  # d1 of (14): the rail is straight
            found = _core.hertz_ellipse(self.load, along, along * ratio, self.shear_modulus, self.poisson_ratio)
            return found[0], found[1]

        def excess(log_ratio: float) -> float:
            a, b = axes(float(np.exp(log_ratio)))
            return a / b - self.a_over_b

        return axes(float(np.exp(brentq(excess, -6.0, 6.0, xtol=1e-12))))


def traction_coefficient(
    wheel: LoadedWheel,
    creepage: ArrayLike,
    friction: CoreLaw,
    law: CoreLaw,
    reduction: tuple[float, float] | None = None,
) -> NDArray[np.float64]:
    """Force along the rail over the load.

    Args:
        wheel: the wheel and its patch.
        creepage: slip velocity over the vehicle's speed, positive in traction [-].
        friction: a friction law of the core.
        law: a creep law of the core.
        reduction: k_A and k_S of the rail's condition; None: a rail without one.
    """
    slip = np.atleast_1d(np.asarray(creepage, dtype=float))
    a, b = wheel.semi_axes
    of_rail = None if reduction is None else list(reduction)
    limit = _core.friction_at(friction, np.ascontiguousarray(np.abs(slip) * wheel.speed))
    found = [
        _core.creep_forces(
            np.array([[-one, 0.0, 0.0]]), a, b, wheel.load, mu, wheel.shear_modulus, wheel.poisson_ratio, law, 1.0, of_rail
        )[0, 0]
        for one, mu in zip(slip, limit, strict=True)
    ]  # fmt: skip
    return np.array(found) / wheel.load
