"""Stability of the sampled loop of the roller drives: eigenvalues of the linear loop.

Loop, Plant -> [sampled_matrix] -> growth rate and frequency, gain limit

Controller and plant are the code that runs: one by differences, see linear_controller, the other by exact derivatives.
"""

import math
from dataclasses import dataclass

import numpy as np
from scipy.linalg import expm

from rollerrig import _core
from rollerrig.analysis.control_loop import Loop
from rollerrig.analysis.linear_bench import torque_loop
from rollerrig.analysis.modes import DIRECTIONS
from rollerrig.assembly.model import assemble
from rollerrig.cases import without_actuators
from rollerrig.common.arrays import Array
from rollerrig.common.linear_algebra import one_blas_thread
from rollerrig.config import Case, Rig
from rollerrig.simulation.starting_state import starting_state

NEUTRAL = 1e-6
"""Eigenvalues so near to 1 are neutral: double ones, as of an angle and its speed, are found to the root of rounding."""

ABOVE = 10.0  # the slow motions of bogie and loop, which are damped, stay below this frequency [Hz]


@dataclass(frozen=True)
class Plant:
    """x' = A x + B u of wheels and rollers under the torques u of the roller drives."""

    matrix: Array  # A, shape (state, state)
    torque: Array  # B, shape (state, axle)
    # wheel, roller: speeds of axles and rollers, positive forward, from x: shape (axle, state)
    wheel: Array
    roller: Array
    brake: Array  # torque of the brakes from x, which a controller knows from pressure and speed: shape (axle, state)


def rolling_plant(loop: Loop, brake: float = 0.0) -> Plant:
    """Axles alone, each with its roller, (D1) and (D2), between them the creep of the loop.

    Of a brake that holds a locked wheel, the slope of its torque over the axle's speed [N m s/rad].
    """
    wheel = loop.wheel
    r, R = wheel.wheel_radius, wheel.roller_radius
    force = loop.creep * np.array([r, -R])  # T over (w, W)
    held = np.array([brake, 0.0])
    matrix = np.stack([-(r * force + held) / wheel.wheelset_inertia, R * force / wheel.roller_inertia])
    torque = np.array([[0.0], [1.0 / wheel.roller_inertia]])
    of_one = (matrix, torque, np.array([[1.0, 0.0]]), np.array([[0.0, 1.0]]), -held[None, :])
    return Plant(*(np.kron(np.eye(loop.axles), part) for part in of_one))


def vehicle_plant(case: Case) -> Plant:
    """The whole vehicle on its rollers, which turn freely: the core's exact linearisation at the start; StartError: none."""
    model = assemble(without_actuators(case))
    simulation = _core.Simulation(model.core)
    matrix = np.array(simulation.jacobian(0.0, np.asarray(starting_state(model)))[0])
    spin = DIRECTIONS.index("pitch")
    rows = [simulation.rate_index[model.body_index(name)][spin] for name in (*model.wheelsets, *model.rollers)]
    reads = np.eye(len(matrix))[rows]
    wheel, roller = reads[: len(model.wheelsets)], -reads[len(model.wheelsets) :]
    rig = case.support.data
    assert isinstance(rig, Rig)
    return Plant(matrix, roller.T / rig.roller_inertia[1], wheel, roller, np.zeros_like(wheel))


@one_blas_thread()
def sampled_matrix(loop: Loop, plant: Plant) -> Array:
    """Matrix from the state at one sample to that at the next, shape (state, state).

    The state is the plant's, those of the drives and of the controller, then per axle the mean torque over the last sampling step
    and the commands that act or wait.
    """
    axles = plant.torque.shape[1]
    drive, driven, read = (
        np.kron(np.eye(axles), part) for part in torque_loop(loop.drive_bandwidth, loop.drive_damping)
    )
    moving = np.block([[plant.matrix, plant.torque @ read], [np.zeros((len(drive), len(plant.matrix))), drive]])
    n, states = len(moving), len(loop.controller) - axles
    rates = np.zeros((n + axles, n + axles))
    rates[:n, :n], rates[n - len(drive) : n, n:] = moving, driven
    step = expm(loop.step * rates)  # under constant commands

    unit = np.eye(n + states + axles * (2 + round(loop.delay / loop.step)))
    x, z, rest = np.split(unit, [n, n + states])
    mean, *queue = rest.reshape(-1, axles, len(unit))
    bodies, torque = x[: len(plant.matrix)], read @ x[-len(drive) :]
    inputs = [plant.wheel @ bodies, plant.roller @ bodies, mean, torque, plant.brake @ bodies]  # INPUTS
    z, command = np.split(loop.controller @ np.concatenate([z, *inputs]), [states])
    for _ in range(round(loop.sample / loop.step)):
        queue, before = [*queue, command][1:], torque
        x = (step @ np.concatenate([x, queue[0]]))[:n]
        torque = read @ x[-len(drive) :]
        mean = 0.5 * (before + torque)
    return np.concatenate([x, z, mean, *queue])


def growth(loop: Loop, plant: Plant, above: float = 0.0) -> tuple[float, float]:
    """Rate [1/s] and frequency [Hz] of the least damped motion; a rate above zero: the loop is unstable.

    Only motions of a frequency `above` count [Hz]; NaN where there is none. Those that neither grow nor decay are left out:
    angles turned, the common speed of train and wheels, an integral without a gain.
    """
    return _least_damped(_acting(sampled_matrix(loop, plant))[0], loop.sample, above)


def _acting(matrix: Array, *others: Array) -> list[Array]:
    """Matrices without the states that in the first one act on none, or on such alone: they only accumulate what others do."""
    kept = np.arange(len(matrix))
    while True:
        acts = matrix[np.ix_(kept, kept)]
        np.fill_diagonal(acts, 0.0)
        if acts.any(axis=0).all():
            return [one[np.ix_(kept, kept)] for one in (matrix, *others)]
        kept = kept[acts.any(axis=0)]


@one_blas_thread()
def _least_damped(matrix: Array, sample: float, above: float) -> tuple[float, float]:
    values = np.linalg.eigvals(matrix)
    values = values[(np.abs(values - 1.0) > NEUTRAL) & (np.abs(values) > 1e-12)]
    values = values[np.abs(np.angle(values)) >= 2.0 * math.pi * sample * above]
    if not values.size:
        return math.nan, math.nan
    largest = values[np.argmax(np.abs(values))]
    return math.log(abs(largest)) / sample, abs(float(np.angle(largest))) / (2.0 * math.pi * sample)


def gain_limit(loop: Loop, plant: Plant, highest: float = 1e4) -> float:
    """Factor on the feedback's gains from which the sampled loop is unstable; NaN: not up to `highest`, 0: as it is."""
    from scipy.optimize import brentq  # slow to load, and seldom needed

    if loop.proportional == loop.integral == 0.0:
        return math.nan
    as_is, doubled = _acting(*(sampled_matrix(loop.scaled(factor), plant) for factor in (1.0, 2.0)))

    def rate(log_factor: float) -> float:
        return _least_damped(as_is + (math.exp(log_factor) - 1.0) * (doubled - as_is), loop.sample, 0.0)[0]

    factors = np.linspace(0.0, math.log(highest), 80)
    if rate(0.0) > 0.0:
        return 0.0
    for low, high in zip(factors[:-1], factors[1:], strict=True):
        if rate(high) > 0.0:
            return math.exp(float(brentq(rate, low, high, xtol=1e-4)))
    return math.nan
