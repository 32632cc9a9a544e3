"""What a sweep costs beyond its cases: processor time of `rollerrig sweep` over that of the same calls in a loop.

    python benchmarks/sweep.py [--cases 1000]

The cases are those of a linear critical speed, some 0.1 s each; the loop computes the same ones from a case that is there. The
target is 1.3 for 10^5 cases of 0.1 s: reading the plan and writing the report count, so fewer cases make the ratio larger.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from pathlib import Path

from timing import of_children

from rollerrig.config import load_case
from rollerrig.study.jobs import job
from rollerrig.study.measures import measured
from rollerrig.study.sweep import SweepStudy, sweep_study


def study(cases: int) -> SweepStudy:
    vary = {"support.roller_radius": {"least": "0.5 m", "most": "1.5 m", "count": cases}}
    return sweep_study(load_case("bogie_rollers_constant"), vary, "critical_speed", "grid")


def in_a_loop(work: SweepStudy) -> float:
    """Processor time of the cases alone [s]."""
    measure = work.whole.plan.measure[0]
    cases = [work.whole.case.with_changes(changes) for changes in work.points.changes()]
    begun = time.process_time()
    for case in cases:
        job(measured, case, measure).call(lambda _fraction, _text: None)
    return time.process_time() - begun


def processor_time() -> float:
    """Of this process and those that it started and that have ended [s]."""
    return time.process_time() + of_children()


def as_sweep(work: SweepStudy, workers: int) -> float:
    """Processor time of all processes of a sweep [s]."""
    begun = processor_time()
    with tempfile.TemporaryDirectory() as folder:
        outcome = work.run(folder=Path(folder), processes=workers)
        assert outcome is not None
        outcome.write(folder)
    return processor_time() - begun


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--cases", type=int, default=1000)
    work = study(parser.parse_args().cases)
    in_a_loop(study(2))  # loads what both need
    alone = in_a_loop(work)
    print(f"{len(work.points)} cases in a loop: {alone:.1f} s, {1e3 * alone / len(work.points):.1f} ms each")
    for workers in (1, 2):
        taken = as_sweep(work, workers)
        print(
            f"sweep with {workers} worker{'s' if workers > 1 else ''}: {taken:.1f} s, {taken / alone:.3f} times as much"
        )


if __name__ == "__main__":
    main()
