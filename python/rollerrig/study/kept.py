"""Runs of a function of the library, kept in a folder as those of a study are.

rounds of jobs, folder -> [kept_rounds] -> results by name
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

from rollerrig.results import output_folder
from rollerrig.study.jobs import Chains, Done, Progress, Round, run_rounds
from rollerrig.study.journal import Journal

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
