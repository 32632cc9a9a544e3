"""The state from which a run starts: equilibrium, with the disturbances of the case.

AssembledModel -> [Newton's method in the core] -> equilibrium -> starting state
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from rollerrig import _core
from rollerrig.config import ConfigError, ConfigProblem
from rollerrig.config.vehicle import DIRECTIONS
from rollerrig.model import AssembledModel
from rollerrig.results import Outcome, run_dataset

Vector = NDArray[np.float64]

_OFFSETS = ("longitudinal", "lateral", "vertical", "roll", "pitch", "yaw")


class StartError(Exception):
    """No state was found from which the run can start; the message says what to change."""


def starting_state(simulation: _core.Simulation, model: AssembledModel) -> Vector:
    """Equilibrium at the starting speed, with the case's disturbances held at their offsets.

    An offset counts from the undisturbed equilibrium. A disturbed body keeps its equilibrium yaw unless the
    disturbance says otherwise; everything else is in equilibrium with the disturbed bodies.

    Raises:
        ConfigError: a disturbance moves a coordinate that is held.
        StartError: no equilibrium was found.
    """
    case = model.case
    rest = equilibrium(simulation, model)
    held = list(_held_coordinates(simulation, model, rest))
    if not held:
        return rest
    found = simulation.equilibrium(case.motion.speed, 0.0, held)
    if found["converged"]:
        return _state(found)
    # Far from equilibrium the others may have none: leave them where they were, and set the disturbed bodies down.
    disturbed = {body for body, _, _ in held}
    others = [
        (body, direction, float(rest[index]))
        for body, row in enumerate(simulation.coordinate_index)
        for direction, index in enumerate(row)
        if index >= 0 and body not in disturbed
    ]
    found = simulation.equilibrium(case.motion.speed, 0.0, [*held, *others])
    if not found["converged"]:
        names = ", ".join(sorted({d.body for d in case.disturbance}))
        raise StartError(
            f"{case.name}: disturbance: no equilibrium with {names} held at the offset; {found['residual']:.3g} N remain "
            f"unbalanced; use a smaller offset"
        )
    return _state(found)


def equilibrium(simulation: _core.Simulation, model: AssembledModel) -> Vector:
    """State of steady running at the starting speed, undisturbed.

    Raises:
        StartError: none was found.
    """
    case = model.case
    found = simulation.equilibrium(case.motion.speed, 0.0, [])
    if not found["converged"]:
        raise StartError(
            f"{case.name}: no equilibrium at {case.motion.speed * 3.6:g} km/h: {found['residual']:.3g} N or N m remain "
            "unbalanced after Newton's method; do all wheels meet their rail or roller (gauge, back_to_back, profiles), "
            "do springs or locks carry every body, are the torques at time 0 within friction?"
        )
    return _state(found)


def _state(found: dict[str, object]) -> Vector:
    return np.ascontiguousarray(found["x"], dtype=np.float64)


def _held_coordinates(
    simulation: _core.Simulation, model: AssembledModel, rest: Vector
) -> Iterator[tuple[int, int, float]]:
    offsets: dict[tuple[int, int], float] = {}
    for number, disturbance in enumerate(model.case.disturbance):
        body = model.body_index(disturbance.body)
        given = {name: getattr(disturbance, name) for name in _OFFSETS if getattr(disturbance, name) != 0.0}
        for name, offset in given.items():
            direction = _OFFSETS.index(name)
            if simulation.coordinate_index[body][direction] < 0:
                place = f"disturbance[{number}].{name}"
                allowed = f"allowed: only 0, {disturbance.body} is locked or turns freely in {DIRECTIONS[direction]}"
                raise ConfigError([ConfigProblem(model.case.name, place, f"{offset:g}", allowed)])
            offsets[body, direction] = offsets.get((body, direction), 0.0) + offset
        yaw = DIRECTIONS.index("yaw")
        if given and simulation.coordinate_index[body][yaw] >= 0:
            offsets.setdefault((body, yaw), 0.0)
    for (body, direction), offset in offsets.items():
        yield body, direction, float(rest[simulation.coordinate_index[body][direction]]) + offset


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
        StartError: no equilibrium was found.
    """
    simulation = _core.Simulation(model.core)
    state = equilibrium(simulation, model)
    row = simulation.record(0.0, state, np.zeros(simulation.quadrature_count))
    outcome = Outcome("ok", _core.status_sentence(0), 0.0, "", {}, {})
    return run_dataset(model, np.zeros(1), np.asarray(row)[np.newaxis], outcome)
