"""Independent jobs, several at a time, each in a worker process: progress, Ctrl-C, and processes that die.

    jobs by name -> [run_jobs] -> each result as soon as it is there

One job at a time runs in this process. Several run in worker processes: a third to two thirds of a short run, and all of a
linearisation, are Python, where threads wait for each other; code of a user may hold the interpreter or keep a state of its
own; and a process that dies costs one job.

A ProcessPoolExecutor loses all its running jobs with one process, and does not say which of them was the cause: here each
worker is one of its own, with a number in shared memory for its progress. loky is alike; pebble is under the LGPL. A cluster
that is there already is used (cluster.py).
"""

from __future__ import annotations

import ctypes
import gc
import inspect
import math
import multiprocessing
import os
import signal
import sys
import threading
import time
from collections import deque
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import FIRST_COMPLETED, CancelledError, Executor, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from dataclasses import dataclass
from multiprocessing import resource_tracker
from types import FrameType
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:  # a worker watches its parent before it imports what its jobs need
    from rollerrig.simulation.run import Progress

ELSEWHERE_AHEAD = 256
"""Jobs that an executor is given whose workers are not counted here."""

GRACE_SECONDS = 3.0
"""After Ctrl-C a job has so long to return what it has; then its process is killed."""

POLL_SECONDS = 0.1
"""Between two looks at the progress of the jobs, and at whether they shall stop."""

_CONTEXT = multiprocessing.get_context("spawn")
_PR_SET_PDEATHSIG = 1  # <linux/prctl.h>


class WorkerError(RuntimeError):
    """A worker process did not start, or ended in the middle of a job, also where the job was done once more."""

    def __init__(self, job: str = "") -> None:
        super().__init__(
            f"a worker process ended in the middle of its job, {job}: killed, or out of memory; "
            "the same command continues with what is finished, best on fewer processes"
            if job
            else "a worker process ended before its first job: out of memory, or a script without "
            "`if __name__ == '__main__':` around what it runs"
        )


@dataclass(frozen=True)
class Job:
    """A call to be made on any process.

    Attributes:
        function: on the top level of a module; it gets `progress` if it has such a parameter.
        arguments: all its other arguments.
        lost: called with `arguments` for the result where the job ends its process again and again; None: that is an error.
    """

    function: Callable[..., Any]
    arguments: tuple[Any, ...]
    lost: Callable[..., Any] | None = None

    def call(self, progress: Progress) -> Any:
        """Do it."""
        takes_progress = "progress" in inspect.signature(self.function).parameters
        return self.function(*self.arguments, **({"progress": progress} if takes_progress else {}))


def run_jobs(
    jobs: Mapping[str, Job],
    keep: Callable[[str, Any], Mapping[str, Job]],
    report: Progress,
    *,
    processes: int = 1,
    executor: Executor | None = None,
) -> bool:
    """Run jobs. One whose process died is run once more, alone, when all others are done.

    Args:
        jobs: by name.
        keep: called in this thread with name and result of each job as soon as it is done; returns jobs that follow it.
        report: called now and then with how many jobs' worth of work is done, and the name of the last finished job.
        processes: how many at a time; 1 stays in this process. More start fresh Python processes: a script that asks for
            them needs `if __name__ == "__main__":`.
        executor: runs the jobs in place of processes of this machine; it stays open.

    Returns:
        Whether Ctrl-C, or a KeyboardInterrupt of `report` or of a job, ended them early.

    Raises:
        WorkerError: no worker process starts, or a job without `lost` ended two of them; what was finished has been kept.
    """
    run = _Run(jobs, keep, report, min(processes, len(jobs)), executor)
    with _interrupt_calls(run.stop):
        return run.all_jobs()


class _Run:
    """The jobs of one call: those that wait, those that are running, and what runs them."""

    def __init__(
        self,
        jobs: Mapping[str, Job],
        keep: Callable[[str, Any], Mapping[str, Job]],
        report: Progress,
        count: int,
        executor: Executor | None,
    ):
        self._keep, self._report, self._elsewhere = keep, report, executor
        self._in_processes = count > 1 and not executor
        self._free = list(range(ELSEWHERE_AHEAD if executor else max(count, 1)))  # places of jobs
        # how far the job of each place is, negative before its process is ready; the last one: whether they shall stop
        self._state = _CONTEXT.RawArray("d", [0.0] * (len(self._free) + 1))
        self._pools: dict[int, ProcessPoolExecutor] = {}
        self._waiting, self._alone, self._died = deque(jobs.items()), deque[tuple[str, Job]](), set[str]()
        self._running: dict[Future[Any], tuple[str, Job, int]] = {}
        self._stopped = math.inf  # when
        self._count, self._last, self._shown = 0, next(iter(jobs), ""), 0.0

    def all_jobs(self) -> bool:
        """Run them all; whether they were stopped. No process is left behind."""
        try:
            self._look()
            while self._hand_out():
                done, _ = wait(self._running, POLL_SECONDS, FIRST_COMPLETED)
                if time.monotonic() > self._stopped + GRACE_SECONDS:
                    self._kill()
                found = [(future, *self._running.pop(future)) for future in done]
                died = [self._released(future, place) for future, _, _, place in found]
                if self._elsewhere or self._pools:
                    self._hand_out()  # before results are kept, which takes a while
                for (future, name, job, _), lost in zip(found, died, strict=True):
                    self._take(future, name, job, lost)
                self._look()
            return self._stopped < math.inf
        finally:
            self.stop()
            self._kill()
            for pool in self._pools.values():
                pool.shutdown()

    def stop(self) -> None:
        """Ask the jobs to end."""
        self._state[-1], self._stopped = 1.0, min(self._stopped, time.monotonic())
        for future in list(self._running):
            future.cancel()

    def _kill(self) -> None:
        for pool in self._pools.values():
            for process in list((pool._processes or {}).values()):  # `kill_workers` from Python 3.14 on
                process.kill()

    def _hand_out(self) -> bool:
        """Submit jobs as long as there is room; whether any are running."""
        while self._stopped == math.inf and self._free and (self._waiting or (self._alone and not self._running)):
            name, job = (self._waiting or self._alone).popleft()
            place = self._free.pop(0)
            self._running[self._submit(job, place)] = name, job, place
        return bool(self._running)

    def _submit(self, job: Job, place: int) -> Future[Any]:
        if self._elsewhere:
            return self._elsewhere.submit(_call, job)
        if self._in_processes:
            return self._submit_to_worker(Job(job.function, job.arguments), place)
        future: Future[Any] = Future()

        def progress(fraction: float, _text: str) -> None:
            self._state[place] = fraction
            self._look()
            if self._stopped < math.inf:
                raise KeyboardInterrupt

        try:
            future.set_result(job.call(progress))
        except (Exception, KeyboardInterrupt) as error:
            future.set_exception(error)
        return future

    def _submit_to_worker(self, job: Job, place: int) -> Future[Any]:
        with _interrupts_blocked():
            if place not in self._pools:
                self._state[place] = -1.0
                self._pools[place] = ProcessPoolExecutor(1, _CONTEXT, _begin, (self._state, place))
            pool = self._pools[place]
            try:
                future = pool.submit(_work, job)
            except BrokenProcessPool:  # its process ended while it had no job
                self._pools.pop(place).shutdown()
                return self._submit_to_worker(job, place)
        # the end of the worker alone is left: else half a result, of a process that was killed, would be waited for for ever
        pool._result_queue._writer.close()  # type: ignore[attr-defined]
        return future

    def _released(self, future: Future[Any], place: int) -> bool:
        """Make the place of a job free for another one; whether its process has ended.

        Raises:
            WorkerError: before it was ready.
        """
        died = place in self._pools and not future.cancelled() and isinstance(future.exception(), BrokenProcessPool)
        if died:
            if self._state[place] < 0.0 and self._stopped == math.inf:
                raise WorkerError
            self._pools.pop(place).shutdown()
        self._state[place] = 0.0
        self._free.append(place)
        return died

    def _take(self, future: Future[Any], name: str, job: Job, died: bool) -> None:
        """Keep the result of a job that is done."""
        try:
            result = future.result()
        except (KeyboardInterrupt, CancelledError):
            self.stop()
            return
        except Exception as error:
            if died and (name not in self._died or self._stopped < math.inf):
                self._died.add(name)
                self._alone.append((name, job))
                return
            # KilledWorker: of dask, which need not be installed; its scheduler has tried the job on several workers
            if not died and type(error).__name__ != "KilledWorker":
                raise
            if job.lost is None:
                raise WorkerError(name) from None
            result = job.lost(*job.arguments)
        self._waiting.extend(self._keep(name, result).items())
        self._count, self._last = self._count + 1, name

    def _look(self) -> None:
        """Report what is done, never less than before."""
        if self._stopped == math.inf:
            self._shown = max(self._shown, self._count + sum(max(one, 0.0) for one in self._state[:-1]))
            try:
                self._report(self._shown, self._last)
            except KeyboardInterrupt:
                self.stop()


@contextmanager
def _interrupt_calls(stop: Callable[[], None]) -> Iterator[None]:
    """Within it the first Ctrl-C calls a function and raises nothing, so that no result is lost between two lines."""
    before = signal.getsignal(signal.SIGINT)
    if threading.current_thread() is not threading.main_thread() or not callable(before):
        yield
        return
    pressed = 0

    def handle(number: int, frame: FrameType | None) -> None:
        nonlocal pressed
        pressed += 1
        stop()
        try:
            before(number, frame)
        except KeyboardInterrupt:
            if pressed > 1:
                raise

    signal.signal(signal.SIGINT, handle)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


@contextmanager
def _interrupts_blocked() -> Iterator[None]:
    """Ctrl-C in a terminal reaches every process; those that are started within this leave it to this process."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    resource_tracker.ensure_running()  # started with the first process otherwise, and unblocks the signal then
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


# ----------------------------------------------------------------------------------------- on another process


def _call(job: Job, progress: Progress = lambda _fraction, _text: None) -> Any:
    from rollerrig.common.linear_algebra import one_blas_thread

    with one_blas_thread():  # there are as many workers as cores
        return job.call(progress)


_PLACE: list[Any] = []
"""In a worker: the shared numbers, and which of them is its own."""


def _begin(state: Any, place: int) -> None:
    """Make this process a worker, which ends with its parent."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # where it could not be blocked
    gc.set_threshold(50_000, 20, 20)  # as in the command line
    if sys.platform == "linux":  # also in the middle of a call into the core that holds the interpreter
        ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL, 0, 0, 0)
    threading.Thread(target=_end_with_parent, daemon=True).start()
    _PLACE[:] = state, place
    state[place] = 0.0


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    assert parent is not None
    parent.join()
    os._exit(1)  # no cleanup: there is nobody to report it to


def _work(job: Job) -> Any:
    state, place = _PLACE

    def progress(fraction: float, _text: str) -> None:
        if state[-1]:
            raise KeyboardInterrupt
        state[place] = fraction

    progress(0.0, "")
    return _call(job, progress)
