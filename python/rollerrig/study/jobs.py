"""The jobs of a study: runs of which each is kept as soon as it is finished.

rounds of jobs -> [run_rounds] -> results by name; with a journal also after kill -9

Later rounds may depend on the results of earlier ones: a study yields a round at a time and finds its results in `done`.
"""

from __future__ import annotations

import inspect
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
from typing import Any

import xarray as xr

from rollerrig.analysis import stability
from rollerrig.analysis.parallel import run_jobs
from rollerrig.config import Case
from rollerrig.simulation import simulate
from rollerrig.study.journal import Journal

Progress = Callable[[float, str], None]
Done = dict[str, Any]
"""Name of a job -> its result."""


@dataclass(frozen=True)
class Job:
    """A call to be made on any process.

    Attributes:
        function: on the top level of a module; it gets `progress` if it has such a parameter.
        arguments: all its other arguments.
    """

    function: Callable[..., Any]
    arguments: tuple[Any, ...]


def job(function: Callable[..., Any], *arguments: Any) -> Job:
    """A Job from a call."""
    return Job(function, arguments)


Round = Mapping[str, Job]


def whole_run(case: Case, progress: Progress | None = None) -> xr.Dataset:
    """A run that Ctrl-C did not cut short.

    Raises:
        KeyboardInterrupt: it did.
    """
    run = simulate(case, progress=progress)
    if is_partial(run):
        raise KeyboardInterrupt
    return run


def whole_modes(case: Case, speeds_kmh: Sequence[float], progress: Progress | None = None) -> xr.Dataset:
    """Modes over speed [km/h] that Ctrl-C did not cut short.

    Raises:
        KeyboardInterrupt: it did.
    """
    modes = stability(case, speeds_kmh, progress=progress)
    if modes.attrs["interrupted"]:
        raise KeyboardInterrupt
    return modes


def is_partial(result: Any) -> bool:
    """Whether Ctrl-C cut a job short that hands back what it has."""
    attributes = getattr(result, "attrs", {})
    flag = attributes.get("interrupted", getattr(result, "interrupted", False))
    return attributes.get("status") == "interrupted" or bool(flag)


def call(work: Job, progress: Progress) -> Any:
    """Do a job."""
    takes_progress = "progress" in inspect.signature(work.function).parameters
    return work.function(*work.arguments, **({"progress": progress} if takes_progress else {}))


def run_rounds(
    rounds: Callable[[Done], Iterator[Round]],
    journal: Journal | None,
    round_ends: Sequence[float],
    processes: int,
    progress: Progress | None,
    *,
    told: Callable[[Done, float], str] | None = None,
    executor: Executor | None = None,
) -> tuple[Done, bool]:
    """Do all rounds of jobs; jobs that the journal has are not done again.

    Args:
        rounds: called with the results so far, which grow while it is iterated.
        journal: of finished jobs; None: nothing is kept.
        round_ends: fraction of the whole at the end of each of the first rounds; each further one takes half of the rest.
        processes: jobs at a time.
        progress: called with the fraction done and a short text.
        told: what the progress says of the results so far, after so long [s]; '': the name of the last job.
        executor: that does the jobs in place of processes of this machine.

    Returns:
        Results by name, in the order of the jobs, and whether Ctrl-C ended it early.
    """
    begun = time.monotonic()
    done: Done = {} if journal is None else dict(journal.done)
    begin = 0.0

    def report(fraction: float, text: str) -> None:
        if progress is not None:
            progress(fraction, (told(done, time.monotonic() - begun) if told else "") or text)

    try:
        for count, jobs in enumerate(rounds(done)):
            end = round_ends[count] if count < len(round_ends) else begin + 0.5 * (1.0 - begin)
            wanted = {name: work for name, work in jobs.items() if name not in done}
            stopped = _run_round(wanted, done, journal, processes, _part(report, begin, end), executor)
            done.update({name: done.pop(name) for name in jobs if name in done})  # as named, not as they ended
            if stopped:
                return done, True
            report(end, "")
            begin = end
    except KeyboardInterrupt:  # between two jobs
        return done, True
    return done, False


def _run_round(
    jobs: Round, done: Done, journal: Journal | None, processes: int, report: Progress, executor: Executor | None
) -> bool:
    """One round; True where Ctrl-C ended it."""
    if not jobs:
        return False
    names = list(jobs)

    def keep(number: int, result: Any) -> None:
        name = names[number]
        if name in done:  # one that Ctrl-C brings here again is kept already
            return
        if journal is not None and not is_partial(result):
            journal.add(name, result)
        done[name] = result
        if is_partial(result):
            raise KeyboardInterrupt

    finished = run_jobs(
        call, list(jobs.values()), processes=processes, progress=report, names=names, keep=keep, executor=executor
    )
    return finished.interrupted or any(is_partial(done.get(name)) for name in names)


def _part(report: Progress, begin: float, end: float) -> Progress:
    return lambda fraction, text: report(begin + (end - begin) * fraction, text)
