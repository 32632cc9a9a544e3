"""What a period of the served bogie with its machines costs, and the largest rate that one core holds at half load.

case at 1 kHz -> processor time of each period; case at shorter sampling steps -> largest rate

    python benchmarks/real_time.py [--periods 1000000] [--case adhesion_brake]

Processor time. The test is repeated from its start until the periods are done: braking on low adhesion from 120 km/h, the
valves at rest. First each period once, with what the machine does beside it; then the first 20000 of them five times, the
least of each: what the computing itself needs. The largest rate is found by the latter.
"""

from __future__ import annotations

import argparse

import rollerrig as rr
from rollerrig import _core
from rollerrig.interfaces.realtime.server import Served, serve_case

LOAD = 0.5
"""Part of each period that the longest step may take."""
RATES = (1000, 2000, 4000, 5000, 10000, 20000)
"""Tried one after another [Hz]."""


def served_at(case: rr.Case, hertz: int) -> Served:
    step = {"time.sampling_step": 1.0 / hertz} if hertz > round(1.0 / case.time.sampling_step) else {}
    return serve_case(case.with_changes(step), hertz)


def periods_of(served: Served, count: int, repeats: int) -> tuple[int, int, int, int, int]:
    """Count, median, 99 %, 99.99 % and longest [ns]; of each period the least of its repeats."""
    rig = (served.assembled, served.input_indices, served.output_indices)
    found: tuple[int, int, int, int, int] = _core.measure_rig(
        *rig, period=served.period, periods=count, repeats=repeats
    )
    return found


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("--periods", type=int, default=1_000_000)
    options.add_argument("--case", default="adhesion_brake")
    given = options.parse_args()
    case = rr.load_case(given.case)
    few = min(given.periods, 20_000)
    for name, count, repeats in (("once", given.periods, 1), ("least of five", few, 5)):
        print(f"1 kHz, {name}: {in_words(periods_of(served_at(case, 1000), count, repeats))}")
    print(f"largest rate with the longest step within {100 * LOAD:.0f} % of a period: {largest_rate(case, few)}")


def in_words(found: tuple[int, int, int, int, int]) -> str:
    words = ("median", "99 %", "99.99 %", "longest")
    times = (f"{word} {1e-3 * ns:.1f} us" for word, ns in zip(words, found[1:], strict=True))
    return f"{found[0]} periods, {', '.join(times)}"


def largest_rate(case: rr.Case, periods: int) -> str:
    best = "below 1 kHz"
    for hertz in RATES:
        served = served_at(case, hertz)
        found = periods_of(served, periods, 5)
        print(f"{hertz / 1000:g} kHz: {in_words(found)}")
        if 1e-9 * found[4] > LOAD * served.period:
            return best
        best = f"{hertz / 1000:g} kHz"
    return best


if __name__ == "__main__":
    main()
