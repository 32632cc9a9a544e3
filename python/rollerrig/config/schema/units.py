"""Quantities at the border: a number in SI or a text with a unit goes in, a float in SI comes out.

    0.46 | "0.46 m" | "460 mm"  ->  [Quantity]  ->  0.46

pint knows the units; it is imported (0.4 s) only when a text has a unit that is not among the most usual ones. Rounding: the
decimal number is converted exactly and rounded once, so that "460 mm" and 0.46 are the same float.
"""

import math
import re
from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from numbers import Real
from typing import TYPE_CHECKING, Annotated, Any

from pydantic import GetJsonSchemaHandler, SerializationInfo
from pydantic_core import CoreSchema, core_schema

if TYPE_CHECKING:
    import pint

AS_WRITTEN = "as written"
"""Context of pydantic's serialization in which a number that needs its unit is a text."""

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

# texts that a message offers, with their value in SI: the first that is allowed at the key is shown
_EXAMPLES: dict[str, tuple[tuple[str, float], ...]] = {
    "m": (("460 mm", 0.46), ("100 m", 100.0), ("10 mm", 0.01), ("0.05 mm", 5e-5)),
    "m/s": (("100 km/h", 100 / 3.6), ("1 m/s", 1.0), ("1 mm/s", 1e-3)),
    "kg": (("1813 kg", 1813.0),),
    "kg m^2": (("1120 kg m^2", 1120.0),),
    "N": (("54 kN", 54e3),),
    "N m": (("4 kN m", 4e3),),
    "N/m": (("3.9 MN/m", 3.9e6),),
    "N s/m": (("15 kN s/m", 15e3),),
    "N m/rad": (("940 kN m/rad", 940e3),),
    "N m s/rad": (("2 kN m s/rad", 2e3),),
    "rad": (("2.4 mrad", 2.4e-3),),
    "rad/s": (("10 deg/s", math.radians(10.0)),),
    "s": (("10 ms", 0.01), ("10 s", 10.0)),
    "Pa": (("82 GPa", 82e9), ("3.8 bar", 3.8e5)),
    "Pa/s": (("1.2 bar/s", 1.2e5),),
    "Hz": (("20 Hz", 20.0),),
    "m/s^2": (("1.6 m/s^2", 1.6),),
    "m^3/(s Pa)": (("20 dm^3/(s bar)", 2e-7),),
}

# what pint says of the units of most files, which are read without it; those that people think in first
_USUAL: dict[str, dict[str, Fraction | int]] = {
    "m": {"mm": Fraction(1, 1000)},
    "m/s": {"km/h": Fraction(5, 18)},
    "kg": {"t": 1000},
    "s": {"ms": Fraction(1, 1000), "min": 60},
    "rad": {"deg": Fraction(math.radians(1.0)).limit_denominator(10**9), "mrad": Fraction(1, 1000)},
    "N": {"kN": 1000},
    "N m": {"kN m": 1000},
    "N/m": {"kN/m": 1000, "MN/m": 10**6},
    "N s/m": {"kN s/m": 1000},
    "N m/rad": {"kN m/rad": 1000, "MN m/rad": 10**6},
    "N m s/rad": {"kN m s/rad": 1000},
    "Pa": {"GPa": 10**9, "MPa": 10**6, "bar": 10**5},
    "Hz": {"kHz": 1000},
    "W": {"kW": 1000, "MW": 10**6},
}
_KNOWN = {(unit, si): Fraction(factor) for si, units in _USUAL.items() for unit, factor in units.items()}

_TURNS_PER_MINUTE = ("1/min", "min^-1", "min⁻¹", "rev/min", "r/min", "U/min", "RPM")

_NUMBER_AND_UNIT = re.compile(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*(\S.*?)\s*")
_UNIT_TEXT = re.compile(r"[A-Za-zµμ°%·⋅*/^()²³ \d-]{1,40}")
_POWER_TOWER = re.compile(r"\d\s*(\^|\*\*|\d)")  # "m^9^9^9" would keep the machine busy for years
_RATIO = re.compile(r"\s*(\d{1,6}(?:\.\d{1,6})?)\s*:\s*(\d{1,9}(?:\.\d{1,6})?)\s*")


@lru_cache(maxsize=1)
def _registry() -> "pint.UnitRegistry[Any]":
    import pint

    registry: pint.UnitRegistry[Any] = pint.UnitRegistry(on_redefinition="ignore")  # its own Nm is a yarn count
    registry.define("newton_metre_joined = newton * meter = Nm")  # railway texts write kNm and kNs
    registry.define("newton_second_joined = newton * second = Ns")
    registry.define("kilometre_per_hour_joined = kilometer / hour = kmh")
    return registry


@lru_cache(maxsize=512)
def unit_factor(unit: str, si_unit: str) -> Fraction | None:
    """Number of ``si_unit`` in one ``unit``; None if ``unit`` is unknown or measures something else."""
    if unit == si_unit:  # as cases write themselves: pint is not needed
        return Fraction(1)
    if si_unit == "rad/s":  # for pint a turn per minute is 1/60 rad/s, and a hertz one
        unit = "rpm" if unit in _TURNS_PER_MINUTE else unit
        if unit == "Hz":
            return None
    return _KNOWN.get((unit, si_unit)) or _factor_by_pint(unit, si_unit)


def _factor_by_pint(unit: str, si_unit: str) -> Fraction | None:
    if not _UNIT_TEXT.fullmatch(unit) or _POWER_TOWER.search(unit):
        return None
    registry = _registry()
    try:
        factor = registry.Quantity(1.0, registry.parse_units(unit)).to(registry.parse_units(si_unit)).magnitude
    # PintError, DimensionalityError (a TypeError), tokenizer and syntax errors: all mean "no such unit"
    except Exception:
        return None
    near = Fraction(factor).limit_denominator(10**9)
    return near if float(near) == factor else Fraction(factor)


def base_powers(unit: str) -> tuple[float, dict[str, int]]:
    """Size of a unit in SI, and how it is made of the base units: "kN m" -> (1000, {"kg": 1, "m": 2, "s": -2}).

    Raises:
        ValueError: not a unit.
    """
    text, registry = unit or "1", _registry()
    if not _UNIT_TEXT.fullmatch(text) or _POWER_TOWER.search(text):
        raise ValueError(f"{unit!r} is not a unit")
    try:
        base: Any = registry.Quantity(*((0.01, "1") if unit == "%" else (1.0, text))).to_base_units()
        powers = {registry.get_symbol(name): Fraction(power) for name, power in base.unit_items()}
    except Exception:  # as in _factor_by_pint
        raise ValueError(f"{unit!r} is not a unit") from None
    if any(power.denominator > 1 for power in powers.values()):
        raise ValueError(f"{unit!r} has powers that are no whole numbers")
    return base.magnitude, {name: int(power) for name, power in powers.items()}


def is_quantity(value: object) -> bool:
    """Whether it is a quantity of pint, of whichever registry; pint itself is not imported."""
    return hasattr(value, "magnitude") and hasattr(value, "units") and hasattr(value, "dimensionality")


def quantity_text(value: Any) -> str:
    """A scalar quantity of pint as a file would write it; of an array it is no number with a unit, and refused as such."""
    scalar = hasattr(value.magnitude, "item") and not value.magnitude.shape
    number = value.magnitude.item() if scalar else value.magnitude
    return f"{number!r} {value.units:D}"


@dataclass(frozen=True)
class Quantity:
    """Pydantic annotation of a float that has a unit and a range.

    Every number of a configuration has both: what lies outside is a slip of the pen, and would end in an overflow, a hang or
    a result that means nothing.
    """

    unit: str  # SI unit of the validated number; "1" for a pure number
    least: float  # smallest value that is allowed
    most: float  # largest value that is allowed
    # largest magnitude that may be written without a unit: beyond it another unit may have been meant, `speed = 60` is
    # 216 km/h; None: all may
    bare: float | None = None

    @property
    def bounds(self) -> str:
        """The range in words."""
        unit = "" if self.unit == "1" else f" {self.unit}"
        limits = f"from {self.least:g} to {self.most:g}{unit}"
        return limits if self.bare is None else f"{limits}, with its unit written beyond {self.bare:g}{unit}"

    @property
    def allowed(self) -> str:
        """What may be written, in words."""
        if self.unit == "1":
            kind = "a number"
        else:
            fitting = (text for text, si in _EXAMPLES.get(self.unit, ()) if self.least <= si <= self.most)
            example = next(fitting, "")
            kind = f"a number in {self.unit} or a text with a unit" + (f" like '{example}'" if example else "")
        return f"allowed: {kind}, {self.bounds}"

    def parse(self, value: object) -> float:
        """The value in SI.

        Raises:
            ValueError: not a finite number, not a unit of this kind, out of the range, or a number without a unit of which one
                cannot believe that it is meant in SI.
        """
        number = self._to_si(value)
        if number is None or not math.isfinite(number):
            without = "a number without a unit" if isinstance(value, str) else "a number"
            raise ValueError(self.allowed.replace("a number,", f"{without},"))
        bare = isinstance(value, float | Real)
        if not self.least <= number <= self.most or (bare and self.bare is not None and abs(number) > self.bare):
            raise ValueError(self.allowed + (self._meant(number) if bare else ""))
        return number

    def as_written(self, value: float) -> float | str:
        """The number as a file holds it: where `parse` asks for a unit the shortest text that means it."""
        if self.bare is None or abs(value) <= self.bare:
            return value
        units = {**_USUAL.get(self.unit, {}), self.unit: 1}
        texts = [f"{value!r} {self.unit}", *(f"{value / float(si):.12g} {unit}" for unit, si in units.items())]
        return min((text for text in texts if self._to_si(text) == value), key=len)

    def _meant(self, number: float) -> str:
        """What a number would be with the unit that people think in, and with its own; "" if nothing fits."""
        usual = [u for u, si in _USUAL.get(self.unit, {}).items() if self.least <= number * float(si) <= self.most]
        own = [self.unit] if self.least <= number <= self.most else []
        guesses = " or ".join(f"'{number:g} {unit}'" for unit in (*usual[:1], *own))
        return f"; did you mean {guesses}?" if guesses and number else ""

    def _to_si(self, value: object) -> float | None:
        if isinstance(value, bool):
            return None
        if isinstance(value, float | Real):  # those of NumPy too; float first: Real is slow to answer
            try:
                return float(value)
            except OverflowError:
                return None
        if not isinstance(value, str):
            return self._to_si(quantity_text(value)) if is_quantity(value) else None
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

    def __get_pydantic_core_schema__(self, _source: object, _handler: Callable[[object], CoreSchema]) -> CoreSchema:
        """A plain function does all the work."""
        written = core_schema.plain_serializer_function_ser_schema(self._serialize, info_arg=True)
        return core_schema.no_info_plain_validator_function(self.parse, serialization=written)

    def _serialize(self, value: float, info: SerializationInfo) -> float | str:
        return self.as_written(value) if info.context == AS_WRITTEN else value

    def __get_pydantic_json_schema__(self, _schema: CoreSchema, _handler: GetJsonSchemaHandler) -> dict[str, Any]:
        """A number or a text, with the unit and the bounds beside it."""
        least, most = (self.least, self.most) if self.bare is None else (max(self.least, -self.bare), self.bare)
        number = {"type": "number", "minimum": least, "maximum": most}
        return {"anyOf": [number, {"type": "string"}], "x-unit": self.unit, "x-range": [self.least, self.most]}


# Ranges of what a rig, a vehicle or a model of either can have, from 1:100 models to full scale with a margin of some decades:
# wide enough for every study, narrow enough that nothing overflows. A key with a range of its own names it where it stands.
Position = Annotated[float, Quantity("m", -200.0, 200.0)]
Angle = Annotated[float, Quantity("rad", -3.2, 3.2)]
Mass = Annotated[float, Quantity("kg", 1e-5, 1e8)]
Inertia = Annotated[float, Quantity("kg m^2", 1e-10, 1e10)]
RunningSpeed = Annotated[float, Quantity("m/s", 0.0, 200.0, bare=10.0)]
Time = Annotated[float, Quantity("s", -1e6, 1e6)]
Force = Annotated[float, Quantity("N", -1e8, 1e8)]
Torque = Annotated[float, Quantity("N m", -1e9, 1e9)]
RollerRadius = Annotated[float, Quantity("m", 1e-3, 1e6, bare=10.0)]
WheelRadius = Annotated[float, Quantity("m", 0.01, 2.0)]
PositiveStiffness = Annotated[float, Quantity("N/m", 1e-6, 1e13)]
Damping = Annotated[float, Quantity("N s/m", 0.0, 1e11)]
PositiveAngularStiffness = Annotated[float, Quantity("N m/rad", 1e-6, 1e13)]
AngularDamping = Annotated[float, Quantity("N m s/rad", 0.0, 1e11)]
Frequency = Annotated[float, Quantity("Hz", 1e-4, 1e7)]
Delay = Annotated[float, Quantity("s", 0.0, 1.0)]
SampleTime = Annotated[float, Quantity("s", 1e-6, 1.0)]
Phase = Annotated[float, Quantity("s", 1e-6, 1e4)]
