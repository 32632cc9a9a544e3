"""Linearisation at the rolling equilibrium, with the core's exact derivatives.

    Case, running speed -> [linearise] -> A of x' = A x around steady rolling, names of the states

The rollers (or the rails) are speed-controlled: the rates of driven rollers are inputs, not states, and are taken out of A.
Equations: docs/theory/equilibrium_and_linearisation.md, (L3)-(L4).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rollerrig import _core
from rollerrig.assembly.model import AssembledModel, assemble
from rollerrig.cases import at_speed
from rollerrig.config import Case
from rollerrig.simulation.starting_state import StartError

Matrix = NDArray[np.float64]

DIRECTIONS = ("longitudinal", "lateral", "vertical", "roll", "pitch", "yaw")
"""Words for the six coordinates of a body, in the core's order."""


@dataclass(frozen=True)
class Linearisation:
    """x' = A x for small motions around steady rolling.

    Attributes:
        speed: running speed [m/s].
        matrix: A, shape (states, states).
        equilibrium: all states of the core at the equilibrium, driven rates included.
        rate_rows: per moving body coordinate (body, direction), the row of its rate in A.
        inertia: mass [kg] or moment of inertia [kg m^2] that belongs to each of them.
    """

    speed: float
    matrix: Matrix
    equilibrium: Matrix
    rate_rows: dict[tuple[str, str], int]
    inertia: dict[tuple[str, str], float]


class Lineariser:
    """One assembled model, linearised at any number of speeds.

    Each speed starts from the equilibrium of the one before: neighbouring speeds in order are fastest.
    """

    def __init__(self, case: Case) -> None:
        self.case = at_speed(case)
        self.model = assemble(self.case)
        simulation = _core.Simulation(self.model.core)
        self._inertia = _inertias(self.model)
        self._near: Matrix | None = None
        driven = {simulation.rate_index[self.model.body_index(name)][4] for name in self.model.rollers}
        self._kept = np.array([i for i in range(simulation.state_count) if i not in driven])
        row_of = {int(state_index): row for row, state_index in enumerate(self._kept)}
        self._rows = {
            (body, direction): row_of[simulation.rate_index[b][d]]
            for b, body in enumerate(self.model.bodies)
            for d, direction in enumerate(DIRECTIONS)
            if simulation.rate_index[b][d] in row_of
        }

    def simulation_at(self, speed: float) -> _core.Simulation:
        """A simulation of the model whose rails run at this speed [m/s]; rollers take theirs from the state."""
        return _core.Simulation(self.model.core.with_speed([(0.0, speed)]))

    def at(self, speed: float) -> Linearisation:
        """Linearise at a running speed.

        Args:
            speed: running speed [m/s].

        Raises:
            StartError: no rolling equilibrium was found at this speed.
        """
        simulation = self.simulation_at(speed)
        found = simulation.equilibrium(speed, 0.0, [], self._near)
        if not found["converged"]:
            raise StartError(
                f"{self.case.name}: no rolling equilibrium at {3.6 * speed:g} km/h: {found['residual']:.3g} N or N m remain "
                "unbalanced; check gauge, profiles and torques with `rollerrig check`; a whole vehicle on track needs "
                "something that holds it in x, e.g. locked = ['x'] for its car body"
            )
        state = np.ascontiguousarray(found["x"], dtype=np.float64)
        self._near = state
        full = simulation.jacobian(0.0, state)[0]
        inertia = {key: self._inertia[key] for key in self._rows}
        return Linearisation(speed, np.array(full[np.ix_(self._kept, self._kept)]), state, self._rows, inertia)


def linearise(case: Case, speed: float) -> Linearisation:
    """Linearise a case at one running speed; see `Lineariser` for many.

    Args:
        case: the case; its rollers or rails are speed-controlled.
        speed: running speed [m/s].

    Raises:
        StartError: no rolling equilibrium was found at this speed.
    """
    return Lineariser(case).at(speed)


def _inertias(model: AssembledModel) -> dict[tuple[str, str], float]:
    return {
        (body, direction): value
        for body, mass in model.masses.items()
        for direction, value in zip(DIRECTIONS, (mass, mass, mass, *model.inertias[body]), strict=True)
    }
