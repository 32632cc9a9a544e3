"""Three runs that users wait for, strips and table, with their errors: real-time factor, right-hand sides, error, energy.

    python benchmarks/long_runs.py [--quick]

Hunting bogie at 216 km/h, 4 s; whole vehicle on irregular track, 4 s; brake test with slide protection, all at 1 ms, 60 s.
Method, step and tolerances as the cases are shipped; errors against a step of an eighth, up to where a second reference by
another method agrees within 0.03 % (a controller that decides at its samples lets runs part at one decision). Processor time of
one core, best of two.
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass

from step_errors import Measured, agree_until, errors, measure, signals

from rollerrig import load_case

CONTACT = {"contact.normal": "strips", "contact.creep": "table"}
RUNS = (
    ("bogie_rollers_constant", {"motion.speed": "216 km/h", "time.duration": 4.0}),
    ("vehicle_track_irregular", {"time.duration": 4.0}),
    ("adhesion_brake", {"time.duration": 60.0, "time.output_step": 5e-3}),
)
TIGHT = {"time.relative_tolerance": 1e-8, "time.absolute_tolerance": 1e-11}


@dataclass(frozen=True)
class LongRun:
    """One run with its errors."""

    name: str
    step: float
    """[s]"""
    run: Measured
    until: float
    """Time up to which two references agree [s]."""
    errors: dict[str, float]


def long_run(name: str, changes: dict[str, object], quick: bool) -> LongRun:
    """Run a case, and its references."""
    share = (0.1 if name.startswith("adhesion") else 0.25) if quick else 1.0
    case = load_case(name).with_changes(
        {**changes, **CONTACT, "time.duration": share * float(changes["time.duration"])}
    )
    method, step = case.integration
    assert step is not None
    run = measure(case, repeat=2)
    tight = signals(measure(case.with_changes({"time.method": method, "time.step": step / 8, **TIGHT})).run)
    other = measure(case.with_changes({"time.method": "exponential_rk4", "time.step": step / 8}))
    until = agree_until(tight, signals(other.run), 3e-4)
    return LongRun(name, step, run, until, errors(signals(run.run), tight, until))


def main() -> None:
    """Print a line for each run."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="a tenth of the brake test, a quarter of the others")
    quick = parser.parse_args().quick
    for name, changes in RUNS:
        one = long_run(name, changes, quick)
        print(
            f"{name}, {1e3 * one.step:g} ms: {one.run.real_time:.3g} x real time, {one.run.evaluations:.2f} "
            f"right-hand sides/ms, energy {one.run.energy:.1e}; errors in the first {one.until:.3g} s: "
            + ", ".join(f"{kind} {value:.1e}" for kind, value in one.errors.items()),
            flush=True,
        )


if __name__ == "__main__":
    main()
