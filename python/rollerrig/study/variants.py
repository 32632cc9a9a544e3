"""Variants: named changes of a case, each run from several starting points, and numbers measured of every run.

name -> Case, starting points -> [start_jobs] -> jobs -> [started] -> results by name -> [means] -> Dataset with errors
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr

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
    """A job for each variant and start.

    Args:
        cases: by name of the variant.
        make: case and number of its start -> the job.
        end: number of starts.
        begin: of them those that are done already.
        starting: how starts differ; by default by [ensemble].
    """
    return {
        start_name(name, k): make(one, k)
        for name, case in cases.items()
        for k, one in enumerate(starting(case, end))
        if k >= begin
    }


def started(done: Done, name: str, first: Sequence[Any] = ()) -> list[Any]:
    """What there is of a variant, in the order of its starts, up to the first one that is missing.

    Args:
        done: results by name of the job.
        name: of the variant.
        first: results of its first starts that other jobs had.
    """
    found = list(first)
    while (job := done.get(start_name(name, len(found)))) is not None:
        found.append(job)
    return found


def means(found: Mapping[str, Sequence[Mapping[str, float]]], names: Sequence[str]) -> xr.Dataset:
    """Numbers of ensembles.

    Args:
        found: variant -> numbers of each of its runs.
        names: of the numbers.

    Returns:
        Dataset over `variant` with each number's mean, and its standard error as `NAME_standard_error`.
    """
    estimates = {n: [estimate([one[n] for one in runs]) for runs in found.values()] for n in names}
    ends = (("", "mean"), ("_standard_error", "standard_error"))
    variables = {
        f"{name}{end}": ("variant", np.array([getattr(one, kind) for one in estimates[name]]))
        for name, (end, kind) in itertools.product(names, ends)
    }
    return xr.Dataset(variables, {"variant": list(found)})
