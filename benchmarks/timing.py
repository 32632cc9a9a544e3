"""What benchmarks share: the least time of many calls, what another build gives, a table in a page."""

from __future__ import annotations

import json
import os
import resource
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

ROOT = Path(__file__).parents[1]
PERFORMANCE = ROOT / "docs/performance.md"


def best_time(function: Callable[[], object], rounds: int, least: float = 0.0) -> float:
    """Processor time of one call [s]: the best of so many batches of at least `least` seconds each."""

    def batch(number: int) -> float:
        start = time.process_time()
        for _ in range(number):
            function()
        return time.process_time() - start

    function()
    number = 1
    while least and (elapsed := batch(number)) < least / 4:
        number *= 2
    number = max(1, int(number * least / elapsed)) if least else 1
    return min(batch(number) for _ in range(rounds)) / number


def of_children() -> float:
    """Processor time of the processes that this one started and that have ended [s]."""
    return sum(resource.getrusage(resource.RUSAGE_CHILDREN)[:2])


def states_along(case: Any, step: float, count: int) -> tuple[Any, Any]:
    """The assembled model of a case, and its states after each of `count` steps of a run [s], one per row."""
    from rollerrig import _core
    from rollerrig.assembly.model import assemble
    from rollerrig.simulation.run import begin
    from rollerrig.simulation.starting_state import starting_state

    model = assemble(case)
    simulation = _core.Simulation(model.core)
    begin(simulation, model, starting_state(model))
    times, rows = np.empty(9), np.empty((9, simulation.width))  # outputs on the way, which nobody reads
    states = []
    for k in range(count):
        simulation.advance((k + 1) * step, times, rows, 0)
        states.append(simulation.state)
    return model, np.array(states)


def elsewhere(script: str, arguments: list[str], path: str) -> Any:
    """What a benchmark prints as JSON in a process of its own, with the package `rollerrig` in that folder."""
    environment = {**os.environ, "PYTHONPATH": path, "OPENBLAS_NUM_THREADS": "1"}
    done = subprocess.run(
        [sys.executable, script, *arguments], env=environment, check=True, capture_output=True, text=True
    )
    return json.loads(done.stdout.splitlines()[-1])


def write_between(name: str, text: str, page: Path = PERFORMANCE) -> None:
    """Put a text between the marks of that name in a page."""
    begin, end = f"<!-- {name}: begin -->", f"<!-- {name}: end -->"
    whole = page.read_text(encoding="utf-8")
    page.write_text(f"{whole.split(begin)[0]}{begin}\n\n{text}\n\n{end}{whole.split(end)[1]}", encoding="utf-8")
