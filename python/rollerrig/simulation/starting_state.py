"""The state from which a run starts: equilibrium, with the disturbances of the case; vehicles that would roll off are refused.

    AssembledModel, disturbances of the case -> [core] -> equilibrium -> starting state
    model, its steady rolling -> [Jacobian] -> a motion along the track that grows by itself -> refused by name

A wheel that is off the crown of its roller by d is pushed further by its own weight, with N d / (R + r). Where no restraint is
stiffer than that, the whole vehicle, or a wheelset without longitudinal suspension, rolls off. Found from the eigenvalues of the
assembled model: a spring that is too soft, or only a damper, holds no more than nothing does.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import xarray as xr

from rollerrig import _core
from rollerrig.assembly.model import AssembledModel
from rollerrig.common.arrays import Array
from rollerrig.common.linear_algebra import eigenvalues, one_blas_thread
from rollerrig.config import ConfigError, Rig
from rollerrig.config.schema.vehicle import DIRECTIONS
from rollerrig.results import Outcome, run_dataset
from rollerrig.results.termination import segment_in_words

LEAST_RATE = 0.01
"""A motion along the track that grows more slowly counts as held [1/s]: round-off and running resistance are far below it."""

LEAST_SHARE = 0.5
"""Least share of the kinetic energy that a drift has in longitudinal motion of the vehicle's bodies [1]."""

LARGEST_OFFSET = 0.1
"""A wheelset further along from the axis of its roller than this part of the sum of both radii has rolled off it [1]."""

LARGEST_START = 1e5
"""Largest coordinate and velocity of a start that the core takes [m, rad, m/s, rad/s]."""


@dataclass(frozen=True)
class Drift:
    """A motion along the track that grows without oscillating."""

    body: str  # that moves most: of a whole vehicle its heaviest one
    rate: float  # growth rate [1/s]
    whole: bool  # whether all free bodies of the vehicle go with it


def drift(simulation: _core.Simulation, model: AssembledModel, state: Array) -> Drift | None:
    """The motion with which a vehicle in steady rolling leaves its rollers; None where it is held, and on track."""
    if not isinstance(model.case.support.data, Rig):
        return None
    matrix = simulation.jacobian(0.0, state)[0]
    rates = eigenvalues(matrix)
    growing = rates.real[(np.abs(rates.imag) < LEAST_RATE) & (rates.real > LEAST_RATE)]
    drifts = (_along_track(simulation, model, matrix, rate) for rate in -np.sort(-growing))
    return next(filter(None, drifts), None)


def _along_track(simulation: _core.Simulation, model: AssembledModel, matrix: Array, rate: float) -> Drift | None:
    """The drift that belongs to a real eigenvalue; None if its motion is another one."""
    with one_blas_thread():
        values, vectors = np.linalg.eig(matrix)
    shape = np.abs(vectors[:, int(np.argmin(np.abs(values - rate)))])
    along: dict[str, float] = {}
    total = 0.0
    for name, row in zip(model.bodies, simulation.rate_index, strict=True):
        inertia = (*(model.masses[name],) * 3, *model.inertias[name])
        energy = [m * shape[index] ** 2 if index >= 0 else 0.0 for m, index in zip(inertia, row, strict=True)]
        total += sum(energy)
        if name in model.lateral_bodies and row[0] >= 0:
            along[name] = energy[0]
    if not sum(along.values()) > LEAST_SHARE * total:
        return None
    body = max(along, key=lambda name: along[name])
    speed = {name: math.sqrt(energy / model.masses[name]) for name, energy in along.items()}
    return Drift(body, rate, all(one > 0.5 * speed[body] for one in speed.values()))


def require_restraint(simulation: _core.Simulation, model: AssembledModel, state: Array) -> None:
    """Refuse a vehicle on rollers that rolls off them by itself from a state of steady rolling.

    Raises:
        ConfigError: nothing holds the vehicle, or a body of it, along the track.
    """
    found = drift(simulation, model, state)
    if found is None:
        return
    vehicle = model.case.vehicle.data.name
    loose = f"the vehicle '{vehicle}'" if found.whole else f"{found.body} of the vehicle '{vehicle}'"
    value = f"nothing holds {loose} along the track on top of the rollers"
    allowed = (
        f"it would roll off, twice as far every {math.log(2.0) / found.rate:.2g} s; needed: a coupler rod, "
        f"support.restraint, locked = ['x'] for {found.body}, or a force element with a stiffness in x to a body that is held"
    )
    raise ConfigError.of(model.case.name, "vehicle", value, allowed)


def left_the_rollers(simulation: _core.Simulation, model: AssembledModel) -> str:
    """What to say where a run has ended because a wheelset is no longer on top of its roller; '' where all are."""
    support = model.case.support.data
    if not isinstance(support, Rig):
        return ""
    state, indices = simulation.state, simulation.coordinate_index
    places = {name: indices[model.body_index(name)][0] for name in model.wheelsets}
    offsets = {name: float(state[index]) for name, index in places.items() if index >= 0}
    name = max(offsets, key=lambda one: abs(offsets[one]), default="")
    reach = LARGEST_OFFSET * (support.roller_radius + model.case.vehicle.data.wheel.radius)
    if not name or not abs(offsets[name]) > reach:
        return ""
    side = "ahead of" if offsets[name] > 0 else "behind"
    return (
        f"{name} rolled off its rollers: at the end it was {abs(offsets[name]):.2g} m {side} their axis; hold the vehicle along "
        "the track, or apply less torque."
    )


_OFFSETS = ("longitudinal", "lateral", "vertical", "roll", "pitch", "yaw")


class StartError(Exception):
    """No state was found from which the run can start; the message says what to change."""


def starting_state(model: AssembledModel, *, allow_unrestrained: bool = False) -> Array:
    """Equilibrium at the starting speed, with the disturbed coordinates prescribed at their offsets.

    An offset counts from the undisturbed equilibrium. A disturbed body keeps its equilibrium yaw unless the
    disturbance says otherwise; everything else is in equilibrium with the disturbed bodies. Where there is no such
    equilibrium (on a flange), everything else stays at the undisturbed one, and the disturbed bodies are set down:
    core/include/rollerrig/system/equilibrium.hpp.

    Args:
        model: the model.
        allow_unrestrained: also of a vehicle that nothing holds along the track on its rollers.

    Raises:
        ConfigError: a disturbance moves a coordinate that is locked; nothing holds the vehicle on its rollers.
        StartError: no equilibrium was found, or no support for a disturbed body, or the start is beyond what the core takes.
    """
    start = _core.starting_state(model.start_core, 0.0, disturbances(model))
    if start["found"] == "no_equilibrium":
        raise _no_equilibrium(model, start["residual"])
    if not allow_unrestrained:
        require_restraint(_core.Simulation(model.start_core), model, start["rest"])
    if start["found"] == "no_support":
        body = model.bodies[start["body"]]
        raise StartError(f"{model.case.name}: disturbance: {body} finds no support at its offset; use a smaller offset")
    state = np.asarray(start["x"])
    if (largest := float(np.abs(state).max())) > LARGEST_START:
        raise _out_of_reach(model, int(np.abs(state).argmax()), largest)
    return state


def _no_equilibrium(model: AssembledModel, residual: float) -> StartError:
    case = model.case
    where = f" in {segment}" if (segment := segment_in_words(model, 0.0)) else ""
    return StartError(
        f"{case.name}: no equilibrium at {case.motion.speed * 3.6:g} km/h{where}: {residual:.3g} N or N m remain "
        "unbalanced after Newton's method; do all wheels meet their rail or roller (gauge, back_to_back, profiles), "
        "do springs or locks carry every body, are the torques at time 0 within friction?"
    )


def _out_of_reach(model: AssembledModel, index: int, value: float) -> StartError:
    simulation = _core.Simulation(model.start_core)
    rows = zip(model.bodies, simulation.coordinate_index, simulation.rate_index, strict=True)
    body = next((name for name, *own in rows if any(index in each for each in own)), "an actuator")
    return StartError(
        f"{model.case.name}: {body} would start with {value:.3g} m, rad, m/s or rad/s, allowed is at most {LARGEST_START:g}; "
        "is a wheel or roller too small for the speed, or a constant torque too large for the friction?"
    )


def equilibrium(simulation: _core.Simulation, model: AssembledModel) -> Array:
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
                raise ConfigError.of(model.case.name, place, f"{offset:g}", allowed)
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
        own = zip(DIRECTIONS, coordinates, rates, strict=True)
        free[body] = [direction if coordinate >= 0 else "spin" for direction, coordinate, rate in own if rate >= 0]
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


def recorded_state(simulation: _core.Simulation, model: AssembledModel, state: Array, time: float = 0.0) -> xr.Dataset:
    """Everything a run records, of one state."""
    row = simulation.record(time, state, np.zeros(simulation.quadrature_count))
    outcome = Outcome("ok", _core.status_sentence(0), 0.0, "", {}, {})
    return run_dataset(model, np.zeros(1), np.asarray(row)[np.newaxis], outcome)
