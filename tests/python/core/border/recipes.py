"""Models of shipped cases in parts, so that each number in them can be spoiled.

case -> assembly with a recording model_of -> [recipes] -> parts, what acts on the model, a state to start from
"""

from __future__ import annotations

import dataclasses
from typing import Any
from unittest import mock

import numpy as np

import rollerrig as rr
from rollerrig import _core
from rollerrig.assembly.actuators import assemble_with_actuators, track_brake
from rollerrig.assembly.model import assemble, axle_torque
from rollerrig.cases import on_track
from rollerrig.config.schema.brakes import MagneticTrackBrake
from rollerrig.simulation.mechatronics import mechatronic_setup


@dataclasses.dataclass(frozen=True)
class Recipe:
    """What a model is made of, what acts on it, and a state to start from."""

    name: str
    parts: Any
    setup: Any
    state: np.ndarray


def recorded(name: str, case: rr.Case, **changes: Any) -> Recipe:
    """The recipe of a case, with these parts in place of its own."""
    made: list[Any] = []
    with mock.patch.object(_core, "model_of", lambda parts: made.append(parts) or MODEL_OF(parts)):
        model = assemble_with_actuators(case) if case.sampled else assemble(case)
    found = _core.Simulation(model.start_core).equilibrium(case.motion.speed, 0.0, [])
    own = {name: getattr(made[0], name) for name in _core.ModelParts.fields}
    return Recipe(name, _core.ModelParts(**own | changes), mechatronic_setup(model), found["x"])


MODEL_OF = _core.model_of


def curve() -> np.ndarray:
    """Rows of a line's curvature: straight, then a curve."""
    return np.array([[0.0, 0.0, 0.0, 0.0, 0.0], [20.0, 1e-3, 0.0, 0.0, 0.0]])


def bumps() -> Any:
    """A rail's irregularity over 40 m."""
    return _core.UniformSpline(0.0, 1.0, np.full((40, 4), [1e-4, 0.0, 0.0, 0.0]))


def track() -> dict[str, Any]:
    """Parts of a line with all that it can have."""
    rail = _core.RailLayout(y=curve(), z=curve(), roll=curve())
    heads = _core.RailHeads(profiles=[1, 1], place=curve(), period=0.0)
    waves = dict.fromkeys(("left_y", "left_z", "right_y", "right_z"), bumps())
    return {
        "line": _core.Line(curvature=curve(), cant=0.1 * curve(), cant_base=1.5, left=rail, right=rail),
        "left_heads": heads,
        "right_heads": heads,
        "irregularity": _core.Irregularity(period=40.0, fade_in=10.0, steered=True, **waves),
        "speed": [(0.0, 30.0), (1.0, 29.0)],
        "axle_torques": [axle_torque(0, -1, [(0.0, 100.0), (1.0, 0.0)])],
        "track_brakes": [
            _core.BodyTrackBrake(body=0, brake=track_brake(MagneticTrackBrake(demand=((0.0, 0.0), (1.0, 1.0))), 1))
        ],
    }


def recipes() -> dict[str, Recipe]:
    """A bogie that brakes on rollers, one that starts, and one that brakes on irregular track with a curve."""
    brake = rr.load_case("adhesion_brake")
    strips = {"contact.normal": "strips", "contact.creep": "table"}
    return {
        "brake": recorded("brake", brake),
        "start": recorded("start", rr.load_case("adhesion_start").with_changes(strips), rolling_wheelsets=[2]),
        "track": recorded("track", on_track(brake), **track()),
    }
