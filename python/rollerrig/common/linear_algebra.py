"""Small matrices: their eigenvalues, and one thread for whatever solves them.

    matrix -> [eigenvalues, in one_blas_thread] -> its eigenvalues, in no order

The threads of a BLAS library wait for each other in a loop: with a matrix of a hundred rows they cost ten to forty times the
processor time of one thread, and more of the clock. Whatever solves such matrices here does so within `one_blas_thread`; worker
processes, of which there are as many as cores, do all their work in it.

Eigenvalues of the last matrices are not computed again: runs from the same steady rolling, with other disturbances,
durations or friction that acts later, ask for the same ones.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from functools import lru_cache

import numpy as np
from threadpoolctl import get_cached_controller

from rollerrig.common.arrays import Array, Complex


@contextmanager
def one_blas_thread() -> Iterator[None]:
    """Within it, or within a function decorated with it, the BLAS libraries of this process use one thread.

    Where several Python threads are in it at a time, the first one sets and restores it; the others leave it alone.
    """
    with get_cached_controller().limit(limits=1, user_api="blas"):
        yield


def eigenvalues(matrix: Array) -> Complex:
    """Eigenvalues of a square matrix, shape (n,), which may not be written to; one BLAS thread computes them."""
    return _of_bytes(matrix.tobytes(), len(matrix))


@lru_cache(maxsize=32)
def _of_bytes(numbers: bytes, size: int) -> Complex:
    with one_blas_thread():
        values = np.linalg.eigvals(np.frombuffer(numbers).reshape(size, size)).astype(np.complex128)
    values.flags.writeable = False
    return values
