"""What a run costs, in counts that no other load on the machine can change."""

from __future__ import annotations

import math

import numpy as np

from rollerrig import _core
from rollerrig.assembly.model import assemble
from rollerrig.config import load_case
from rollerrig.simulation.run import begin
from rollerrig.simulation.starting_state import starting_state


def run_to_the_end(name: str, changes: dict[str, object]) -> _core.Simulation:
    case = load_case(name).with_changes(changes)
    model = assemble(case)
    simulation = _core.Simulation(model.core)
    begin(simulation, model, starting_state(model))
    count = math.floor(case.time.duration / case.time.output_step + 1e-9) + 1
    simulation.advance(case.time.duration, np.empty(count), np.empty((count, simulation.width)), 0)
    return simulation


def test_the_traction_study_takes_few_steps() -> None:
    """48 steps at the benchmark's tolerance; the stiff contacts force none of them."""
    coarse = {"time.relative_tolerance": 1e-3, "time.absolute_tolerance": 1e-7}
    statistics = run_to_the_end("bogie_rollers_traction", coarse).statistics()
    assert statistics["steps"] + statistics["rejected_steps"] < 70
    assert statistics["jacobian_calls"] < 60
