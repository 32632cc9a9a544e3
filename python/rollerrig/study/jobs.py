"""The jobs of a study: runs of which each is kept as soon as it is finished.

rounds of jobs -> [run_rounds] -> results by name; with a journal also after kill -9

Later rounds may depend on the results of earlier ones: a study yields a round at a time and finds its results in `done`. Within a
round, jobs that each need the one before them are a chain; chains go on side by side.
"""

from __future__ import annotations

import inspect
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import xarray as xr

from rollerrig.analysis import stability
from rollerrig.analysis.parallel import run_jobs
from rollerrig.config import Case
from rollerrig.results import output_folder
from rollerrig.simulation.run import simulate
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
        lost: called with `arguments` for the result where the job ends its process again and again; None: that is an error.
    """

    function: Callable[..., Any]
    arguments: tuple[Any, ...]
    lost: Callable[..., Any] | None = None


def job(function: Callable[..., Any], *arguments: Any) -> Job:
    """A Job from a call."""
    return Job(function, arguments)


Round = Mapping[str, Job]
Chain = Callable[[Done], tuple[str, Job] | None]
"""Results so far -> name of the next job of a chain and the job; None: it is at its end."""


@dataclass(frozen=True)
class Chains:
    """Jobs of which each needs the results of those before it, in several chains side by side.

    Attributes:
        chains: asked for their next job after each of their own.
        expected: jobs that there will be, more or less; for the progress.
    """

    chains: tuple[Chain, ...]
    expected: int


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
    rounds: Callable[[Done], Iterator[Round | Chains]],
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
            work = _ChainRound(jobs) if isinstance(jobs, Chains) else _Round(jobs)
            stopped = _run_round(work, done, journal, processes, _part(report, begin, end), executor)
            done.update(
                {name: done.pop(name) for name in work.names(done) if name in done}
            )  # as named, not as they ended
            if stopped:
                return done, True
            report(end, "")
            begin = end
    except KeyboardInterrupt:  # between two jobs
        return done, True
    return done, False


class _Round:
    """Jobs that need nothing of each other."""

    expected = 0

    def __init__(self, jobs: Round) -> None:
        self._jobs = jobs

    def first(self, done: Done) -> Round:
        """The jobs to begin with."""
        return {name: work for name, work in self._jobs.items() if name not in done}

    def following(self, _name: str, _done: Done) -> tuple[str, Job] | None:
        """The job that follows one."""
        return None

    def names(self, _done: Done) -> list[str]:
        """All of its jobs so far, in their order."""
        return list(self._jobs)


class _ChainRound(_Round):
    """Chains of jobs."""

    def __init__(self, chains: Chains) -> None:
        self.expected, self._chains = chains.expected, chains.chains
        self._chain_of: dict[str, Chain] = {}

    def first(self, done: Done) -> Round:
        found: dict[str, Job] = {}
        for chain in self._chains:
            if (following := chain(done)) is not None:
                found |= dict([following])
                self._chain_of[following[0]] = chain
        self.expected -= len(done.keys() & set(self.names(done)))
        return found

    def following(self, name: str, done: Done) -> tuple[str, Job] | None:
        chain = self._chain_of.pop(name, None)  # Ctrl-C may bring a result here again
        following = None if chain is None else chain(done)
        if chain is not None and following is not None:
            self._chain_of[following[0]] = chain
        return following

    def names(self, done: Done) -> list[str]:
        """Those of one chain after the other, each from its begin."""
        found: Done = {}
        for chain in self._chains:
            past: Done = {}
            while (following := chain(past)) is not None and following[0] in done:
                past[following[0]] = done[following[0]]
            found |= past
        return list(found)


def _run_round(
    work: _Round, done: Done, journal: Journal | None, processes: int, report: Progress, executor: Executor | None
) -> bool:
    """One round; True where Ctrl-C ended it."""
    jobs = work.first(done)
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

    def following(number: int) -> tuple[str, Job] | None:
        found = work.following(names[number], done)
        if found is not None:
            names.append(found[0])
        return found

    finished = run_jobs(
        call, list(jobs.values()), processes=processes, progress=report, names=list(names), keep=keep,
        following=following, expected=work.expected, lost=_lost, executor=executor,
    )  # fmt: skip
    return finished.interrupted or any(is_partial(done.get(name)) for name in names)


def _lost(work: Job) -> Any:
    """The result of a job that ends its process again and again; None: there is none."""
    return None if work.lost is None else work.lost(*work.arguments)


def _part(report: Progress, begin: float, end: float) -> Progress:
    return lambda fraction, text: report(begin + (end - begin) * fraction, text)


FIRST_ROUND = 0.75
"""Fraction of the whole at which the first of several rounds ends."""


def kept_rounds(
    rounds: Callable[[Done], Iterator[Round | Chains]],
    folder: str | Path | None,
    what: str,
    plan: Mapping[str, Any],
    processes: int,
    progress: Progress | None,
) -> tuple[Done, bool]:
    """Do all rounds of jobs, those that the folder has not again.

    Args:
        rounds: called with the results so far.
        folder: made if need be; None: nothing is kept.
        what: is computed, as messages call it.
        plan: all that decides the results, as JSON takes it.
        processes: jobs at a time.
        progress: called with the fraction done and a short text.

    Returns:
        Results by name, and whether Ctrl-C ended it early.

    Raises:
        ConfigError: the folder has the jobs of another plan.
        OutputError: the folder takes no files.
    """
    if folder is None:
        return run_rounds(rounds, None, (FIRST_ROUND,), processes, progress)
    with Journal(output_folder(folder), what, plan) as journal:
        return run_rounds(rounds, journal, (FIRST_ROUND,), processes, progress)
