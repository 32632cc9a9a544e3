"""Workers of a dask cluster as an executor for `run_jobs`.

address of a scheduler -> [cluster] -> Executor, or ClusterError that says why there is none
"""

from collections.abc import Iterator
from concurrent.futures import Executor
from contextlib import contextmanager
from typing import Any

from rollerrig import __version__

CONNECT_SECONDS = 10.0
"""A scheduler that does not answer by then is not there."""


class ClusterError(Exception):
    """The workers cannot be used; the message is one line."""


@contextmanager
def cluster(address: str) -> Iterator[Executor]:
    """The workers of a scheduler; a job of a worker that ends is done again by another one.

    Args:
        address: of the scheduler, such as 'tcp://10.0.0.5:8786'.

    Raises:
        ClusterError: dask.distributed is not installed, nothing answers, or the workers have no or another rollerrig.
    """
    try:
        import distributed
    except ImportError:
        raise ClusterError("dask.distributed is not installed; pip install 'rollerrig[sweep]'") from None
    connect: Any = distributed.Client
    try:
        client = connect(address, timeout=CONNECT_SECONDS, set_as_default=False)
    except (OSError, ValueError, TypeError) as error:
        reason = str(error).splitlines()[0] if str(error) else type(error).__name__
        needed = "needed: the address of a running scheduler, such as tcp://127.0.0.1:8786"
        raise ClusterError(f"{address}: no scheduler there ({reason}); {needed}") from None
    try:
        _check_workers(client, address)
        yield client.get_executor(pure=False)
    finally:
        client.close()


def _check_workers(client: Any, address: str) -> None:
    """Refuse a cluster without workers, or whose workers would compute something else."""
    try:
        found = client.run(_version)
    except Exception as error:
        reason = (str(error).splitlines() or [type(error).__name__])[0]
        raise ClusterError(f"{address}: its workers have no rollerrig {__version__} ({reason})") from None
    if not found:
        raise ClusterError(f"{address}: a scheduler without workers; start some with `dask worker {address}`")
    other = {worker: version for worker, version in found.items() if version != __version__}
    if other:
        worker, version = next(iter(other.items()))
        raise ClusterError(f"{address}: its worker {worker} has rollerrig {version}; needed: {__version__} as here")


def _version() -> str:
    return __version__
