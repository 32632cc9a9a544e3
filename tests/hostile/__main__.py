"""`python -m hostile [KIND ...] [--inputs N] [--first SEED] [--processes N]`, in the folder tests: the table of outcomes."""

from __future__ import annotations

import argparse
import sys
import time

from hostile.runner import KINDS, Counted, attack, table


def main() -> int:
    """Attack; 1: something was found."""
    parser = argparse.ArgumentParser(
        prog="python -m hostile", description="Hostile inputs, counted by what they end in."
    )
    parser.add_argument("kind", nargs="*", choices=[*KINDS, []], help=f"{', '.join(KINDS)}; none: all of them")
    parser.add_argument("--inputs", type=int, default=1000, help="of each kind")
    parser.add_argument("--first", type=int, default=0, help="seed of the first; each input has its own")
    parser.add_argument("--processes", type=int, default=1)
    given = parser.parse_args()
    counted: dict[str, Counted] = {}
    for kind in given.kind or KINDS:
        begun = time.monotonic()
        counted[kind] = attack(kind, given.inputs, given.first, given.processes)
        print(f"{kind}: {time.monotonic() - begun:.0f} s", *counted[kind].faults, sep="\n", flush=True)
    print(table(counted))
    return int(any(one.faults for one in counted.values()))


if __name__ == "__main__":
    sys.exit(main())
