"""What of a signal is round-off: symmetric vehicles do not move sideways, but for 1e-17 m.

signal, unit -> [resolution] -> the signal with zeros where it means nothing
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

RESOLUTION = {"m": 1e-10, "rad": 1e-10, "m/s": 1e-9, "m/s^2": 1e-7, "N": 1e-3, "1": 1e-8}
"""Magnitude below which a value counts as zero, by unit; of displacements a tenth of the default absolute tolerance."""


def resolved(values: ArrayLike, unit: str) -> NDArray[np.float64]:
    """The values with zeros where their magnitude is below that of RESOLUTION.

    Args:
        values: any shape; NaN stays.
        unit: a key of RESOLUTION.
    """
    given = np.asarray(values, dtype=np.float64)
    return np.where(np.abs(given) < RESOLUTION[unit], 0.0, given)
