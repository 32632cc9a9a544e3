"""What derivatives cost beside a run, and those of the critical speed by every number of the suspension.

    python benchmarks/sensitivity.py

The bogie on rollers, 1 s at 150 km/h from an offset of 3 mm, with 1, 5 and 20 numbers; processor time over that of simulate().
"""

from __future__ import annotations

import time
from collections.abc import Callable
from functools import partial

import rollerrig as rr
from rollerrig.analysis.stability_sensitivity import suspension_parameters


def processor(work: Callable[[], object]) -> float:
    """Processor time of a call [s]."""
    start = time.process_time()
    work()
    return time.process_time() - start


def main() -> None:
    """Print the times."""
    case = rr.load_case("bogie_rollers_constant").with_changes({"time.duration": "1 s"})
    keys = list(suspension_parameters(case))
    rr.sensitivity(
        case.with_changes({"time.duration": "10 ms"}), keys[:1], ["lateral"]
    )  # what is loaded once is not counted
    run = min(processor(partial(rr.simulate, case)) for _ in range(3))
    for tolerance in (1e-3, 1e-5):
        for count in (1, 5, 20):
            own = processor(partial(rr.sensitivity, case, keys[:count], ["lateral"], tolerance=tolerance))
            print(f"{count} numbers, tolerance {tolerance:g}: {own:.2f} s, {own / run:.1f} runs of {run:.3f} s")
    for name in ("bogie_rollers_constant", "bogie_track"):
        modes = processor(partial(rr.stability_sensitivity, name, []))
        count = len(list(suspension_parameters(rr.load_case(name))))
        every = processor(partial(rr.stability_sensitivity, name))
        print(f"{name}: critical speed {modes:.2f} s, its {count} derivatives {every - modes:.2f} s more")


if __name__ == "__main__":
    main()
