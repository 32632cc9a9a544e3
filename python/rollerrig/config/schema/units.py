"""Quantities at the border: a number in SI or a text with a unit goes in, a float in SI comes out.

    0.46 | "0.46 m" | "460 mm"  ->  [Quantity]  ->  0.46

pint knows the units; it is imported only when the first text with a unit is met (0.3 s). Rounding: the decimal
number is converted exactly and rounded once, so that "460 mm" and 0.46 are the same float.
"""

import math
import re
from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from typing import TYPE_CHECKING, Annotated, Any

from pydantic import GetJsonSchemaHandler
from pydantic_core import CoreSchema, PydanticCustomError, core_schema

if TYPE_CHECKING:
    import pint

# keys ending in one of these carry their unit in the name: speed_kmh = 100
KEY_SUFFIXES = {
    "kmh": "km/h",
    "mps": "m/s",
    "mm": "mm",
    "m": "m",
    "deg": "deg",
    "mrad": "mrad",
    "kn": "kN",
    "knm": "kN m",
    "nm": "N m",
    "t": "t",
    "kg": "kg",
    "s": "s",
    "ms": "ms",
    "gpa": "GPa",
}

_EXAMPLES = {
    "m": "460 mm",
    "m/s": "100 km/h",
    "kg": "1813 kg",
    "kg m^2": "1120 kg m^2",
    "N": "54 kN",
    "N m": "4 kN m",
    "N/m": "3.9 MN/m",
    "N s/m": "15 kN s/m",
    "N m/rad": "940 kN m/rad",
    "N m s/rad": "2 kN m s/rad",
    "rad": "2.4 mrad",
    "rad/s": "10 deg/s",
    "s": "10 ms",
    "Pa": "82 GPa",
}

_NUMBER_AND_UNIT = re.compile(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*(\S.*?)\s*")
_UNIT_TEXT = re.compile(r"[A-Za-zµμ°%·⋅*/^()²³ \d-]{1,40}")
_POWER_TOWER = re.compile(r"\d\s*(\^|\*\*|\d)")  # "m^9^9^9" would keep the machine busy for years
_RATIO = re.compile(r"\s*(\d{1,6}(?:\.\d{1,6})?)\s*:\s*(\d{1,9}(?:\.\d{1,6})?)\s*")


@lru_cache(maxsize=1)
def _registry() -> "pint.UnitRegistry[Any]":
    import pint

    registry: pint.UnitRegistry[Any] = pint.UnitRegistry()
    registry.define("newton_metre_joined = newton * meter = Nm")  # railway texts write kNm and kNs
    registry.define("newton_second_joined = newton * second = Ns")
    registry.define("kilometre_per_hour_joined = kilometer / hour = kmh")
    return registry


@lru_cache(maxsize=512)
def unit_factor(unit: str, si_unit: str) -> Fraction | None:
    """Number of ``si_unit`` in one ``unit``; None if ``unit`` is unknown or measures something else."""
    if not _UNIT_TEXT.fullmatch(unit) or _POWER_TOWER.search(unit):
        return None
    registry = _registry()
    try:
        factor = registry.Quantity(1.0, registry.parse_units(unit)).to(registry.parse_units(si_unit)).magnitude
    except (
        Exception
    ):  # PintError, DimensionalityError (a TypeError), tokenizer and syntax errors: all mean "no such unit"
        return None
    near = Fraction(factor).limit_denominator(10**9)
    return near if float(near) == factor else Fraction(factor)


@dataclass(frozen=True)
class Quantity:
    """Pydantic annotation of a float that has a unit and, perhaps, bounds.

    Attributes:
        unit: SI unit of the validated number; "1" for a pure number.
        gt: the value must be greater than this.
        ge: the value must be this or greater.
        le: the value must be this or less.
    """

    unit: str
    gt: float | None = None
    ge: float | None = None
    le: float | None = None

    @property
    def bounds(self) -> str:
        """The bounds in words, "" if there are none."""
        unit = "" if self.unit == "1" else f" {self.unit}"
        limits = ((self.gt, "greater than"), (self.ge, "at least"), (self.le, "at most"))
        return " and ".join(f"{word} {limit:g}{unit}" for limit, word in limits if limit is not None)

    @property
    def allowed(self) -> str:
        """What may be written, in words."""
        if self.unit == "1":
            kind = "a number"
        else:
            kind = f"a number in {self.unit} or a text with a unit"
            kind += f" like '{_EXAMPLES[self.unit]}'" if self.unit in _EXAMPLES else ""
        return f"allowed: {kind}" + (f", {self.bounds}" if self.bounds else "")

    def parse(self, value: object) -> float:
        """The value in SI.

        Raises:
            ValueError: not a finite number, not a unit of this kind, or out of bounds.
        """
        number = self._to_si(value)
        if number is None or not math.isfinite(number):
            raise ValueError(self.allowed)
        outside = (
            (self.gt is not None and number <= self.gt)
            or (self.ge is not None and number < self.ge)
            or (self.le is not None and number > self.le)
        )
        if outside:
            raise ValueError(self.allowed)
        return number

    def _to_si(self, value: object) -> float | None:
        if isinstance(value, bool):
            return None
        if isinstance(value, int | float):
            try:
                return float(value)
            except OverflowError:
                return None
        if not isinstance(value, str):
            return None
        ratio = _RATIO.fullmatch(value) if self.unit == "1" else None
        if ratio:  # an inclination is written 1:40
            over, under = Fraction(ratio[1]), Fraction(ratio[2])
            return float(over / under) if under else None
        parts = _NUMBER_AND_UNIT.fullmatch(value)
        factor = unit_factor(parts[2], "dimensionless" if self.unit == "1" else self.unit) if parts else None
        if parts is None or factor is None or not math.isfinite(float(parts[1])):
            return None
        try:
            return float(Fraction(repr(float(parts[1]))) * factor)
        except OverflowError:
            return None

    def _validate(self, value: object) -> float:
        try:
            return self.parse(value)
        except ValueError as error:
            raise PydanticCustomError("quantity", "{allowed}", {"allowed": str(error)}) from None

    def __get_pydantic_core_schema__(self, _source: object, _handler: Callable[[object], CoreSchema]) -> CoreSchema:
        """A plain function does all the work."""
        return core_schema.no_info_plain_validator_function(self._validate)

    def __get_pydantic_json_schema__(self, _schema: CoreSchema, _handler: GetJsonSchemaHandler) -> dict[str, Any]:
        """A number or a text, with the unit and the bounds beside it."""
        number: dict[str, Any] = {"type": "number"}
        for keyword, limit in (("exclusiveMinimum", self.gt), ("minimum", self.ge), ("maximum", self.le)):
            if limit is not None:
                number[keyword] = limit
        return {"anyOf": [number, {"type": "string"}], "x-unit": self.unit}


Length = Annotated[float, Quantity("m")]
PositiveLength = Annotated[float, Quantity("m", gt=0)]
Angle = Annotated[float, Quantity("rad")]
Mass = Annotated[float, Quantity("kg", gt=0)]
Inertia = Annotated[float, Quantity("kg m^2", gt=0)]
Speed = Annotated[float, Quantity("m/s")]
AngularSpeed = Annotated[float, Quantity("rad/s")]
Time = Annotated[float, Quantity("s")]
PositiveTime = Annotated[float, Quantity("s", gt=0)]
Force = Annotated[float, Quantity("N")]
Torque = Annotated[float, Quantity("N m")]
Stiffness = Annotated[float, Quantity("N/m", ge=0)]
PositiveStiffness = Annotated[float, Quantity("N/m", gt=0)]
Damping = Annotated[float, Quantity("N s/m", ge=0)]
PositiveDamping = Annotated[float, Quantity("N s/m", gt=0)]
AngularStiffness = Annotated[float, Quantity("N m/rad", ge=0)]
PositiveAngularStiffness = Annotated[float, Quantity("N m/rad", gt=0)]
AngularDamping = Annotated[float, Quantity("N m s/rad", ge=0)]
PositiveAngularDamping = Annotated[float, Quantity("N m s/rad", gt=0)]
Modulus = Annotated[float, Quantity("Pa", gt=0)]
