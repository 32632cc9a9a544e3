"""The jobs of a study: runs of which each is kept as soon as it is finished.

rounds of jobs -> [run_rounds] -> results by name; with a checkpoint also after kill -9

Later rounds may depend on the results of earlier ones: a study yields a round at a time and finds its results in `done`. Within a
round, jobs that need others before them are a chain; several chains run side by side, and none waits for another.
"""

import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Executor
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

import xarray as xr

from rollerrig.analysis.mode_table import stability
from rollerrig.config import Case
from rollerrig.simulation.run import Progress as Progress
from rollerrig.simulation.run import simulate
from rollerrig.simulation.starting_state import StartError
from rollerrig.study.checkpoint import Checkpoint
from rollerrig.study.workers import Job as Job
from rollerrig.study.workers import run_jobs

Done = dict[str, Any]
"""Name of a job -> its result."""
Round = Mapping[str, Job]
Chain = Callable[[Done], Round]
"""Results so far -> the next jobs of a chain, also those at work, whichever of them end first; none: it is at its end."""


def job(function: Callable[..., Any], *arguments: Any) -> Job:
    """A Job from a call."""
    return Job(function, arguments)


@dataclass(frozen=True)
class Chains:
    """Jobs that need the results of those before them, in several chains side by side.

    Attributes:
        chains: asked for their next jobs after each job.
        expected: jobs that there will be, more or less; for the progress.
    """

    chains: tuple[Chain, ...]
    expected: int


def whole_run(case: Case, progress: Progress | None = None) -> xr.Dataset:
    """A run that Ctrl-C did not cut short.

    Raises:
        KeyboardInterrupt: it did.
        StartError: the run has no sample, as where a controller fails at its first: nothing can be read off it.
    """
    run = simulate(case, progress=progress)
    if is_partial(run):
        raise KeyboardInterrupt
    if not run.sizes["time"]:
        raise StartError(f"{case.name}: {run.attrs['status_message']}")
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
    """Whether Ctrl-C cut a job short that returns what it has."""
    attributes = getattr(result, "attrs", {})
    flag = attributes.get("interrupted", getattr(result, "interrupted", False))
    return attributes.get("status") == "interrupted" or bool(flag)


def run_rounds(
    rounds: Callable[[Done], Iterator[Round | Chains]],
    checkpoint: Checkpoint | None,
    round_ends: Sequence[float],
    processes: int,
    progress: Progress | None,
    *,
    progress_text: Callable[[Done, float], str] | None = None,
    executor: Executor | None = None,
    so_far: Callable[[Callable[[], Done]], None] = lambda _done: None,
) -> tuple[Done, bool]:
    """Do all rounds of jobs; jobs that the checkpoint has are not done again.

    Args:
        rounds: called with the results so far, which grow while it is iterated.
        checkpoint: of finished jobs; None: nothing is kept.
        round_ends: fraction of the whole at the end of each of the first rounds; each further one takes half of the rest.
        processes: jobs at a time.
        progress: called with the fraction done and a short text.
        progress_text: results so far, and seconds since the begin -> text of the progress; '': the name of the last job.
        executor: that does the jobs in place of processes of this machine.
        so_far: called after each job but the last one known, and between two rounds, with what gives the results so far.

    Returns:
        Results by name, in the order of the jobs, and whether Ctrl-C ended it early.
    """
    begun = time.monotonic()
    done: Done = {} if checkpoint is None else dict(checkpoint.done)
    begin = end = 0.0

    def report(fraction: float, text: str) -> None:
        if progress is not None:
            own = progress_text(done, time.monotonic() - begun) if progress_text else ""
            progress(begin + (end - begin) * fraction, own or text)

    try:
        for count, jobs in enumerate(rounds(done)):
            if count and jobs:
                so_far(done.copy)
            end = round_ends[count] if count < len(round_ends) else begin + 0.5 * (1.0 - begin)
            if _run_round(jobs, done, checkpoint, report, processes, executor, so_far):
                return done, True
            begin = end
    except KeyboardInterrupt:  # between two jobs
        return done, True
    begin = end = 1.0
    with suppress(KeyboardInterrupt):  # all is done
        report(1.0, "")
    return done, False


def _run_round(
    work: Round | Chains,
    done: Done,
    checkpoint: Checkpoint | None,
    report: Progress,
    processes: int,
    executor: Executor | None,
    so_far: Callable[[Callable[[], Done]], None],
) -> bool:
    """Do one round; whether Ctrl-C ended it early."""
    chains = work.chains if isinstance(work, Chains) else ()
    started, finished = set[str](), 0

    def following() -> dict[str, Job]:
        """Next jobs of the chains that are neither done nor at work."""
        found = [one for chain in chains for one in chain(done).items()]
        new = {name: one for name, one in found if name not in started and name not in done}
        started.update(new)
        return new

    def keep(name: str, result: Any) -> dict[str, Job]:
        nonlocal finished
        if checkpoint is not None and not is_partial(result):
            checkpoint.add(name, result)
        done[name] = result
        finished += 1
        more = following()
        if finished < max(expected, len(started)):
            so_far(in_order)
        return more

    def in_order() -> Done:
        named = {name: done[name] for name in _names(work, done) if name in done}  # as named, not as they ended
        return {name: one for name, one in done.items() if name not in named} | named

    if isinstance(work, Chains):
        expected = work.expected - len(done.keys() & set(_names(work, done)))
        jobs = following()
    else:
        jobs = {name: one for name, one in work.items() if name not in done}
        expected = len(jobs)

    def report_part(count: float, name: str) -> None:
        report(min(1.0, count / max(expected, len(started))), name)

    stopped = bool(jobs) and run_jobs(jobs, keep, report_part, processes=processes, executor=executor)
    ordered = in_order()
    done.clear()
    done.update(ordered)
    return stopped


def _names(work: Round | Chains, done: Done) -> list[str]:
    """All jobs of a round so far: of chains those of one after the other, each from its begin."""
    if not isinstance(work, Chains):
        return list(work)
    found: Done = {}
    for chain in work.chains:
        past: Done = {}
        while more := {name: done[name] for name in chain(past) if name in done and name not in past}:
            past |= more
        found |= past
    return list(found)
