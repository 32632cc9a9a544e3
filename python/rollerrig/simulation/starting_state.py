"""The state from which a run starts: equilibrium, with the disturbances of the case.

AssembledModel -> [Newton's method in the core] -> equilibrium -> starting state
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from rollerrig import _core
from rollerrig.assembly.model import AssembledModel
from rollerrig.config import ConfigError, ConfigProblem
from rollerrig.config.schema.vehicle import DIRECTIONS
from rollerrig.results import Outcome, run_dataset
from rollerrig.results.termination import segment_in_words
from rollerrig.simulation.restraint import require_restraint

Vector = NDArray[np.float64]

_OFFSETS = ("longitudinal", "lateral", "vertical", "roll", "pitch", "yaw")
_SET_DOWN_REACH = 0.03  # [m]


class StartError(Exception):
    """No state was found from which the run can start; the message says what to change."""


def starting_state(simulation: _core.Simulation, model: AssembledModel, *, may_drift: bool = False) -> Vector:
    """Equilibrium at the starting speed, with the disturbed coordinates prescribed at their offsets.

    An offset counts from the undisturbed equilibrium. A disturbed body keeps its equilibrium yaw unless the
    disturbance says otherwise; everything else is in equilibrium with the disturbed bodies. Where there is no such
    equilibrium (on a flange), everything else stays at the undisturbed one, and the disturbed bodies are set down.

    Args:
        simulation: of the model.
        model: the model.
        may_drift: also of a vehicle that nothing holds along the track on its rollers.

    Raises:
        ConfigError: a disturbance moves a coordinate that is locked; nothing holds the vehicle on its rollers.
        StartError: no equilibrium was found, or no support for a disturbed body.
    """
    case = model.case
    rest = equilibrium(simulation, model)
    if not may_drift:
        require_restraint(simulation, model, rest)
    prescribed = list(prescribed_coordinates(simulation, model, rest))
    if not prescribed:
        return rest
    coordinates = simulation.coordinate_index
    disturbed = {body for body, _, _ in prescribed}

    def others() -> list[tuple[int, int, float]]:
        return [
            (body, direction, float(rest[index]))
            for body, row in enumerate(coordinates)
            for direction, index in enumerate(row)
            if index >= 0 and body not in disturbed
        ]

    # Far from equilibrium the others may have none: leave them where they were, and set the disturbed bodies down.
    for more in (list, others):
        found = simulation.equilibrium(case.motion.speed, 0.0, [*prescribed, *more()], rest)
        state = _state(found)
        # The core stands a wheelset on its rollers to begin with, even where a disturbance lifts it.
        kept = all(state[coordinates[body][direction]] == value for body, direction, value in prescribed)
        if found["converged"] and kept:
            return state
    for body, direction, value in prescribed:
        rest[coordinates[body][direction]] = value
    vertical = DIRECTIONS.index("z")
    for body in sorted(disturbed - {b for b, d, _ in prescribed if d == vertical}):
        _set_down(simulation, model, rest, body)
    return rest


def _set_down(simulation: _core.Simulation, model: AssembledModel, state: Vector, body: int) -> None:
    """Move a body up or down to where no vertical acceleration is left; changes the state.

    Raises:
        StartError: it floats or sinks everywhere within 30 mm of where it was.
    """
    place = simulation.coordinate_index[body][DIRECTIONS.index("z")]
    if place < 0:
        return
    rate = simulation.rate_index[body][DIRECTIONS.index("z")]
    here = float(state[place])

    def acceleration(height: float) -> float:
        state[place] = here + height
        return float(simulation.derivative(0.0, state)[0][rate])

    from scipy.optimize import brentq

    if not acceleration(-_SET_DOWN_REACH) > 0.0 > acceleration(_SET_DOWN_REACH):
        raise StartError(
            f"{model.case.name}: disturbance: {model.bodies[body]} finds no support at its offset; use a smaller offset"
        )
    state[place] = here + brentq(acceleration, -_SET_DOWN_REACH, _SET_DOWN_REACH, xtol=1e-12)


def equilibrium(simulation: _core.Simulation, model: AssembledModel) -> Vector:
    """State of steady running at the starting speed, undisturbed.

    Raises:
        StartError: none was found.
    """
    case = model.case
    found = simulation.equilibrium(case.motion.speed, 0.0, [])
    if not found["converged"]:
        where = f" in {segment}" if (segment := segment_in_words(model, 0.0)) else ""
        raise StartError(
            f"{case.name}: no equilibrium at {case.motion.speed * 3.6:g} km/h{where}: {found['residual']:.3g} N or N m remain "
            "unbalanced after Newton's method; do all wheels meet their rail or roller (gauge, back_to_back, profiles), "
            "do springs or locks carry every body, are the torques at time 0 within friction?"
        )
    return _state(found)


def _state(found: dict[str, object]) -> Vector:
    return np.ascontiguousarray(found["x"], dtype=np.float64)


def prescribed_coordinates(
    simulation: _core.Simulation, model: AssembledModel, rest: Vector
) -> Iterator[tuple[int, int, float]]:
    """Body, direction and value of each coordinate that the case puts off its equilibrium.

    Raises:
        ConfigError: a disturbance moves a coordinate that is locked.
    """
    coordinates = simulation.coordinate_index
    offsets: dict[tuple[int, int], float] = {}
    for number, disturbance in enumerate(model.case.disturbance):
        body = model.body_index(disturbance.body)
        given = {name: getattr(disturbance, name) for name in _OFFSETS if getattr(disturbance, name) != 0.0}
        for name, offset in given.items():
            direction = _OFFSETS.index(name)
            if coordinates[body][direction] < 0:
                place = f"disturbance[{number}].{name}"
                allowed = f"allowed: only 0, {disturbance.body} is locked or turns freely in {DIRECTIONS[direction]}"
                raise ConfigError([ConfigProblem(model.case.name, place, f"{offset:g}", allowed)])
            offsets[body, direction] = offset
        yaw = DIRECTIONS.index("yaw")
        if given and coordinates[body][yaw] >= 0:
            offsets.setdefault((body, yaw), 0.0)
    for (body, direction), offset in offsets.items():
        yield body, direction, float(rest[coordinates[body][direction]]) + offset


def degrees_of_freedom(model: AssembledModel) -> dict[str, list[str]]:
    """Free directions of each body; a wheelset or roller that turns freely has `spin` in place of `pitch`."""
    simulation = _core.Simulation(model.core)
    free: dict[str, list[str]] = {}
    for body, coordinates, rates in zip(model.bodies, simulation.coordinate_index, simulation.rate_index, strict=True):
        free[body] = [
            direction if coordinate >= 0 else "spin"
            for direction, coordinate, rate in zip(DIRECTIONS, coordinates, rates, strict=True)
            if rate >= 0
        ]
    return free


def equilibrium_dataset(model: AssembledModel) -> xr.Dataset:
    """Everything a run records, once, in undisturbed steady running at the starting speed.

    Raises:
        ConfigError: nothing holds the vehicle along the track on its rollers.
        StartError: no equilibrium was found.
    """
    simulation = _core.Simulation(model.core)
    rest = equilibrium(simulation, model)
    require_restraint(simulation, model, rest)
    return recorded_state(simulation, model, rest)


def recorded_state(simulation: _core.Simulation, model: AssembledModel, state: Vector, time: float = 0.0) -> xr.Dataset:
    """Everything a run records, of one state."""
    row = simulation.record(time, state, np.zeros(simulation.quadrature_count))
    outcome = Outcome("ok", _core.status_sentence(0), 0.0, "", {}, {})
    return run_dataset(model, np.zeros(1), np.asarray(row)[np.newaxis], outcome)
