"""Variants: named changes of a case, each run from several starting points, and numbers measured of every run.

name -> Case, starting points -> [start_jobs] -> jobs -> [started] -> results by name -> [means] -> means with errors
"""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from rollerrig.config import Case
from rollerrig.study.ensemble import estimate, starts
from rollerrig.study.jobs import Done, Job, Round

Starting = Callable[[Case, int], Sequence[Case]]
"""Case, number -> so many cases that differ in their start alone, the case itself first."""


def start_name(name: str, number: int) -> str:
    """Name of the job of a variant from one of its starts, counted from 0."""
    return f"{name}, start {number + 1}"


def start_jobs(
    cases: Mapping[str, Case],
    make: Callable[[Case, int], Job],
    end: int,
    begin: int = 0,
    starting: Starting = starts,
) -> Round:
    """A job for each variant and start, made of its case and number; `begin` of the `end` starts are done already."""
    return {
        start_name(name, k): make(one, k)
        for name, case in cases.items()
        for k, one in enumerate(starting(case, end))
        if k >= begin
    }


def started(done: Done, name: str, first: Sequence[Any] = ()) -> list[Any]:
    """What there is of a variant after its `first` starts, which other jobs had, up to the first one that is missing."""
    found = list(first)
    while (job := done.get(start_name(name, len(found)))) is not None:
        found.append(job)
    return found


def means(runs: Sequence[Mapping[str, float]], names: Sequence[str]) -> dict[str, float]:
    """Mean of each of these numbers over the runs of a variant, and its standard error as `NAME_standard_error`."""
    found: dict[str, float] = {}
    for name in names:
        one = estimate([run[name] for run in runs])
        found |= {name: one.mean, f"{name}_standard_error": one.standard_error}
    return found
