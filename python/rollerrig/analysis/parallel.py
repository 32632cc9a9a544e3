"""Independent jobs on a few processes, or on an executor that leads elsewhere, with progress and Ctrl-C.

    function, one argument per job -> [run_jobs] -> one result per job, None for those that Ctrl-C cut off

A job is called as `function(argument, progress)` and shall call `progress(fraction, text)` now and then: that is also where
Ctrl-C reaches it, as a KeyboardInterrupt. Only a few jobs per worker are handed out ahead, so that the bookkeeping of a job does
not grow with their number.
"""

from __future__ import annotations

import itertools
import math
import multiprocessing
import signal
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Executor, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

from rollerrig import workers
from rollerrig.blas_threads import one_blas_thread

A = TypeVar("A")
R = TypeVar("R")
Progress = Callable[[float, str], None]
Job = Callable[[A, Progress], R]

_POLL_SECONDS = 0.2

AHEAD = 4
"""Jobs per worker that are handed out before one is done: none waits for its next."""

ELSEWHERE_AHEAD = 256
"""The same of an executor whose workers are not counted here."""

GRACE_SECONDS = 3.0
"""After Ctrl-C a job has so long to hand back what it has; one that never looks up is ended."""


class WorkerError(RuntimeError):
    """A process of this machine's own ended in the middle of its job."""

    def __init__(self) -> None:
        super().__init__(
            "a worker process ended in the middle of its job: killed, or out of memory; "
            "the same command goes on with what is finished, best on fewer processes"
        )


@dataclass(frozen=True)
class Finished(Generic[R]):
    """Results of a set of jobs.

    Attributes:
        results: one per job; None where Ctrl-C came first.
        interrupted: whether Ctrl-C ended them early.
    """

    results: list[R | None]
    interrupted: bool


def run_jobs(
    function: Job[A, R],
    arguments: Sequence[A],
    *,
    processes: int = 1,
    progress: Progress | None = None,
    names: Sequence[str] | None = None,
    keep: Callable[[int, R], None] | None = None,
    executor: Executor | None = None,
) -> Finished[R]:
    """Run a function over arguments.

    Args:
        function: called with one argument and a progress function; on a top level of a module if `processes` > 1.
        arguments: one per job.
        processes: how many at a time; 1 stays in this process. More start fresh Python processes: a script that asks for
            them needs `if __name__ == "__main__":`.
        progress: called with the fraction of all jobs done and the name of the job that finished last.
        names: one per job, for the progress.
        keep: called in this process with number and result of each job as soon as it is done.
        executor: that does the jobs in place of processes of this machine; it stays open.

    Raises:
        WorkerError: a process of this machine died; what was finished has been kept.
    """
    store: Callable[[int, R], None] = keep or (lambda _number, _result: None)
    labels = list(names) if names is not None else [""] * len(arguments)
    report: Progress = progress or (lambda _fraction, _text: None)
    if executor is not None:
        crew: _Crew[R] = _Crew(executor, None)
        return _at_once(function, arguments, crew, ELSEWHERE_AHEAD, report, labels, store)
    if processes <= 1 or len(arguments) <= 1:
        return _in_turn(function, arguments, report, labels, store)
    count = min(processes, len(arguments))
    return _at_once(function, arguments, _own_crew(count, len(arguments)), AHEAD * count, report, labels, store)


def _in_turn(
    function: Job[A, R], arguments: Sequence[A], report: Progress, names: list[str], keep: Callable[[int, R], None]
) -> Finished[R]:
    results: list[R | None] = [None] * len(arguments)
    try:
        for number, argument in enumerate(arguments):

            def inner(fraction: float, _text: str, number: int = number) -> None:
                report((number + fraction) / len(arguments), names[number])

            result = function(argument, inner)
            results[number] = result
            keep(number, result)
    except KeyboardInterrupt:
        return Finished(results, True)
    return Finished(results, False)


def _own_crew(processes: int, jobs: int) -> _Crew[Any]:
    """New processes of this machine."""
    context = multiprocessing.get_context("spawn")
    stop = context.Event()
    fractions = context.Array("d", jobs)
    pool = ProcessPoolExecutor(processes, context, workers.begin, (__name__, _adopt.__name__, stop, fractions))
    return _Crew(pool, _Signals(stop, fractions))


def _at_once(
    function: Job[A, R],
    arguments: Sequence[A],
    crew: _Crew[R],
    ahead: int,
    report: Progress,
    names: list[str],
    keep: Callable[[int, R], None],
) -> Finished[R]:
    results: list[R | None] = [None] * len(arguments)
    last = names[0] if names else ""
    left = iter(range(len(arguments)))
    finished = 0
    with crew.at_work():
        while True:
            try:
                crew.lose_patience()
                if not crew.halted:
                    with _deaf_to_ctrl_c():
                        for number in itertools.islice(left, max(0, ahead - len(crew.running))):
                            crew.hand_out(function, arguments[number], number)
                if not crew.running:
                    break
                done, _ = wait(crew.running, _POLL_SECONDS, FIRST_COMPLETED)
                for future in done:
                    number = crew.running[future]
                    if crew.has_answered(future):
                        result, last = future.result(), names[number]
                        results[number] = result
                        if result is not None:  # None: Ctrl-C reached it
                            keep(number, result)
                    del crew.running[future]  # last: where Ctrl-C comes before, the result is met again
                    finished += 1
                report((finished + crew.begun()) / len(arguments), last)
            except KeyboardInterrupt:
                crew.halt()
    return Finished(results, crew.halted)


@dataclass(frozen=True)
class _Signals:
    """What this process shares with its own workers: whether they shall stop, and how far each job is."""

    stop: Any
    fractions: Any


class _Crew(Generic[R]):
    """The workers of an executor and the jobs that are not done.

    Attributes:
        running: number of each job.
        halted: whether the jobs were asked to give up.
    """

    def __init__(self, pool: Executor, signals: _Signals | None) -> None:
        self.running: dict[Future[R | None], int] = {}
        self.halted = False
        self._pool, self._signals, self._patience = pool, signals, math.inf

    def hand_out(self, function: Job[A, R], argument: A, number: int) -> None:
        """Give a job to the workers."""
        if self._signals is None:
            future = self._pool.submit(_work_elsewhere, function, argument)
        else:
            future = self._pool.submit(_work, function, argument, number)
        self.running[future] = number

    def begun(self) -> float:
        """How many jobs' worth of work is done of those that are not."""
        return 0.0 if self._signals is None else sum(self._signals.fractions[n] for n in self.running.values())

    def halt(self) -> None:
        """Ask the jobs to give up, those not begun as soon as they do: cancelled ones trouble the pool's thread."""
        if not self.halted:
            self.halted, self._patience = True, time.monotonic() + GRACE_SECONDS
        if self._signals is not None:
            self._signals.stop.set()
        else:
            for future in self.running:
                future.cancel()

    def lose_patience(self) -> None:
        """End the processes of jobs that were asked and do not answer."""
        if time.monotonic() > self._patience:
            self.kill()

    def kill(self) -> None:
        """End the processes, where they are ours."""
        if isinstance(self._pool, ProcessPoolExecutor):
            for process in list((self._pool._processes or {}).values()):
                process.kill()
        elif self.halted:  # what does not answer is left to its own machine
            self.running.clear()

    @contextmanager
    def at_work(self) -> Iterator[None]:
        """Within it jobs are handed out; after an error, Ctrl-C or the wish to end at once no process is waited for or left."""
        try:
            yield
        except BrokenProcessPool as error:
            self.halt()
            raise WorkerError from error
        except BaseException:
            self.halt()
            raise
        finally:
            try:
                if self.halted:  # also a process that has only just begun has nothing to do
                    self.kill()
                if self._signals is not None:
                    self._pool.shutdown()
            except BaseException:
                self.kill()
                raise

    def has_answered(self, future: Future[R | None]) -> bool:
        """Whether a finished job has a result or an error of its own, and was not given up."""
        if self.halted and future.cancelled():
            return False
        return not (self.halted and isinstance(future.exception(), BrokenProcessPool))


@contextmanager
def _deaf_to_ctrl_c() -> Iterator[None]:
    """Processes started meanwhile never see Ctrl-C, not even before `_adopt`; this one hears of it afterwards."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


# ---------------------------------------------------------------------------------------- inside a worker process

_stop: Any = None
_fractions: Any = None


def _adopt(stop: Any, fractions: Any) -> None:
    global _stop, _fractions
    _stop, _fractions = stop, fractions
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent hears Ctrl-C and sets `stop`


def _work(function: Job[A, R], argument: A, number: int) -> R | None:
    def progress(fraction: float, _text: str) -> None:
        _fractions[number] = fraction
        if _stop.is_set():
            raise KeyboardInterrupt

    try:
        progress(0.0, "")  # Ctrl-C may have come before the job began
        with one_blas_thread():  # there are as many workers as cores
            return function(argument, progress)
    except KeyboardInterrupt:
        return None


def _work_elsewhere(function: Job[A, R], argument: A) -> R | None:
    """A job on another machine, which hears nothing of Ctrl-C here."""
    with one_blas_thread():
        return function(argument, lambda _fraction, _text: None)
