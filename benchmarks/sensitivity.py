"""What derivatives cost beside a run, and those of the critical speed by every number of the suspension.

    python benchmarks/sensitivity.py

The bogie on rollers, 1 s and 10 s at 150 km/h from an offset of 3 mm, with 1, 5 and 20 numbers; processor time over that of
simulate(), at the steps of the case and at those of the derivatives. What does not depend on the length of the run, the two
changed models of each number, is in it.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from functools import partial

import rollerrig as rr
from rollerrig.analysis.stability_sensitivity import suspension_parameters
from rollerrig.simulation.sensitivity import with_fine_steps


def processor(work: Callable[[], object]) -> float:
    """Processor time of a call [s]."""
    start = time.process_time()
    work()
    return time.process_time() - start


def main() -> None:
    """Print the times."""
    whole = rr.load_case("bogie_rollers_constant")
    keys = list(suspension_parameters(whole))
    short = whole.with_changes({"time.duration": "10 ms"})
    rr.sensitivity(short, keys[:1], ["lateral"])  # what is loaded once is not counted
    for duration in (1, 10):
        case = whole.with_changes({"time.duration": f"{duration} s"})
        run, fine = (
            min(processor(partial(rr.simulate, one)) for _ in range(3)) for one in (case, with_fine_steps(case))
        )
        for count in (1, 5, 20):
            own = processor(partial(rr.sensitivity, case, keys[:count], ["lateral"]))
            print(f"{duration} s, {count} numbers: {own:.2f} s, {own / run:.1f} runs of {run:.3f} s, ", end="")
            print(f"{own / fine:.1f} of {fine:.3f} s at its own steps", flush=True)
    for name in ("bogie_rollers_constant", "bogie_track"):
        modes = processor(partial(rr.stability_sensitivity, name, []))
        count = len(list(suspension_parameters(rr.load_case(name))))
        every = processor(partial(rr.stability_sensitivity, name))
        print(f"{name}: critical speed {modes:.2f} s, its {count} derivatives {every - modes:.2f} s more")


if __name__ == "__main__":
    main()
