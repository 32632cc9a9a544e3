"""Distributions of a varied number: from a probability to a value, within the range that a key allows.

kind, its numbers, least, most -> [quantile_function] -> function of probability, and its ends
"""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from rollerrig.common.arrays import Array
from rollerrig.config.schema.units import Quantity

LEAST_MASS = 1e-9
"""Least share of the part of a distribution that is between its ends."""


MOST_LOST = 1e-6
"""Probability beyond what the key allows that is cut off without a word."""


def quantile_function(
    kind: str, numbers: Mapping[str, float], least: float | None, most: float | None, quantity: Quantity
) -> tuple[Callable[[Array], Array], tuple[float, float]]:
    """Value over probability, and the values at both ends.

    Args:
        kind: linear or logarithmic for a range in which all values are equally likely; normal, lognormal, triangular.
        numbers: mean, deviation, median, mode, of the kinds that have them; in SI, the deviation of lognormal a pure number.
        least: lower end [SI]; None: that of the quantity.
        most: upper end, likewise.
        quantity: at the key.

    Raises:
        ValueError: no probability mass is between the ends, or some is where the key allows none.
    """
    from scipy import stats

    law: Any
    turned, straight = (np.log, np.exp) if kind in ("logarithmic", "lognormal") else (np.asarray, np.asarray)
    match kind:
        case "normal":
            law = stats.norm(numbers["mean"], numbers["deviation"])
        case "lognormal":
            law = stats.norm(np.log(numbers["median"]), numbers["deviation"])
        case "triangular":
            assert least is not None
            assert most is not None
            if not least <= numbers["mode"] <= most:
                raise ValueError("allowed: a mode between `least` and `most`")
            law = stats.triang((numbers["mode"] - least) / (most - least), least, most - least)
        case _:
            assert least is not None
            assert most is not None
            law = stats.uniform(turned(least), turned(most) - turned(least))

    def below(value: float) -> float:
        return 0.0 if kind == "lognormal" and value <= 0.0 else float(law.cdf(turned(value)))

    floor, ceiling = quantity.least if least is None else least, quantity.most if most is None else most
    low, high = below(floor), below(ceiling)
    unit = "" if quantity.unit == "1" else f" {quantity.unit}"
    if not high - low > LEAST_MASS:
        raise ValueError(
            "no probability mass lies between its ends; allowed: `least` and `most` around the distribution"
        )
    if least is None and low > MOST_LOST:
        raise ValueError(
            f"{100 * low:.2g} % of it lies below {quantity.least:g}{unit}, which the key does not allow; give `least`"
        )
    if most is None and 1.0 - high > MOST_LOST:
        raise ValueError(
            f"{100 * (1 - high):.2g} % of it lies above {quantity.most:g}{unit}, which the key does not allow; give `most`"
        )

    def quantile(probability: Array) -> Array:
        values = straight(law.ppf(low + (high - low) * np.asarray(probability)))
        return np.clip(np.asarray(values, dtype=np.float64), floor, ceiling)

    ends = quantile(np.array([1e-12, 1.0 - 1e-12]))
    return quantile, (float(ends[0]), float(ends[1]))
