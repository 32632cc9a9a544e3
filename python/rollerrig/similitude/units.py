"""How a unit is made of kilogram, metre and second.

    "N m s/rad" -> [exponents] -> (kg 1, m 2, s -1)

Only the units that the configuration and the results use; angles, counts and percents have no dimension.
"""

from __future__ import annotations

import re
from functools import lru_cache

Exponents = tuple[int, int, int]
"""Powers of kg, m and s."""

_BASE: dict[str, Exponents] = {
    "1": (0, 0, 0),
    "%": (0, 0, 0),
    "rad": (0, 0, 0),
    "deg": (0, 0, 0),
    "kg": (1, 0, 0),
    "t": (1, 0, 0),
    "m": (0, 1, 0),
    "mm": (0, 1, 0),
    "km": (0, 1, 0),
    "l": (0, 3, 0),
    "s": (0, 0, 1),
    "ms": (0, 0, 1),
    "h": (0, 0, 1),
    "Hz": (0, 0, -1),
    "N": (1, 1, -2),
    "kN": (1, 1, -2),
    "J": (1, 2, -2),
    "W": (1, 2, -3),
    "Pa": (1, -1, -2),
    "MPa": (1, -1, -2),
}

_TOKEN = re.compile(r"(%|[A-Za-z]+|1)(?:\^(-?\d+))?")


class UnknownUnitError(ValueError):
    """A unit that is not made of kg, m and s."""


@lru_cache(maxsize=256)
def exponents(unit: str) -> Exponents:
    """Powers of kg, m and s in a unit like "N s^2/m^2"; all that follows the stroke divides.

    Raises:
        UnknownUnitError: it is not known.
    """
    above, stroke, below = unit.partition("/")
    total = [0, 0, 0]
    for text, sign in ((above, 1), *([(below.strip("()"), -1)] if stroke else [])):
        for word in text.split():
            token = _TOKEN.fullmatch(word)
            if token is None or token[1] not in _BASE:
                raise UnknownUnitError(f"unit {unit!r}: {word!r} is not one of {', '.join(_BASE)}")
            for i, power in enumerate(_BASE[token[1]]):
                total[i] += sign * power * int(token[2] or 1)
    return total[0], total[1], total[2]
