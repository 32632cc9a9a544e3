"""Runs abuses of the core one after another and tells of each before and after, so that who watches can name what died.

usage: worker.py calls|models FIRST STRIDE SECONDS
"""

from __future__ import annotations

import os
import signal
import sys
import warnings

from abuses import all_cases
from examples import public_names


def main() -> None:
    kind, first, stride, seconds = sys.argv[1], int(sys.argv[2]), int(sys.argv[3]), float(sys.argv[4])
    warnings.simplefilter("ignore")
    cases = all_cases(models=kind == "models")
    out = os.fdopen(os.dup(1), "w", buffering=1)
    for name in public_names():
        print(f"public {name}", file=out)
    for index in range(first, len(cases), stride):
        name, abuse = cases[index]
        print(f"begin {index} {name!r}", file=out)
        signal.setitimer(signal.ITIMER_REAL, seconds)  # its signal ends the process: also in the midst of C++
        try:
            abuse()
            outcome = "returned"
        except BaseException as error:
            outcome = f"{type(error).__name__} {error!s}"
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        print(f"end {index} {outcome!r}", file=out)
    print("done", file=out)


if __name__ == "__main__":
    main()
