"""Units of the core's variables as powers of SI base units, as the standard wants them.

"kg/m^2" -> {"kg": 1, "m": -2}
"""

from __future__ import annotations

import re

BASE = ("kg", "m", "s", "A", "K", "mol", "cd", "rad")
"""Names and order of the standard, FMI 2.0.4 section 2.2.2."""

DERIVED = {
    "N": {"kg": 1, "m": 1, "s": -2},
    "Pa": {"kg": 1, "m": -1, "s": -2},
    "J": {"kg": 1, "m": 2, "s": -2},
    "W": {"kg": 1, "m": 2, "s": -3},
    "Hz": {"s": -1},
    "V": {"kg": 1, "m": 2, "s": -3, "A": -1},
}


def base_units(unit: str) -> dict[str, int]:
    """Powers of the base units of a unit such as 'N m', 'J/m^2' or '1', in the standard's order.

    Raises:
        ValueError: a part of it is no unit of SI without a prefix.
    """
    powers = dict.fromkeys(BASE, 0)
    above, *below = unit.split("/")
    for sign, product in [(1, above), *((-1, part) for part in below)]:
        for factor in product.split():
            if factor == "1":
                continue
            symbol, power = _factor(factor, unit)
            for base, exponent in ({symbol: 1} if symbol in powers else DERIVED[symbol]).items():
                powers[base] += sign * power * exponent
    return {base: power for base, power in powers.items() if power}


def _factor(factor: str, unit: str) -> tuple[str, int]:
    match = re.fullmatch(r"([A-Za-z]+)(?:\^(\d+))?", factor)
    if match is None or (match[1] not in BASE and match[1] not in DERIVED):
        raise ValueError(f"unit {unit!r}: {factor!r} is not one of {', '.join((*BASE, *DERIVED))}")
    return match[1], int(match[2] or 1)
