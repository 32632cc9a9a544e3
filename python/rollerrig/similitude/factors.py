"""Factors between a full-scale rig and its scaled model; exact algebra, docs/theory/similitude.md.

strategy, length -> [factors] -> Similitude, which gives the factor full/model of any unit
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from rollerrig.config import ConfigError, ConfigProblem
from rollerrig.config.errors import nearest, one_of, show_value
from rollerrig.similitude.units import exponents


@dataclass(frozen=True)
class Similitude:
    """Three factors full/model from which all others follow.

    Attributes:
        length, time, density: of a quantity at full scale over that of the model [-].
    """

    length: float
    time: float
    density: float

    def factor(self, unit: str) -> float:
        """Factor full/model of a quantity with this unit, e.g. "N s/m".

        Raises:
            UnknownUnitError: the unit is not made of kg, m and s.
        """
        of_mass, of_length, of_time = exponents(unit)
        return float(self.mass**of_mass * self.length**of_length * self.time**of_time)

    @property
    def mass(self) -> float:
        """(M1): density length^3."""
        return self.density * self.length**3

    @property
    def speed(self) -> float:
        """Factor of a speed."""
        return self.length / self.time

    @property
    def acceleration(self) -> float:
        """Factor of an acceleration; 1 if gravity is to act alike."""
        return self.length / self.time**2

    @property
    def force(self) -> float:
        """Factor of a force; length^2 if the same material is to deform alike."""
        return self.mass * self.acceleration

    @property
    def pressure(self) -> float:
        """Factor of a stress or modulus; 1 if the material is the same."""
        return self.force / self.length**2


FACTORS: tuple[tuple[str, str], ...] = (
    ("length", "m"),
    ("time", "s"),
    ("density", "kg/m^3"),
    ("mass", "kg"),
    ("moment of inertia", "kg m^2"),
    ("speed", "m/s"),
    ("acceleration", "m/s^2"),
    ("force", "N"),
    ("torque", "N m"),
    ("stiffness", "N/m"),
    ("damping", "N s/m"),
    ("rotational stiffness", "N m/rad"),
    ("pressure", "Pa"),
    ("power", "W"),
    ("frequency", "Hz"),
)
"""Quantities that reports list, each with its unit."""


@dataclass(frozen=True)
class Strategy:
    """How the factors of time and density follow from that of length.

    Attributes:
        name: as users write it.
        title: in words.
        length: the usual factor of length.
        time: factor of time for a factor of length.
        density: factor of density.
        keeps: what it is chosen for.
    """

    name: str
    title: str
    length: float
    time: Callable[[float], float]
    density: float
    keeps: str


STRATEGIES: Mapping[str, Strategy] = {
    one.name: one
    for one in (
        Strategy("mmu", "MMU type", 5.0, lambda _length: 1.0, 1.0, "time and frequency"),
        Strategy("dlr", "DLR type", 5.0, math.sqrt, 0.5, "gravity"),
        Strategy("inrets", "INRETS type", 4.0, lambda length: length, 1.0, "speed and elastic contact"),
    )
}
"""After Jaschinski et al. (1999), The application of roller rigs to railway vehicle dynamics, Veh. Syst. Dyn. 31, and Allen
(2006), Scale testing, in: Handbook of Railway Vehicle Dynamics."""

LARGEST = 100.0
"""A model smaller than this is none of a wheel on a roller [-]."""


def similitude(
    strategy: str, length: float | None = None, time: float | None = None, density: float | None = None
) -> Similitude:
    """The factors of a strategy.

    Args:
        strategy: a name of STRATEGIES.
        length: factor full/model of lengths; the strategy's own by default.
        time: factor in place of the strategy's [-].
        density: the same.

    Raises:
        ConfigError: no such strategy, or a factor that is not a positive number.
    """
    if strategy not in STRATEGIES:
        problem = ConfigProblem(
            "similitude", "strategy", show_value(strategy), one_of(STRATEGIES), nearest(strategy, tuple(STRATEGIES))
        )
        raise ConfigError([problem])
    chosen = STRATEGIES[strategy]
    given = {"length": length, "time": time, "density": density}
    problems = []
    for key, value in given.items():
        if value is not None and not (math.isfinite(value) and 1.0 / LARGEST <= value <= LARGEST):
            allowed = f"allowed: a factor full scale over model, {1.0 / LARGEST:g} to {LARGEST:g}; 5 is a 1:5 model"
            problems.append(ConfigProblem("similitude", key, show_value(value), allowed))
    if problems:
        raise ConfigError(problems)
    own = chosen.length if length is None else length
    return Similitude(own, chosen.time(own) if time is None else time, chosen.density if density is None else density)
