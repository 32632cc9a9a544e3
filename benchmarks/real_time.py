"""What a period of the served bogie with its machines costs, and the largest rate that one core holds at half load.

case at 1 kHz -> processor time of each period; case at shorter sampling steps -> largest rate

    python benchmarks/real_time.py [--periods 1000000] [--case adhesion_brake]

Processor time, so that other work on the machine counts little; caches and frequency it does share. The test is repeated from
its start until the periods are done: braking on low adhesion from 120 km/h, the valves at rest.
"""

from __future__ import annotations

import argparse

import rollerrig as rr
from rollerrig import _core
from rollerrig.realtime.served import Served, serve_case

LOAD = 0.5
"""Part of each period that the longest step may take."""
RATES = (1000, 2000, 4000, 5000, 10000, 20000)
"""Tried one after another [Hz]."""


def served_at(case: rr.Case, hertz: int) -> Served:
    step = {"time.sampling_step": 1.0 / hertz} if hertz > round(1.0 / case.time.sampling_step) else {}
    return serve_case(case.with_changes(step), hertz)


def periods_of(served: Served, count: int) -> tuple[int, int, int, int, int]:
    """Count, median, 99 %, 99.99 % and longest [ns]."""
    rig = (served.assembled, served.input_indices, served.output_indices)
    found: tuple[int, int, int, int, int] = _core.measure_rig(*rig, period=served.period, periods=count)
    return found


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("--periods", type=int, default=1_000_000)
    options.add_argument("--case", default="adhesion_brake")
    given = options.parse_args()
    case = rr.load_case(given.case)
    found = periods_of(served_at(case, 1000), given.periods)
    words = ("periods", "median", "99 %", "99.99 %", "longest")
    print(
        "1 kHz:",
        ", ".join(
            f"{w} {n if i == 0 else f'{1e-3 * n:.1f} us'}" for i, (w, n) in enumerate(zip(words, found, strict=True))
        ),
    )
    for name, place in (("longest step", 4), ("99.99 %", 3), ("99 %", 2)):
        print(
            f"largest rate where {name} takes at most {100 * LOAD:.0f} % of a period: {largest_rate(case, place, given.periods)}"
        )


def largest_rate(case: rr.Case, place: int, periods: int) -> str:
    best = "below 1 kHz"
    for hertz in RATES:
        served = served_at(case, hertz)
        if 1e-9 * periods_of(served, min(periods, 20_000))[place] > LOAD * served.period:
            return best
        best = f"{hertz / 1000:g} kHz"
    return best


if __name__ == "__main__":
    main()
