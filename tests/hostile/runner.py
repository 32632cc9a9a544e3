"""Throws many inputs of one kind at processes of their own and counts what they end in."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from collections import Counter
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path

KINDS = (
    "border",
    "config",
    "profile",
    "run",
    "state",
    "model",
    "fmu",
    "packets",
    "play",
    "sizes",
    "absurd",
    "log",
    "shared",
    "plan",
)
SOUND = ("refused", "ran")
FAULTS = ("crash", "hang", "traceback", "nonsense")
"""Nonsense: accepted, and the answer is none; in the energy audit, for one."""
_BATCH = 2000
"""Inputs of a process: what it leaks is given back with it."""
_HANG = (-14, -27)
"""Exit codes of a process that its alarm has ended: of the clock, of the processor."""


@dataclass
class Counted:
    """What the inputs of a kind ended in; `faults` are lines with the seed of each that is one."""

    outcomes: Counter[str] = field(default_factory=Counter)
    faults: list[str] = field(default_factory=list)

    def add(self, kind: str, seed: int, outcome: str, detail: str = "") -> None:
        self.outcomes[outcome] += 1
        if outcome in FAULTS:
            self.faults.append(f"{kind} --first {seed}: {outcome} {detail}")


def attack(kind: str, inputs: int, first: int = 0, processes: int = 1) -> Counted:
    """The inputs of a kind with the seeds from `first` on."""
    counted = Counted()
    starts = range(first, first + inputs, _BATCH)
    with ThreadPoolExecutor(processes) as pool:
        for found in pool.map(lambda start: _batch(kind, start, min(_BATCH, first + inputs - start)), starts):
            for seed, outcome, detail in found:
                counted.add(kind, seed, outcome, detail)
    return counted


def _batch(kind: str, first: int, count: int) -> list[tuple[int, str, str]]:
    """In a process; where one dies, the next goes on behind the seed that killed it."""
    found: list[tuple[int, str, str]] = []
    end = first + count
    while first < end:
        code, results, error = _worker(kind, first, end - first)
        found += results
        first = results[-1][0] + 1 if results else first
        if code == 0 and first >= end:
            break
        if code == 0 or "cannot prepare" in error:
            raise AssertionError(f"the worker of {kind} ended early ({code}): {error[-2000:]}")
        found.append((first, "hang" if code in _HANG else "crash", f"exit code {code} {error[-300:]!r}"))
        first += 1
    return found


def _worker(kind: str, first: int, count: int) -> tuple[int, list[tuple[int, str, str]], str]:
    command = [sys.executable, "-m", "hostile.worker", kind, str(first), str(count)]
    folder = str(Path(__file__).resolve().parents[1])
    environment = os.environ | {"PYTHONPATH": os.pathsep.join([folder, *filter(None, sys.path)])}
    with tempfile.TemporaryDirectory(prefix="hostile") as left:  # also by what was killed
        environment["TMPDIR"] = left
        done = subprocess.run(command, capture_output=True, text=True, errors="replace", env=environment, check=False)
    return done.returncode, list(_parsed(done.stdout)), done.stderr


def _parsed(text: str) -> Iterator[tuple[int, str, str]]:
    for line in text.splitlines():
        seed, outcome, detail = line.split(" ", 2)
        yield int(seed), outcome, detail


def table(counted: dict[str, Counted]) -> str:
    """Kinds and what their inputs ended in."""
    columns = (*SOUND, *FAULTS)
    lines = [f"{'kind':<10}{'inputs':>9}" + "".join(f"{name:>11}" for name in columns)]
    for kind, one in counted.items():
        lines.append(f"{kind:<10}{one.outcomes.total():>9}" + "".join(f"{one.outcomes[name]:>11}" for name in columns))
    return "\n".join(lines)
