"""What a second of a hunting run costs by two methods, and how far each is from a tight run.

    python benchmarks/hunting.py

Runs from 3 mm as the studies of stability make them with strips, `exponential_adams` with 2 ms, beside those of `rodas4`.
Errors of the leading wheelset's lateral displacement against `exponential_adams` with 0.25 ms and 1e-7, over the first second and
over the whole run. Processor time of one core, least of two; on a busy machine only their ratio says something.
"""

from __future__ import annotations

import time

import numpy as np

from rollerrig import Case, _core, load_case
from rollerrig.analysis.hunting import LATERAL, HuntingSettings, hunting_case
from rollerrig.assembly.model import assemble
from rollerrig.common.arrays import Array
from rollerrig.simulation.run import begin, march
from rollerrig.simulation.starting_state import starting_state

OUTPUT_STEP = 5e-3
RUNS = (("bogie_rollers_constant", 190.0, 4.0), ("bogie_rollers_constant", 235.0, 4.0), ("vehicle_rollers", 240.0, 2.0))
METHODS = {
    "tight": {"time.step": "0.25 ms", "time.relative_tolerance": 1e-7, "time.absolute_tolerance": 1e-10},
    "rodas4, 1e-3": {"time.method": "rodas4", "time.relative_tolerance": 1e-3, "time.absolute_tolerance": 1e-6},
    "rodas4, 1e-4": {"time.method": "rodas4"},
    "exponential_adams, 2 ms": {},
}


def measure(case: Case) -> tuple[float, Array]:
    """Processor time [s], lateral displacement of the leading wheelset [m]."""
    model = assemble(case)
    duration = case.time.duration
    room, spent = round(duration / OUTPUT_STEP) + 4, []
    for _ in range(2):
        simulation = _core.Simulation(model.core)
        begin(simulation, model, starting_state(model))
        times, rows = np.empty(room), np.empty((room, simulation.width))
        begun = time.process_time()
        _, filled = march(simulation, duration, times, rows, slice_length=duration, begin_at=0.0)
        spent.append(time.process_time() - begun)
    column = len(_core.body_fields) * model.body_index(model.wheelsets[0]) + LATERAL
    return min(spent), rows[:filled, column]


def main() -> None:
    """Print a line for each run and method."""
    for name, speed_kmh, duration in RUNS:
        settings = HuntingSettings(duration=duration, output_step=OUTPUT_STEP)
        basis = hunting_case(load_case(name), speed_kmh / 3.6, settings)
        print(f"{name}, {speed_kmh:g} km/h")
        _, tight = measure(basis.with_changes(METHODS["tight"]))
        second = round(1.0 / OUTPUT_STEP)
        for method, own in list(METHODS.items())[1:]:
            spent, found = measure(basis.with_changes(own))
            off = 1e3 * np.abs(found - tight)
            print(
                f"  {method:30} {spent / duration:6.3f} s per s; {off[:second].max():.4f} mm in 1 s, {off.max():.4f} mm",
                flush=True,
            )


if __name__ == "__main__":
    main()
