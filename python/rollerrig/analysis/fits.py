"""Least-squares fits and what they leave."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rollerrig.common.blas_threads import one_blas_thread

Series = NDArray[np.float64]


@dataclass(frozen=True)
class Fit:
    """A linear least-squares fit.

    Attributes:
        coefficients: one per column.
        residual: root mean square of what is left, over the largest value [1].
        largest: largest of what is left, over the largest value [1].
    """

    coefficients: tuple[float, ...]
    residual: float
    largest: float


@one_blas_thread()
def fit(values: Series, *columns: Series) -> Fit:
    """Fit values by a sum of columns.

    Args:
        values: shape (n,).
        columns: each of shape (n,).
    """
    matrix = np.stack(columns, axis=1)
    solution = np.linalg.lstsq(matrix, values, rcond=None)[0]
    left = values - matrix @ solution
    scale = float(np.abs(values).max()) or 1.0
    return Fit(
        tuple(float(c) for c in solution), float(np.sqrt(np.mean(left**2))) / scale, float(np.abs(left).max()) / scale
    )
