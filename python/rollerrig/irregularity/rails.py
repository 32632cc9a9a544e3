"""Displacements of the two rails as periodic splines, and the four components that engineers speak of.

alignment    lateral displacement, mean of the two rails, positive to the left
vertical     vertical displacement, mean of the two rails, positive upward
cross_level  height of the right rail over the left one, as the cant
gauge        widening: left rail to the left, right rail to the right
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike

from rollerrig.common.arrays import Array
from rollerrig.common.splines import cubic, pieces


class IrregularityError(ValueError):
    """A file of measured rails that cannot be used; the message says where, what was found and what is allowed."""


Component = Literal["alignment", "vertical", "cross_level", "gauge"]
COMPONENTS: tuple[Component, ...] = get_args(Component)

RAILS = ("left_y", "left_z", "right_y", "right_z")
"""Displacements of the rails: y positive to the left, z upward [m]."""


def rails_of(components: Mapping[Component, Array]) -> dict[str, Array]:
    """Displacements of both rails of four components, of any one shape [m]."""
    y, z = components["alignment"], components["vertical"]
    half_gauge, half_level = components["gauge"] / 2, components["cross_level"] / 2
    return {"left_y": y + half_gauge, "left_z": z - half_level, "right_y": y - half_gauge, "right_z": z + half_level}


def components_of(rails: Mapping[str, Array]) -> dict[Component, Array]:
    """The four components of displacements of both rails, of any one shape [m]."""
    return {
        "alignment": (rails["left_y"] + rails["right_y"]) / 2,
        "vertical": (rails["left_z"] + rails["right_z"]) / 2,
        "cross_level": rails["right_z"] - rails["left_z"],
        "gauge": rails["left_y"] - rails["right_y"],
    }


@dataclass(frozen=True, eq=False)
class RailIrregularity:
    """Displacements of both rails over the distance, periodic cubic splines on uniform knots.

    On the piece `i`, with t = s - i step, a displacement is c_i0 + c_i1 t + c_i2 t^2 + c_i3 t^3.
    """

    step: float  # distance of the knots [m]
    coefficients: Mapping[str, Array]  # by name of RAILS, (n, 4) each [m, 1, 1/m, 1/m^2], read-only
    fade_in: float  # length from the foremost wheel's start on over which they grow to their full size [m]

    @property
    def period(self) -> float:
        """Distance after which they repeat [m]."""
        return len(self.coefficients["left_y"]) * self.step

    def scaled(self, factor: float) -> "RailIrregularity":
        """The same rails with all lengths times a factor."""
        powers = factor ** np.array([1.0, 0.0, -1.0, -2.0])
        coefficients = {rail: table * powers for rail, table in self.coefficients.items()}
        for table in coefficients.values():
            table.flags.writeable = False
        return RailIrregularity(factor * self.step, coefficients, factor * self.fade_in)

    def evaluate(self, rail: str, s: ArrayLike, derivative: int = 0) -> Array:
        """Displacement of a rail, or its slope (1), at distances s [m] of any shape, without the fading in."""
        table = self.coefficients[rail]
        place = np.mod(np.asarray(s, dtype=np.float64), self.period)
        row = np.minimum((place / self.step).astype(np.intp), len(table) - 1)
        return cubic(table[row], place - row * self.step, derivative)

    def components(self, s: ArrayLike) -> dict[Component, Array]:
        """The four components at distances s [m] of any shape, without the fading in [m]."""
        return components_of({rail: self.evaluate(rail, s) for rail in RAILS})

    def root_mean_square(self) -> dict[Component, float]:
        """Root mean square of each component over one period [m]."""
        knots = self.components(np.arange(len(self.coefficients["left_y"])) * self.step)
        return {name: float(np.sqrt(np.mean(np.square(values)))) for name, values in knots.items()}


def periodic_spline(weights: Array, step: float) -> Array:
    """Coefficients of the periodic cubic spline of some B-spline weights.

    Args:
        weights: (n,) weight of the B-spline in the middle of which each knot lies [m].
        step: distance of the knots [m].

    Returns:
        (n, 4), read-only.
    """
    table = pieces(np.roll(weights, 1), weights, np.roll(weights, -1), np.roll(weights, -2), step)
    table.flags.writeable = False
    return table
