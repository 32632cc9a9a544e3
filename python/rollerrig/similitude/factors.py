"""Factors between a full-scale rig and its scaled model; exact algebra, docs/theory/similitude.md.

"N m s/rad" -> [exponents] -> (kg 1, m 2, s -1)
strategy, length -> [factors] -> Similitude, which gives the factor full/model of any unit
Dataset of a scaled case -> [map_back] -> Dataset at full scale
"""

import json
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import xarray as xr

from rollerrig.config import ConfigError, ConfigProblem, ScaledFrom
from rollerrig.config.errors import nearest, one_of, show_value
from rollerrig.config.schema.units import base_powers
from rollerrig.results.run_info import ATTRIBUTE, RunInfo

Exponents = tuple[int, int, int]
"""Powers of kg, m and s."""


class UnknownUnitError(ValueError):
    """A unit that is not made of kg, m and s."""


@lru_cache(maxsize=256)
def exponents(unit: str) -> Exponents:
    """Powers of kg, m and s in a unit like "N s^2/m^2"; angles and temperatures are the same in the model.

    Raises:
        UnknownUnitError: it is not known, or made of others.
    """
    try:
        _, powers = base_powers(unit)
    except ValueError as error:
        raise UnknownUnitError(str(error)) from None
    if others := powers.keys() - {"kg", "m", "s", "rad", "K"}:
        raise UnknownUnitError(f"unit {unit!r}: nobody can say how {', '.join(sorted(others))} scales")
    return powers.get("kg", 0), powers.get("m", 0), powers.get("s", 0)


@dataclass(frozen=True)
class Similitude:
    """Three factors full/model from which all others follow."""

    # length, time, density: of a quantity at full scale over that of the model [-]
    length: float
    time: float
    density: float

    def factor(self, unit: str) -> float:
        """Factor full/model of a quantity with this unit, e.g. "N s/m".

        Raises:
            UnknownUnitError: the unit is not made of kg, m and s.
        """
        of_mass, of_length, of_time = exponents(unit)
        mass = self.density * self.length**3  # (M1)
        return float(mass**of_mass * self.length**of_length * self.time**of_time)


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
    """How the factors of time and density follow from that of length."""

    name: str  # as users write it
    title: str  # in words
    length: float  # the usual factor of length
    time: Callable[[float], float]  # factor of time for a factor of length
    density: float  # factor of density
    keeps: str  # what it is chosen for


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


_SUFFIXES = {"_s": "s", "_m": "m", "_j": "J", "_kmh": "m/s", "_mps": "m/s", "_hz": "Hz", "_n": "N", "_per_s": "1/s"}
"""Endings of attributes and JSON keys that carry their unit in the name; the longest that fits counts."""


def map_back(run: xr.Dataset) -> xr.Dataset:
    """A run, or modes over speed, of a scaled case at full scale.

    Args:
        run: results of a scaled case; variables with `units`.

    Returns:
        The same names and units, also in the metadata (`RunInfo`): those of what the model stands for, where gravity that was
        kept is another one at full scale. The attribute `config_toml` still holds the model's own case.

    Raises:
        ConfigError: the case is no model of another one.
        ValueError: no metadata.
        UnknownUnitError: a variable has a unit that is not made of kg, m and s.
    """
    info = RunInfo.of(run)
    record, factors = info.scaled_from, factors_in(info.scaled_from, info.case)
    assert record is not None
    scaled = {name: _mapped(variable, factors) for name, variable in run.variables.items()}
    coordinates = {name: scaled.pop(name) for name in run.coords}
    mapped = xr.Dataset(scaled, coordinates)
    attributes = {str(key): _attribute(str(key), value, factors) for key, value in run.attrs.items()}
    of = f"{record.case} by a 1:{record.length:g} model, {record.strategy}"
    return mapped.assign_attrs({**attributes, ATTRIBUTE: info.mapped(factors.factor).to_json(), "mapped_back": of})


def factors_in(record: ScaledFrom | None, case: str) -> Similitude:
    """The factors that a case of this name keeps of its scaling.

    Raises:
        ConfigError: it has not been scaled.
    """
    if record is None:
        needed = "needed: a case made by `rollerrig scale`"
        raise ConfigError.of(case, "similitude", "missing", needed)
    return Similitude(record.length, record.time, record.density)


def _mapped(variable: xr.Variable, factors: Similitude) -> xr.Variable:
    unit = variable.attrs.get("units")
    if unit is None:
        return variable
    return xr.Variable(variable.dims, factors.factor(str(unit)) * variable.to_numpy(), variable.attrs)


def _attribute(key: str, value: Any, factors: Similitude) -> Any:
    """An attribute, JSON included, mapped by the unit in its name."""
    if key in ("crossings", "diverging", "contact_losses"):

        def mapped(table: dict[str, Any]) -> dict[str, Any]:
            return {name: _attribute(name, one, factors) for name, one in table.items()}

        return json.dumps(json.loads(value, object_hook=mapped))
    if isinstance(value, bool) or not isinstance(value, int | float):
        return value
    suffix = max((end for end in _SUFFIXES if key.endswith(end)), key=len, default=None)
    return value if suffix is None else value * factors.factor(_SUFFIXES[suffix])
