"""The state from which a run starts: equilibrium, with the disturbances of the case.

AssembledModel, disturbances of the case -> [core] -> equilibrium -> starting state
"""

from __future__ import annotations

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


class StartError(Exception):
    """No state was found from which the run can start; the message says what to change."""


def starting_state(model: AssembledModel, *, may_drift: bool = False) -> Vector:
    """Equilibrium at the starting speed, with the disturbed coordinates prescribed at their offsets.

    An offset counts from the undisturbed equilibrium. A disturbed body keeps its equilibrium yaw unless the
    disturbance says otherwise; everything else is in equilibrium with the disturbed bodies. Where there is no such
    equilibrium (on a flange), everything else stays at the undisturbed one, and the disturbed bodies are set down:
    core/include/rollerrig/system/starting_state.hpp.

    Args:
        model: the model.
        may_drift: also of a vehicle that nothing holds along the track on its rollers.

    Raises:
        ConfigError: a disturbance moves a coordinate that is locked; nothing holds the vehicle on its rollers.
        StartError: no equilibrium was found, or no support for a disturbed body.
    """
    start = _core.starting_state(model.start_core, 0.0, disturbances(model))
    if start["found"] == "no_equilibrium":
        raise _no_equilibrium(model, start["residual"])
    if not may_drift:
        require_restraint(_core.Simulation(model.start_core), model, start["rest"])
    if start["found"] == "no_support":
        body = model.bodies[start["body"]]
        raise StartError(f"{model.case.name}: disturbance: {body} finds no support at its offset; use a smaller offset")
    return np.asarray(start["x"])


def _no_equilibrium(model: AssembledModel, residual: float) -> StartError:
    case = model.case
    where = f" in {segment}" if (segment := segment_in_words(model, 0.0)) else ""
    return StartError(
        f"{case.name}: no equilibrium at {case.motion.speed * 3.6:g} km/h{where}: {residual:.3g} N or N m remain "
        "unbalanced after Newton's method; do all wheels meet their rail or roller (gauge, back_to_back, profiles), "
        "do springs or locks carry every body, are the torques at time 0 within friction?"
    )


def equilibrium(simulation: _core.Simulation, model: AssembledModel) -> Vector:
    """State of steady running at the starting speed, undisturbed.

    Raises:
        StartError: none was found.
    """
    found = simulation.equilibrium(model.case.motion.speed, 0.0, [])
    if not found["converged"]:
        raise _no_equilibrium(model, found["residual"])
    return np.asarray(found["x"])


def disturbances(model: AssembledModel) -> list[_core.Disturbance]:
    """What the case puts off its equilibrium, coordinate by coordinate.

    Raises:
        ConfigError: a disturbance moves a coordinate that is locked.
    """
    if not model.case.disturbance:
        return []
    coordinates = _core.Simulation(model.core).coordinate_index
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
    return [_core.Disturbance(body=b, coordinate=d, offset=offset) for (b, d), offset in offsets.items()]


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
