"""How fast a brake test on the bench runs: real time factor, evaluations per step, and where a step's time goes.

    python benchmarks/adhesion.py [--duration SECONDS] [--against PYTHON_PATH]

Case `adhesion_brake`, the bogie on four rollers with slide protection, virtual train and roller drives, everything at 1 ms, and
the same on track; and `adhesion_valves`, with dump valves, reservoir and pulse sensors; 120 km/h down to the stop. Processor
time of one core, outputs every 10 ms included, best of three.

With --against, the folder that holds another build's package `rollerrig`, both are measured in turn in processes of their own
and the ratio is printed: on a busy machine a ratio is worth more than two times.
"""

from __future__ import annotations

import argparse
import json
import time

import numpy as np
from timing import elsewhere

from rollerrig import _core, load_case
from rollerrig.assembly.actuators import assemble_with_actuators
from rollerrig.assembly.model import assemble
from rollerrig.simulation.run import begin, march, prepare
from rollerrig.simulation.starting_state import starting_state
from rollerrig.study.runs.adhesion import track_case

PLACES = {"rig": "adhesion_brake", "track": "adhesion_brake", "valves": "adhesion_valves"}
"""Name of a measurement -> its case."""

TEST = 60.0
"""What the times are given for [s]."""


def measure(place: str, duration: float | None) -> dict[str, float]:
    """Cost of one test on the `rig` or on `track`, or on the rig with `valves`, reservoir and pulse sensors."""
    case = load_case(PLACES[place])
    if duration is not None:
        case = case.with_changes({"time.duration": duration})
    if place == "track":
        case = track_case(case)
    count = int(case.time.duration / case.time.output_step) + 2
    best = np.inf
    for _ in range(3):
        simulation = prepare(assemble_with_actuators(case))
        times, rows = np.full(count, np.nan), np.empty((count, simulation.width))
        begun = time.process_time()
        march(simulation, case.time.duration, times, rows, slice_length=case.time.output_step)
        best = min(best, time.process_time() - begun)
    statistics = simulation.statistics()
    simulated = simulation.time
    return {
        "simulated": simulated,
        "spent": best,
        "evaluations_per_step": statistics["derivative_calls"] / statistics["steps"],
        "steps_per_ms": statistics["steps"] / (1e3 * simulated),
        "us_per_evaluation": evaluation(place),
    }


def evaluation(place: str) -> float:
    """One right-hand side along a run of the same vehicle [us], by a plain Simulation with rk4 at 1 ms."""
    case = load_case("adhesion_brake")
    case = track_case(case) if place == "track" else case
    plain = case.model_copy(
        update={"brake": None, "slide_protection": None, "rig_control": None, "adhesion": None, "train": None}
    ).with_changes({"time.duration": 2.0, "time.method": "exponential_rk4", "time.step": 1e-3})
    model = assemble(plain)
    best = np.inf
    for _ in range(3):
        simulation = _core.Simulation(model.core)
        begin(simulation, model, starting_state(model))
        times, rows = np.empty(400), np.empty((400, simulation.width))
        begun = time.process_time()
        simulation.advance(2.0, times, rows, 0)
        spent = time.process_time() - begun
        best = min(best, spent / simulation.statistics()["derivative_calls"])
    return 1e6 * best


def main() -> None:
    """Print a line for the rig and one for the track."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--duration", type=float, default=None, metavar="SECONDS", help="at most, of each test")
    parser.add_argument("--against", default=None, metavar="PYTHON_PATH", help="folder with another build's package")
    parser.add_argument("--only", default=None, choices=tuple(PLACES), help="print numbers of one place as JSON")
    options = parser.parse_args()
    if options.only:
        print(json.dumps(measure(options.only, options.duration)))
        return
    duration = ["--duration", str(options.duration)] if options.duration else []
    print("             a 60 s test   x real time   steps/ms   evaluations/step   us/step, of which evaluations")
    for place in PLACES:
        own = measure(place, options.duration)
        per_step = 1e3 * own["spent"] / (own["simulated"] * own["steps_per_ms"])
        print(
            f"  {place:8} {TEST * own['spent'] / own['simulated']:10.2f} s {own['simulated'] / own['spent']:13.1f}"
            f" {own['steps_per_ms']:10.2f} {own['evaluations_per_step']:18.2f} {per_step:9.1f}"
            f" {own['evaluations_per_step'] * own['us_per_evaluation']:10.1f}",
            flush=True,
        )
        if options.against:
            other = elsewhere(__file__, ["--only", place, *duration], options.against)
            ratio = (other["spent"] / other["simulated"]) / (own["spent"] / own["simulated"])
            print(f"           {ratio:.2f} times as fast as {options.against}", flush=True)


if __name__ == "__main__":
    main()
