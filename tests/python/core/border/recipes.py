"""Models of shipped cases as lists of calls of the builder, so that each number in them can be spoiled.

case -> assembly with a recording ModelBuilder -> [recipes] -> calls, what acts on the model, a state to start from
"""

from __future__ import annotations

import dataclasses
from typing import Any
from unittest import mock

import numpy as np

import rollerrig as rr
from rollerrig import _core
from rollerrig.assembly.actuators import assemble_with_actuators
from rollerrig.assembly.model import assemble
from rollerrig.cases import on_track
from rollerrig.simulation.mechatronics import mechatronic_setup


@dataclasses.dataclass(frozen=True)
class Recipe:
    """How a model is built, call by call, and what acts on it."""

    name: str
    gravity: float
    steps: list[tuple[str, tuple[Any, ...]]]
    setup: Any
    state: np.ndarray

    def model(self) -> Any:
        """Build the model."""
        builder = _core.ModelBuilder(gravity=self.gravity)
        for name, given in self.steps:
            getattr(builder, name)(*given)
        return builder.finish()


class _Recorder:
    """Stands for a ModelBuilder and remembers what it is told."""

    def __init__(self, gravity: float) -> None:
        self.gravity, self.steps, self.builder = gravity, [], ORIGINAL_BUILDER(gravity=gravity)

    def __getattr__(self, name: str) -> Any:
        def call(*given: Any, **named: Any) -> Any:
            if name != "finish":
                self.steps.append((name, (*given, *named.values())))
            return getattr(self.builder, name)(*given, **named)

        return call


ORIGINAL_BUILDER = _core.ModelBuilder


def recorded(name: str, case: rr.Case) -> Recipe:
    """The recipe of a case."""
    made: list[_Recorder] = []
    with mock.patch.object(_core, "ModelBuilder", lambda gravity: made.append(_Recorder(gravity)) or made[0]):
        model = assemble_with_actuators(case) if case.sampled else assemble(case)
    found = _core.Simulation(model.start_core).equilibrium(case.motion.speed, 0.0, [])
    return Recipe(name, case.gravity, made[0].steps, mechatronic_setup(model), found["x"])


def curve() -> np.ndarray:
    """Rows of a line's curvature: straight, then a curve."""
    return np.array([[0.0, 0.0, 0.0, 0.0, 0.0], [20.0, 1e-3, 0.0, 0.0, 0.0]])


def bumps() -> np.ndarray:
    """Pieces of a rail's irregularity over 40 m."""
    return np.full((40, 4), [1e-4, 0.0, 0.0, 0.0])


def recipes() -> dict[str, Recipe]:
    """A bogie that brakes on rollers, one that starts, and one that brakes on irregular track with a curve."""
    brake = rr.load_case("adhesion_brake")
    start = rr.load_case("adhesion_start").with_changes({"contact.normal": "strips", "contact.creep": "table"})
    found = {
        "brake": recorded("brake", brake),
        "start": recorded("start", start),
        "track": recorded("track", on_track(brake)),
    }
    found["track"].steps.append(("set_line", (curve(), 0.1 * curve(), 1.5)))
    found["track"].steps.append(("set_rails", 6 * (curve(),)))
    found["track"].steps.append(("set_heads", ([1, 1], curve(), [1, 1], curve(), 0.0)))
    found["track"].steps.append(("set_irregularity", (40.0, 1.0, bumps(), bumps(), bumps(), bumps(), 10.0, True)))
    found["track"].steps.append(("set_speed", ([(0.0, 30.0), (1.0, 29.0)],)))
    return found
