"""How fast and how exact a whole vehicle runs over irregular rails, by method and step.

    python benchmarks/irregular.py [--reference-ms STEP]

Case `vehicle_track_irregular`, its first 4 s: four wheelsets at 144 km/h on ORE B 176, low level; rails rigid, on an elastic
foundation, and rigid with patches as strips. Processor time of one core, outputs every 5 ms included, best of two. Error: largest
difference to classical Runge-Kutta with a short step, over the largest value of that signal; of the signals of a kind the worst.
Wheel forces as they are, and through the 20 Hz low-pass of EN 14363, as they are read.
"""

from __future__ import annotations

import argparse
import time

import numpy as np

from rollerrig import _core, load_case
from rollerrig.analysis.signals import low_pass
from rollerrig.assembly.model import assemble
from rollerrig.config import ConfigError
from rollerrig.results import Outcome, run_dataset
from rollerrig.simulation.run import begin
from rollerrig.simulation.starting_state import starting_state

DURATION = 4.0  # [s]
FOUNDATION = {
    "rail_mass": 150.0,
    "lateral": {"stiffness": 2e7, "damping": 5e4},
    "vertical": {"stiffness": 6e7, "damping": 1e5},
}
METHODS = (
    ("rk4", 0.1, None),
    ("rk4", 0.25, None),
    ("rk4", 0.5, None),
    ("exponential_rk4", 0.5, None),
    ("exponential_rk4", 1.0, None),
    ("dormand_prince", None, 1e-6),
    ("dormand_prince", None, 1e-5),
)


def simulate(method: str, step_ms: float | None, tolerance: float | None, changes: dict[str, object], repeat: int):
    """Processor time [s] and results of one run."""
    settings: dict[str, object] = {"time.duration": DURATION, "time.method": method, "time.output_step": 5e-3}
    settings["time.step"] = None if step_ms is None else 1e-3 * step_ms
    if tolerance is not None:
        settings |= {"time.relative_tolerance": tolerance, "time.absolute_tolerance": 1e-3 * tolerance}
    model = assemble(load_case("vehicle_track_irregular").with_changes({**changes, **settings}))
    best = np.inf
    for _ in range(repeat):
        simulation = _core.Simulation(model.core)
        state = starting_state(model)
        times, rows = np.empty(801), np.empty((801, simulation.width))
        begin(simulation, model, state)
        begun = time.process_time()
        _, filled = simulation.advance(DURATION, times, rows, 0)
        best = min(best, time.process_time() - begun)
    outcome = Outcome("ok", "", DURATION, "", simulation.statistics(), simulation.counters())
    return best, run_dataset(model, times[:filled], rows[:filled], outcome)


def error(signal, reference) -> float:
    """Largest difference over the largest value of each signal; the worst of them [-]."""
    largest = np.abs(reference).max("time")
    relative = np.abs(signal - reference).max("time") / largest
    return float(relative.where(largest > 1e-3 * largest.max()).max())


def signals(run) -> dict[str, object]:
    """What is compared, by kind."""
    vehicle = [str(b) for b in run["body"].to_numpy() if not str(b).startswith(("rail", "roller"))]
    q = run["vertical_force"]
    return {
        "lateral": run["lateral"].sel(body=vehicle),
        "vertical": run["vertical"].sel(body=vehicle),
        "Q, 20 Hz": low_pass(q, 20.0),
        "Q": q,
        "acceleration": run["vertical_acceleration"].sel(body=[b for b in vehicle if b.startswith("wheelset")]),
    }


def main() -> None:
    """Print a table for rigid and for elastic rails."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--reference-ms", type=float, default=0.025, metavar="STEP")
    reference_ms = parser.parse_args().reference_ms
    supports = {
        "rigid rails": {},
        "elastic rails": {"support.foundation": FOUNDATION},
        "rigid rails, strips": {"contact.normal": "strips", "contact.creep": "table"},
    }
    for label, changes in supports.items():
        _, run = simulate("rk4", reference_ms if "strips" not in label else 4 * reference_ms, None, changes, 1)
        reference = signals(run)
        print(f"\n{label:38} x real time   " + "  ".join(f"{name:>12}" for name in reference))
        for method, step_ms, tolerance in METHODS:
            try:
                spent, run = simulate(method, step_ms, tolerance, changes, 2)
            except ConfigError as refused:
                print(f"  {method}, {step_ms} ms: refused; {str(refused).split('; ')[1]}")
                continue
            name = f"{method}, {f'{step_ms} ms' if step_ms else f'tolerance {tolerance:.0e}'}"
            errors = [error(a, b) for a, b in zip(signals(run).values(), reference.values(), strict=True)]
            print(f"  {name:36} {DURATION / spent:11.1f}   " + "  ".join(f"{e:12.1e}" for e in errors), flush=True)


if __name__ == "__main__":
    main()
