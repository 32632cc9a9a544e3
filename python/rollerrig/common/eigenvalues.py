"""Eigenvalues of small matrices, of the last ones without computing them again.

    matrix -> [eigenvalues] -> its eigenvalues, in no order

Runs from the same steady rolling, with other disturbances, durations or friction that acts later, ask for the same ones.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from rollerrig.common.blas_threads import one_blas_thread


def eigenvalues(matrix: NDArray[np.float64]) -> NDArray[np.complex128]:
    """Eigenvalues of a square matrix, shape (n,), which may not be written to; one BLAS thread computes them."""
    return _of_bytes(matrix.tobytes(), len(matrix))


@lru_cache(maxsize=32)
def _of_bytes(numbers: bytes, size: int) -> NDArray[np.complex128]:
    with one_blas_thread():
        values = np.linalg.eigvals(np.frombuffer(numbers).reshape(size, size)).astype(np.complex128)
    values.flags.writeable = False
    return values
