"""What curves and irregular rails cost: one right-hand side and one Jacobian of the whole vehicle, by kind of track.

    python benchmarks/track.py

States are those of a run, so that the contact search is warm as it is in a run; processor time, best of five.
"""

from __future__ import annotations

import numpy as np
from run import best_time

from rollerrig import _core, load_case
from rollerrig.assembly.model import assemble
from rollerrig.simulation.run import begin
from rollerrig.simulation.starting_state import starting_state

CURVE = [
    {"kind": "straight", "length": 20.0},
    {"kind": "transition", "length": 80.0},
    {"kind": "curve", "length": 400.0, "radius": 1500.0, "cant": 0.06},
]
IRREGULAR = {"kind": "ore_b176", "level": "low"}
FOUNDATION = {
    "rail_mass": 150.0,
    "lateral": {"stiffness": 2e7, "damping": 5e4},
    "vertical": {"stiffness": 6e7, "damping": 1e5},
}
TRACKS: dict[str, dict[str, object]] = {
    "straight": {},
    "irregular": {"support.irregularity": IRREGULAR},
    "curve": {"support.segment": CURVE},
    "curve, irregular": {"support.segment": CURVE, "support.irregularity": IRREGULAR},
    "the same, elastic": {
        "support.segment": CURVE,
        "support.irregularity": IRREGULAR,
        "support.foundation": FOUNDATION,
    },
}


def measure(changes: dict[str, object]) -> tuple[float, float]:
    """Seconds of one right-hand side and of one Jacobian, in the transition 2 s after the start."""
    case = load_case("bogie_track").with_changes(
        {"vehicle.cut": "vehicle", "motion.speed": "30 m/s", "time.duration": 2.0, "disturbance": [], **changes}
    )
    model = assemble(case)
    simulation = _core.Simulation(model.core)
    begin(simulation, model, starting_state(model))
    simulation.advance(2.0, np.empty(1), np.empty((1, simulation.width)), 1)
    state = simulation.state
    # Two states that differ: equal ones in a row are evaluated once.
    states = np.ascontiguousarray([state + (i % 2) * 1e-9 for i in range(200)])
    right_hand_side = best_time(lambda: simulation.derivatives(2.0, states), 5) / len(states)
    return right_hand_side, best_time(lambda: simulation.jacobian(2.0, state), 5)


if __name__ == "__main__":
    print(f"{'track':20} {'right-hand side':>16} {'Jacobian':>10}  [us]")
    for name, changes in TRACKS.items():
        right_hand_side, jacobian = measure(changes)
        print(f"{name:20} {1e6 * right_hand_side:16.1f} {1e6 * jacobian:10.1f}")
