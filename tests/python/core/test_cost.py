"""What a run costs, in counts that no other load on the machine can change."""

from __future__ import annotations

import math

import numpy as np

from rollerrig import _core
from rollerrig.assembly.model import assemble
from rollerrig.config import load_case
from rollerrig.simulation.run import begin
from rollerrig.simulation.starting_state import disturbances, starting_state


def run_to_the_end(name: str, changes: dict[str, object]) -> _core.Simulation:
    case = load_case(name).with_changes(changes)
    model = assemble(case)
    simulation = _core.Simulation(model.core)
    begin(simulation, model, starting_state(model))
    count = math.floor(case.time.duration / case.time.output_step + 1e-9) + 1
    simulation.advance(case.time.duration, np.empty(count), np.empty((count, simulation.width)), 0)
    return simulation


def test_a_warm_search_looks_at_few_cell_borders() -> None:
    """About 8 of the 121 borders per wheel and evaluation while the bogie hunts; half as many again fails."""
    hunting = {"motion.speed": "200 km/h", "time.duration": "0.5 s", "time.output_step": "0.1 s"}
    simulation = run_to_the_end("bogie_rollers_constant", hunting)
    evaluations = simulation.statistics()["derivative_calls"]
    assert simulation.search_evaluations / (4 * evaluations) < 12


def test_the_traction_study_takes_few_steps() -> None:
    """48 steps at the benchmark's tolerance; the stiff contacts force none of them."""
    coarse = {"time.relative_tolerance": 1e-3, "time.absolute_tolerance": 1e-7}
    statistics = run_to_the_end("bogie_rollers_traction", coarse).statistics()
    assert statistics["steps"] + statistics["rejected_steps"] < 70
    assert statistics["jacobian_calls"] < 60


def test_a_start_with_an_offset_costs_few_looks_at_cell_borders() -> None:
    """About 300 per wheel for the equilibrium and the disturbed one: wheelsets are set down from near, not from 20 mm away."""
    model = assemble(load_case("bogie_rollers_constant").with_changes({"contact.normal": {"kind": "hertz"}}))
    simulation, speed = _core.Simulation(model.core), model.case.motion.speed
    rest = simulation.equilibrium(speed, 0.0, [])["x"]
    index = simulation.coordinate_index
    fixed = [(d.body, d.coordinate, rest[index[d.body][d.coordinate]] + d.offset) for d in disturbances(model)]
    assert simulation.equilibrium(speed, 0.0, fixed, rest)["converged"]
    assert simulation.search_evaluations / 4 < 450
