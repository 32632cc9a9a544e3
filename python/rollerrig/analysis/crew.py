"""The workers of an executor and the jobs that they are at: handing out, Ctrl-C, and workers that die.

number of a job -> Future; numbers of jobs that ended their process twice

A process that is killed or runs out of memory takes the other ones of its pool with it. Those that were at work then are all
suspect: new processes do them again, one alone at a time, so that the one which does it a second time is the one.
"""

from __future__ import annotations

import math
import multiprocessing
import signal
import time
from collections import deque
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

from rollerrig.common import workers
from rollerrig.common.linear_algebra import one_blas_thread

A = TypeVar("A")
R = TypeVar("R")
Progress = Callable[[float, str], None]
Job = Callable[[A, Progress], R]

AHEAD = 4
"""Jobs per worker that are handed out before one is done: none waits for its next."""

ELSEWHERE_AHEAD = 256
"""The same of an executor whose workers are not counted here."""

GRACE_SECONDS = 3.0
"""After Ctrl-C a job has so long to hand back what it has; one that never looks up is ended."""

WAITING = -1.0
"""In place of the fraction done: the job has not begun."""

_MOST_BARREN = 1
"""So often in a row processes may end before any has begun a job: more is no accident."""


class WorkerError(RuntimeError):
    """A process of this machine's own ended in the middle of a job, also where the job was done once more."""

    def __init__(self, name: str = "") -> None:
        super().__init__(
            f"a worker process ended in the middle of its job{f', {name}' if name else ''}: killed, or out of memory; "
            "the same command goes on with what is finished, best on fewer processes"
        )


class Crew(Generic[R]):
    """The workers of an executor elsewhere and the jobs that are not done.

    Attributes:
        running: number of each job.
        halted: whether the jobs were asked to give up.
    """

    def __init__(self, pool: Executor, ahead: int = ELSEWHERE_AHEAD) -> None:
        self.running: dict[Future[R | None], int] = {}
        self.halted = False
        self._pool, self._ahead, self._patience = pool, ahead, math.inf
        self._given_up: list[int] = []

    @property
    def is_idle(self) -> bool:
        """Whether nothing is at work, and nothing is to be done again or to be reported."""
        return not self.running and (self.halted or not self._given_up)

    def recovered(self, _waiting: deque[int]) -> list[int]:
        """Put jobs of workers that died back among those that wait; numbers of those that are given up."""
        given_up, self._given_up = self._given_up, []
        return given_up

    def next(self, waiting: deque[int]) -> int | None:
        """Number of the job to be handed out now; None: there is none, or no room."""
        return waiting.popleft() if waiting and len(self.running) < self._ahead else None

    def hand_out(self, function: Job[A, R], argument: A, number: int) -> None:
        """Give a job to the workers."""
        self.running[self._pool.submit(_work_elsewhere, function, argument)] = number

    def begun(self) -> float:
        """How many jobs' worth of work is done of those that are not."""
        return 0.0

    def has_answered(self, future: Future[R | None]) -> bool:
        """Whether a finished job has a result or an error of its own, and was not given up."""
        if self.halted and future.cancelled():
            return False
        if type(future.exception()).__name__ == "KilledWorker":  # of dask, which need not be installed
            self._given_up.append(self.running[future])  # its scheduler has tried it on several workers
            return False
        return True

    def is_done(self, future: Future[R | None]) -> None:
        """Take a job off the list."""
        del self.running[future]

    def halt(self) -> None:
        """Ask the jobs to give up."""
        self._lose_patience_later()
        for future in self.running:
            future.cancel()

    def _lose_patience_later(self) -> None:
        if not self.halted:
            self.halted, self._patience = True, time.monotonic() + GRACE_SECONDS

    def lose_patience(self) -> None:
        """End jobs that were asked and do not answer."""
        if time.monotonic() > self._patience:
            self.kill()

    def kill(self) -> None:
        """Wait for nobody: what does not answer is left to its own machine."""
        if self.halted:
            self.running.clear()

    def close(self) -> None:
        """Let go of the workers."""

    @contextmanager
    def at_work(self) -> Iterator[None]:
        """Within it jobs are handed out; after an error, Ctrl-C or the wish to end at once no process is waited for or left."""
        try:
            yield
        except BaseException:
            self.halt()
            raise
        finally:
            try:
                if self.halted:  # also a process that has only just begun has nothing to do
                    self.kill()
                self.close()
            except BaseException:
                self.kill()
                raise


@dataclass(frozen=True)
class _Signals:
    """What this process shares with its own workers: whether they shall stop, and how far the job in each slot is.

    Both without a lock: a worker that dies with one in its hands would take it along.
    """

    stop: Any
    fractions: Any


class OwnCrew(Crew[R]):
    """New processes of this machine."""

    def __init__(self, processes: int) -> None:
        self._processes, self._context = processes, multiprocessing.get_context("spawn")
        super().__init__(self._begin(), AHEAD * processes)
        self._slots: dict[Future[R | None], int] = {}
        self._lost: dict[int, bool] = {}  # number of a job that lost its process -> whether it had begun
        self._suspects: deque[int] = deque()
        self._died: set[int] = set()
        self._alone, self._is_broken, self._barren = False, False, 0

    def _begin(self) -> Executor:
        slots = AHEAD * self._processes
        self._signals = _Signals(self._context.RawValue("b", 0), self._context.RawArray("d", slots))
        self._free = list(range(slots))
        start = (__name__, _adopt.__name__, self._signals.stop, self._signals.fractions)
        return ProcessPoolExecutor(self._processes, self._context, workers.begin, start)

    @property
    def is_idle(self) -> bool:
        """Whether nothing is at work, and no lost job is to be done again."""
        return not self.running and (self.halted or not self._is_broken)

    def recovered(self, waiting: deque[int]) -> list[int]:
        """New processes where one died; the jobs it took along wait again, those at work alone; numbers of those given up.

        Raises:
            WorkerError: the processes die before they begin a job.
        """
        if not self._is_broken or self.running:
            return []
        begun = [number for number, had_begun in self._lost.items() if had_begun]
        self._barren = 0 if begun else self._barren + 1
        if self._barren > _MOST_BARREN:
            raise WorkerError
        given_up = [number for number in begun if number in self._died]
        self._died.update(begun)
        left = sorted(self._lost.keys() - set(given_up))
        self._suspects.extend(number for number in left if number in self._died)
        waiting.extendleft(reversed([number for number in left if number not in self._died]))
        self._lost, self._is_broken, self._alone = {}, False, False
        self._pool.shutdown()
        self._pool = self._begin()
        return given_up

    def next(self, waiting: deque[int]) -> int | None:
        """Number of the job to be handed out now; a suspect goes alone."""
        if self._is_broken or self._alone:
            return None
        if not self._suspects:
            return super().next(waiting)
        if self.running:
            return None
        self._alone = True
        return self._suspects.popleft()

    def hand_out(self, function: Job[A, R], argument: A, number: int) -> None:
        """Give a job to the workers."""
        slot = self._free.pop()
        self._signals.fractions[slot] = WAITING
        try:
            future = self._pool.submit(_work, function, argument, slot)
        except BrokenProcessPool:
            self._is_broken, self._lost[number] = True, False
            return
        self.running[future], self._slots[future] = number, slot

    def begun(self) -> float:
        """How many jobs' worth of work is done of those that are not."""
        return sum(max(0.0, float(self._signals.fractions[slot])) for slot in self._slots.values())

    def has_answered(self, future: Future[R | None]) -> bool:
        """Whether a job has a result or an error of its own; one that lost its process has none."""
        if not super().has_answered(future):
            return False
        if not isinstance(future.exception(), BrokenProcessPool):
            return True
        if not self.halted:
            self._is_broken = True
            self._lost[self.running[future]] = self._signals.fractions[self._slots[future]] > WAITING
        return False

    def is_done(self, future: Future[R | None]) -> None:
        """Take a job off the list."""
        super().is_done(future)
        self._free.append(self._slots.pop(future))
        self._alone = False

    def halt(self) -> None:
        """Ask the jobs to give up, those not begun as soon as they do: cancelled ones trouble the pool's thread."""
        self._lose_patience_later()
        self._signals.stop.value = 1

    def kill(self) -> None:
        """End the processes."""
        for process in list((getattr(self._pool, "_processes", None) or {}).values()):
            process.kill()

    def close(self) -> None:
        """Wait for the ends of the processes."""
        self._pool.shutdown()


# ---------------------------------------------------------------------------------------- inside a worker process

_stop: Any = None
_fractions: Any = None


def _adopt(stop: Any, fractions: Any) -> None:
    global _stop, _fractions
    _stop, _fractions = stop, fractions
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent hears Ctrl-C and sets `stop`


def _work(function: Job[A, R], argument: A, slot: int) -> R | None:
    def progress(fraction: float, _text: str) -> None:
        _fractions[slot] = fraction
        if _stop.value:
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
