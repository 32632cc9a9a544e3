"""Independent jobs on a few processes, with progress and Ctrl-C.

    function, one argument per job -> [run_jobs] -> one result per job, None for those that Ctrl-C cut off

A job is called as `function(argument, progress)` and shall call `progress(fraction, text)` now and then: that is also where
Ctrl-C reaches it, as a KeyboardInterrupt.
"""

from __future__ import annotations

import multiprocessing
import signal
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

from rollerrig.analysis.workers import end_with_parent
from rollerrig.blas_threads import one_blas_thread

A = TypeVar("A")
R = TypeVar("R")
Progress = Callable[[float, str], None]
Job = Callable[[A, Progress], R]

_POLL_SECONDS = 0.2


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
    """
    store: Callable[[int, R], None] = keep or (lambda _number, _result: None)
    labels = list(names) if names is not None else [""] * len(arguments)
    report: Progress = progress or (lambda _fraction, _text: None)
    if processes <= 1 or len(arguments) <= 1:
        return _in_turn(function, arguments, report, labels, store)
    return _at_once(function, arguments, min(processes, len(arguments)), report, labels, store)


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


def _at_once(
    function: Job[A, R],
    arguments: Sequence[A],
    processes: int,
    report: Progress,
    names: list[str],
    keep: Callable[[int, R], None],
) -> Finished[R]:
    context = multiprocessing.get_context("spawn")
    stop = context.Event()
    fractions = context.Array("d", len(arguments))
    results: list[R | None] = [None] * len(arguments)
    interrupted = False
    last = names[0]
    with ProcessPoolExecutor(processes, context, _adopt, (stop, fractions)) as pool:
        running: dict[Future[R | None], int] = {}

        def halt() -> None:
            stop.set()
            for future in running:
                future.cancel()

        try:
            with _deaf_to_ctrl_c():
                for number, argument in enumerate(arguments):
                    running[pool.submit(_work, function, argument, number)] = number
        except KeyboardInterrupt:
            interrupted = True
            halt()
        while running:
            try:
                done, _ = wait(running, _POLL_SECONDS, FIRST_COMPLETED)
                for future in done:
                    number = running[future]
                    if not future.cancelled():
                        result, last = future.result(), names[number]
                        results[number], fractions[number] = result, 1.0
                        if result is not None:  # None: Ctrl-C reached it
                            keep(number, result)
                    del running[future]  # last: where Ctrl-C comes before, the result is met again
                report(sum(fractions[:]) / len(arguments), last)
            except KeyboardInterrupt:
                interrupted = True
                halt()
            except BaseException:
                halt()  # the others shall not run on before the error is told
                raise
    return Finished(results, interrupted)


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
    end_with_parent()
    _stop, _fractions = stop, fractions
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent hears Ctrl-C and sets `stop`


def _work(function: Job[A, R], argument: A, number: int) -> R | None:
    def progress(fraction: float, _text: str) -> None:
        _fractions[number] = fraction
        if _stop.is_set():
            raise KeyboardInterrupt

    try:
        with one_blas_thread():  # there are as many workers as cores
            return function(argument, progress)
    except KeyboardInterrupt:
        return None
