"""One process that throws inputs and may die of them; usage: python -m hostile.worker KIND FIRST COUNT.

A line for each input that it outlives: seed, outcome, detail. What hangs is ended by an alarm, also within C++.
"""

from __future__ import annotations

import importlib
import os
import random
import resource
import signal
import sys
import traceback
import warnings

SECONDS, ASLEEP = 20.0, 180.0
"""Of the processor that one input may take, and of the clock on a busy machine."""
ROOM = 6 * 2**30
"""Addresses of the process [B]: what asks for more is told so, and does not take the machine with it."""


def main() -> None:
    """Throw them."""
    name, first, count = sys.argv[1], int(sys.argv[2]), int(sys.argv[3])
    out = os.fdopen(os.dup(1), "w", buffering=1)
    os.dup2(2, 1)  # what else is printed is no result
    warnings.simplefilter("ignore")
    resource.setrlimit(resource.RLIMIT_AS, (ROOM, ROOM))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    try:
        kind = importlib.import_module(f"hostile.{name}")
        prepared = kind.prepare()
    except BaseException:
        print(f"cannot prepare: {traceback.format_exc()}", file=sys.stderr)
        raise
    for seed in range(first, first + count):
        signal.setitimer(signal.ITIMER_PROF, SECONDS)
        signal.setitimer(signal.ITIMER_REAL, ASLEEP)
        outcome, detail = assessed(kind, prepared, random.Random(f"{name} {seed}"))
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        print(seed, outcome, detail.replace("\n", " | ")[:300], file=out)
    out.flush()
    os._exit(0)  # servers in threads of their own are not waited for


def assessed(kind, prepared, choose: random.Random) -> tuple[str, str]:
    """What one input ends in."""
    try:
        outcome = kind.attack(prepared, choose)
    except kind.REFUSALS as error:
        return ("refused", "") if str(error).strip() else ("traceback", f"{type(error).__name__} without a word")
    except BaseException as error:
        place = traceback.extract_tb(error.__traceback__)[-1]
        return "traceback", f"{type(error).__name__}: {error} ({place.filename}:{place.lineno})"
    word, _, detail = outcome.partition(" ")
    return word, detail


if __name__ == "__main__":
    main()
