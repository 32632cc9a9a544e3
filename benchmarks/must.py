"""What is required of the core, and what is measured: one table, with the error against a tight reference beside every run.

    python benchmarks/must.py [--quick] [--write]

--write puts the table into docs/performance.md. Contact `strips` with `table`. Processor time of one core, best of several; on a
busy machine all times are up to twice as long. Required, after the slash desired. The model in Numba and SciPy stands in
`benchmarks/run.py`.
"""

from __future__ import annotations

import argparse
import resource

from long_runs import RUNS, long_run
from normal_contact import microseconds_per_wheel
from right_hand_side import measure as right_hand_side
from timing import write_between

from rollerrig import load_case, simulate

ASKED = {
    "bogie_rollers_constant": "30 / 100 ×",
    "vehicle_track_irregular": "20 / 50 ×",
    "adhesion_brake": "40 / 100 ×",
}
WORDS = {
    "bogie_rollers_constant": "bogie after a lateral offset, 216 km/h",
    "vehicle_track_irregular": "whole vehicle on irregular track",
    "adhesion_brake": "brake test, everything at 1 ms",
}


def line(rows: list[str], what: str, asked: str, now: str, beside: str = "") -> None:
    """One row, printed as soon as it is there."""
    rows.append(f"| {what} | {asked} | {now} | {beside} |")
    print(rows[-1], flush=True)


def growth_of_memory() -> float:
    """Megabytes by which the process grows from the fifth to the fifteenth of equal runs."""
    case = load_case("bogie_rollers_constant").with_changes({"time.duration": "0.2 s"})
    largest = []
    for _ in range(15):
        simulate(case)
        largest.append(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0)
    return largest[-1] - largest[4]


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="a tenth of the brake test, a quarter of the others")
    parser.add_argument("--write", action="store_true", help="into docs/performance.md")
    given = parser.parse_args()
    rows: list[str] = []
    line(rows, "what", "required / desired", "measured", "remarks")
    line(rows, "---", "---", "---", "---")
    alone, _, of_eight = microseconds_per_wheel("bogie_rollers_constant", "strips")
    line(
        rows,
        "strips with search, per wheel",
        "1.5 / 1.0 µs",
        f"{of_eight:.2f} µs",
        f"of eight side by side; alone {alone:.2f} µs",
    )
    for case, wheels, asked in (("bogie on rollers", 4, "9 / 5 µs"), ("vehicle on irregular rails", 8, "")):
        full, paper = (right_hand_side(case, laws) for laws in ("strips, table", "hertz, kalker_saturated"))
        line(
            rows,
            f"right-hand side, {case}",
            asked,
            f"{full:.1f} µs",
            f"{wheels} wheels; the paper's contact: {paper:.1f} µs",
        )
    for name, changes in RUNS:
        one = long_run(name, changes, given.quick)
        found = ", ".join(f"{kind} {100 * value:.2g} %" for kind, value in one.errors.items())
        where = f"{1e3 * one.step:g} ms, {one.run.evaluations:.2f} right-hand sides/ms"
        beside = f"{where}; {found} in the first {one.until:.3g} s; energy {one.run.energy:.1e}"
        line(rows, WORDS[name], ASKED[name], f"{one.run.real_time:.3g} × real time", beside)
    line(rows, "memory over equal runs", "flat", f"{growth_of_memory():+.1f} MB in 10 runs", "")
    if given.write:
        write_between("must", "\n".join(rows))


if __name__ == "__main__":
    main()
