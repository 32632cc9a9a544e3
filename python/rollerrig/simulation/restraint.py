"""Whether something holds a vehicle along the track on top of its rollers.

    model, its steady rolling -> [Jacobian] -> a motion along the track that grows by itself -> refused by name

A wheel that is off the crown of its roller by d is pushed further by its own weight, with N d / (R + r). Where no restraint is
stiffer than that, the whole vehicle, or a wheelset without longitudinal suspension, rolls off. Found from the eigenvalues of the
assembled model: a spring that is too soft, or only a damper, holds no more than nothing does.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rollerrig import _core
from rollerrig.assembly.model import AssembledModel
from rollerrig.common.blas_threads import one_blas_thread
from rollerrig.common.eigenvalues import eigenvalues
from rollerrig.config import ConfigError, ConfigProblem, Rig

Vector = NDArray[np.float64]

LEAST_RATE = 0.01
"""A motion along the track that grows more slowly counts as held [1/s]: round-off and running resistance are far below it."""

LEAST_SHARE = 0.5
"""Least share of the kinetic energy that a drift has in longitudinal motion of the vehicle's bodies [1]."""

LARGEST_OFFSET = 0.1
"""A wheelset further along from the axis of its roller than this part of the sum of both radii has rolled off it [1]."""


@dataclass(frozen=True)
class Drift:
    """A motion along the track that grows without oscillating.

    Attributes:
        body: that moves most: of a whole vehicle its heaviest one.
        rate: growth rate [1/s].
        whole: whether all free bodies of the vehicle go with it.
    """

    body: str
    rate: float
    whole: bool


def drift(simulation: _core.Simulation, model: AssembledModel, state: Vector) -> Drift | None:
    """The motion with which a vehicle rolls off its rollers; None where it is held, and on track.

    Args:
        simulation: of the model.
        model: the model.
        state: its steady rolling.
    """
    if not isinstance(model.case.support.data, Rig):
        return None
    matrix = simulation.jacobian(0.0, state)[0]
    rates = eigenvalues(matrix)
    growing = rates.real[(np.abs(rates.imag) < LEAST_RATE) & (rates.real > LEAST_RATE)]
    return next(
        (found for rate in -np.sort(-growing) if (found := _along_track(simulation, model, matrix, rate))), None
    )


def _along_track(simulation: _core.Simulation, model: AssembledModel, matrix: Vector, rate: float) -> Drift | None:
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


def require_restraint(simulation: _core.Simulation, model: AssembledModel, state: Vector) -> None:
    """Refuse a vehicle on rollers that rolls off them by itself.

    Args:
        simulation: of the model.
        model: the model.
        state: its steady rolling.

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
    raise ConfigError([ConfigProblem(model.case.name, "vehicle", value, allowed)])


def rolled_off(simulation: _core.Simulation, model: AssembledModel) -> str:
    """What to say where a run has ended because a wheelset is no longer on top of its roller; '' where all are.

    Args:
        simulation: at the end of the run.
        model: its model.
    """
    support = model.case.support.data
    if not isinstance(support, Rig):
        return ""
    state, indices = simulation.state, simulation.coordinate_index
    offsets = {
        name: float(state[index]) for name in model.wheelsets if (index := indices[model.body_index(name)][0]) >= 0
    }
    name = max(offsets, key=lambda one: abs(offsets[one]), default="")
    reach = LARGEST_OFFSET * (support.roller_radius + model.case.vehicle.data.wheel.radius)
    if not name or not abs(offsets[name]) > reach:
        return ""
    side = "ahead of" if offsets[name] > 0 else "behind"
    return (
        f"{name} rolled off its rollers: at the end it was {abs(offsets[name]):.2g} m {side} their axis; hold the vehicle along "
        "the track, or apply less torque."
    )
