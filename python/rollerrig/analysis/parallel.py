"""Independent jobs on a few processes, or on an executor that leads elsewhere, with progress and Ctrl-C.

    function, one argument per job -> [run_jobs] -> one result per job, None for those that Ctrl-C cut off

A job is called as `function(argument, progress)` and shall call `progress(fraction, text)` now and then: that is also where
Ctrl-C reaches it, as a KeyboardInterrupt. A finished job may bring the one that follows it. Only a few jobs per worker are handed
out ahead, so that the bookkeeping of a job does not grow with their number.
"""

from __future__ import annotations

import signal
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Executor, wait
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Generic, TypeVar

from rollerrig.analysis.crew import Crew, Job, OwnCrew, Progress, WorkerError

A = TypeVar("A")
R = TypeVar("R")

_POLL_SECONDS = 0.2


@dataclass(frozen=True)
class Finished(Generic[R]):
    """Results of a set of jobs.

    Attributes:
        results: one per job, of those that followed others last; None where Ctrl-C came first.
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
    following: Callable[[int], tuple[str, A] | None] | None = None,
    expected: int = 0,
    lost: Callable[[A], R | None] | None = None,
    executor: Executor | None = None,
) -> Finished[R]:
    """Run a function over arguments.

    A job whose process died is done once more, on a new one and alone; `lost` is asked where it dies again.

    Args:
        function: called with one argument and a progress function; on a top level of a module if `processes` > 1.
        arguments: one per job.
        processes: how many at a time; 1 stays in this process. More start fresh Python processes: a script that asks for
            them needs `if __name__ == "__main__":`.
        progress: called with the fraction of all jobs done and the name of the job that finished last.
        names: one per job, for the progress.
        keep: called in this process with number and result of each job as soon as it is done.
        following: number of a job that `keep` has had -> name and argument of the one that follows it, if any.
        expected: jobs that there will be, with those that follow; for the progress.
        lost: argument of a job whose process died twice -> its result; None: the jobs end with a WorkerError.
        executor: that does the jobs in place of processes of this machine; it stays open.

    Raises:
        WorkerError: a process of this machine died, also when its job was done again; what was finished has been kept.
    """
    work: _Work[A, R] = _Work(list(arguments), list(names) if names is not None else [""] * len(arguments))
    work.keep, work.following, work.lost = keep or work.keep, following or work.following, lost or work.lost
    work.report, work.expected = progress or work.report, expected
    if executor is not None:
        crew: Crew[R] = Crew(executor)
        return _at_once(function, work, crew)
    count = min(processes, len(arguments))
    return _in_turn(function, work) if count <= 1 else _at_once(function, work, OwnCrew(count))


class _Work(Generic[A, R]):
    """The jobs: what they are called with, which wait, and what came of them."""

    def __init__(self, arguments: list[A], names: list[str]) -> None:
        self.arguments, self.names = arguments, names
        self.results: list[R | None] = [None] * len(arguments)
        self.waiting = deque(range(len(arguments)))
        self.expected = 0
        self.report: Progress = lambda _fraction, _text: None
        self.keep: Callable[[int, R], None] = lambda _number, _result: None
        self.following: Callable[[int], tuple[str, A] | None] = lambda _number: None
        self.lost: Callable[[A], R | None] = lambda _argument: None
        self._finished, self._last = 0, names[0] if names else ""

    def answered(self, number: int, result: R | None) -> None:
        """Take the result of a job; None: Ctrl-C reached it."""
        if result is not None:
            self._last, self.results[number] = self.names[number], result
            self.keep(number, result)
            after = self.following(number)
            if after is not None:
                self.names.append(after[0])
                self.arguments.append(after[1])
                self.results.append(None)
                self.waiting.append(len(self.results) - 1)
        self._finished += 1

    def given_up(self, number: int) -> None:
        """Take it that a job ended its process twice.

        Raises:
            WorkerError: no result says so.
        """
        result = self.lost(self.arguments[number])
        if result is None:
            raise WorkerError(self.names[number])
        self.answered(number, result)

    def told(self, begun: float, name: str = "") -> None:
        """Report, where so many jobs' worth is done of those at work."""
        total = max(self.expected, len(self.arguments))
        self.report(min(1.0, (self._finished + begun) / total) if total else 1.0, name or self._last)


def _in_turn(function: Job[A, R], work: _Work[A, R]) -> Finished[R]:
    try:
        while work.waiting:
            current = work.waiting.popleft()

            def inner(fraction: float, _text: str, name: str = work.names[current]) -> None:
                work.told(fraction, name)

            work.answered(current, function(work.arguments[current], inner))
    except KeyboardInterrupt:
        return Finished(work.results, True)
    return Finished(work.results, False)


def _at_once(function: Job[A, R], work: _Work[A, R], crew: Crew[R]) -> Finished[R]:
    with crew.at_work():
        while True:
            try:
                crew.lose_patience()
                if not crew.halted:
                    _hand_out(function, work, crew)
                if crew.is_idle:
                    break
                done, _ = wait(crew.running, _POLL_SECONDS, FIRST_COMPLETED)
                for future in done:
                    if crew.has_answered(future):
                        work.answered(crew.running[future], future.result())
                    crew.is_done(future)  # last: where Ctrl-C comes before, the result is met again
                work.told(crew.begun())
            except KeyboardInterrupt:
                crew.halt()
    return Finished(work.results, crew.halted)


def _hand_out(function: Job[A, R], work: _Work[A, R], crew: Crew[R]) -> None:
    """Give the workers what they have room for; of a worker that died, first see to the jobs it left."""
    for number in crew.recovered(work.waiting):
        work.given_up(number)
    with _deaf_to_ctrl_c():
        while (ready := crew.next(work.waiting)) is not None:
            crew.hand_out(function, work.arguments[ready], ready)


@contextmanager
def _deaf_to_ctrl_c() -> Iterator[None]:
    """Processes started meanwhile never see Ctrl-C, not even before they adopt it; this one hears of it afterwards."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
