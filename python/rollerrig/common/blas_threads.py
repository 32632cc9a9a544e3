"""Small matrices are solved on one thread, and the user's setting is back afterwards.

    [one_blas_thread] -> eigenvalues, products and least squares of some ten to some hundred rows

The threads of a BLAS library wait for each other in a loop: with a matrix of a hundred rows they cost ten to forty times the
processor time of one thread, and more of the clock. Whatever solves such matrices here does so within `one_blas_thread`; worker
processes, of which there are as many as cores, do all their work in it.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from threadpoolctl import get_cached_controller


@contextmanager
def one_blas_thread() -> Iterator[None]:
    """Within it, or within a function decorated with it, the BLAS libraries of this process use one thread.

    Where several Python threads are in it at a time, the first one sets and restores it; the others leave it alone.
    """
    with get_cached_controller().limit(limits=1, user_api="blas"):
        yield
