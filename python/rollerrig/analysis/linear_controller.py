"""The rig's controller in small motions about steady rolling, by the code that runs.

    AssembledModel -> [linear_controller] -> matrix from one sample to the next, by differences of the core's own controller
                   -> [identified_controller] -> the same of a user's class or FMU, from its answers to impulses

Rows of a matrix are states and the commands of all axles, columns states and INPUTS, each of all axles.
"""

import math

import numpy as np
from numpy.typing import NDArray

from rollerrig import _core
from rollerrig.assembly.laws import part_of
from rollerrig.assembly.model import AssembledModel
from rollerrig.cases import rig_of
from rollerrig.common.arrays import Array
from rollerrig.common.linear_algebra import one_blas_thread
from rollerrig.simulation.controllers import (
    MEASUREMENTS,
    ControllerError,
    Measurements,
    ask,
    close_controllers,
    users_controllers,
)
from rollerrig.simulation.mechatronics import rig_controller

INPUTS = ("axle_speed", "roller_speed", "roller_torque", "drive_torque", "brake_torque")
"""Measurements that small motions change."""

ACCELERATION, LARGEST_CHANGE = 0.02, 4e-5
"""Acceleration of the wheel's rim by the changes of speeds and torques over which differences are taken [m/s^2], and in one
sample [m/s]: far below adhesion, of which a long sample sees more, and far above rounding."""

UNMOVED = 1e30  # mass of a train whose acceleration by what creep leaves, nothing but rounding, is no state [kg]

SETTLED = 10  # samples after which a user's controller has begun
SAMPLES, SECONDS = 250, 0.25  # for which the answer to an impulse is used, whichever is longer
EVERY = 40  # lags of which every one is used: as long a delay has as many states
ORDER = 1e-6  # part of the largest singular value below which there is rounding
OWN_GROWTH = 1e3  # of an answer over its beginning, beyond which all else drowns in it
SMALL_AND_LARGE = 0.1, 300.0  # changes over those of the impulses under which it must be linear: up to some 0.01 rad/s
LINEAR = 1e-2  # error over the commands, RMS, with which the matrix of a linear controller predicts others


class _Controller:
    """The core's controller of a model, begun: wheels and virtual wheels roll at the case's speed."""

    def __init__(self, model: AssembledModel, law: _core.RigControl, sample: float) -> None:
        rig, case = rig_of(model.case)[0], model.case
        self.axles, step = model.wheelsets, case.time.sampling_step
        sampling = _core.Sampling(every=round(sample / step), delay=0, external=False)
        speed, wheel = case.motion.speed, case.vehicle.data.wheel.radius
        self.plant = _core.ControllerPlant(
            _core.ControllerPart(
                name=case.name,
                step=step,
                controller=_core.SampledController(sampling=sampling, controller=law),
                axles=self.axles,
                train_speed=speed,
                axle_speed=[speed / wheel] * len(self.axles),
                roller_speed=[speed / rig.roller_radius] * len(self.axles),
            )
        )
        self.plant.start()
        self.index = {variable.name: k for k, variable in enumerate(self.plant.variables)}
        self.inputs = [self.index[f"{axle}.{name}"] for name in INPUTS for axle in self.axles]
        rate, assumed = min(ACCELERATION, LARGEST_CHANGE / sample) / wheel, law.assumed
        of_roller, of_wheelset = rate * assumed.roller_inertia, rate * assumed.wheelset_inertia
        self.changes = np.repeat([rate * sample] * 2 + [of_roller] * 2 + [of_wheelset], len(self.axles))  # of INPUTS

    def measurements(self, time: float) -> Measurements:
        """What a user's controller is given beside it."""
        found: Measurements = {"time": time}
        for name in MEASUREMENTS:  # those that have no part in small motions are 0
            places = [self.index.get(f"{axle}.{name}", -1) for axle in self.axles]
            found[name] = np.nan_to_num([self.plant.get(place) for place in places])
        return found | {name: np.array(values) for name, values in self.plant.estimates.items()}


def linear_controller(model: AssembledModel, law: _core.RigControl, *, sliding: bool) -> Array:
    """Matrix of the core's controller with a model's sample time; if `sliding` the creep of its virtual rail has no slope."""
    if sliding:
        law = part_of(_core.RigControl, law, train=part_of(_core.VirtualTrain, law.train, mass=UNMOVED))
    own = _Controller(model, law, rig_of(model.case)[1].sample_time)
    if sliding:
        own.plant.set_input(own.index["train.friction_change"], -1.0)
    return np.asarray(own.plant.jacobian(list(zip(own.inputs, own.changes, strict=True))))


def identified_controller(model: AssembledModel, sample: float) -> Array:
    """Matrix of the user's controller of a model with its sample time [s], ours beside it.

    States from the singular values of the answers to impulses, at lags of all time scales: B. L. Ho, R. E. Kalman (1966).

    Raises:
        ControllerError: it fails, or has no such matrix; the message says why.
    """
    law = rig_controller(model)
    own, last = _Controller(model, law, sample), max(SAMPLES, round(SECONDS / sample))
    lags = np.union1d(np.arange(EVERY), np.geomspace(EVERY, last, 24).astype(int) - 1)  # delays, and slow motions
    impulse, units = np.eye(2 * last + 1, 1), np.eye(len(own.inputs))
    answers = np.stack([_answers(model, law, sample, impulse * unit) for unit in units], axis=2)
    if np.abs(answers[-1]).max() > OWN_GROWTH * np.abs(answers[:last]).max():
        raise ControllerError(
            f"its answer to an impulse grows by itself, more than {OWN_GROWTH:g} times in {2 * last} samples"
        )
    size = np.linalg.norm(answers, axis=(0, 1))
    if not size.any():
        raise ControllerError(
            "it answers no small change of what it measures: constant commands, a dead band or rounding"
        )
    found, acts = _realised(answers, lags), size > ORDER * size.max()
    alike = size[acts].min() / np.where(acts, size, math.inf)  # each input as much as any other
    signs = np.random.default_rng(0).choice([-1.0, 1.0], (len(impulse), len(units))) * alike
    for part in SMALL_AND_LARGE:
        others = _answers(model, law, sample, part * signs)
        error = np.linalg.norm(_predicted(found, part * signs) - others) / np.linalg.norm(others)
        if not error <= LINEAR:
            raise ControllerError(
                f"its commands are off by {100.0 * error:.3g} % from linear answers to random changes; needed: "
                f"at most {100.0 * LINEAR:g} %, without switching, rounding, dead bands, changes with time "
                f"or delays beyond {EVERY} samples"
            )
    found[:, -len(units) :] /= own.changes
    return found


def _answers(model: AssembledModel, law: _core.RigControl, sample: float, moves: Array) -> Array:
    """Commands of the user's controller over moves of its inputs, (sample, input), in their changes: shape (sample, axle)."""
    commands = []
    for signed in (moves, -moves):
        own, user = _Controller(model, law, sample), users_controllers(model.case, {})["rig_control"]
        rest = np.array([own.plant.get(index) for index in own.inputs])
        try:
            for k, row in enumerate(np.pad(signed, ((SETTLED, 0), (0, 0)))):
                for index, value in zip(own.inputs, rest + row * own.changes, strict=True):
                    own.plant.set_input(index, value)
                own.plant.advance((k + 1) * sample)
                commands.append(ask(user, "rig_control", own.measurements(k * sample)))
        finally:
            close_controllers({"rig_control": user})
    up, down = np.array(commands).reshape(2, len(moves) + SETTLED, -1)[:, SETTLED:]
    return np.asarray(0.5 * (up - down))


def _predicted(matrix: Array, moves: Array) -> Array:
    """Commands over moves of the inputs."""
    states = matrix.shape[1] - moves.shape[1]
    z, commands = np.zeros(states), []
    for row in moves:
        z, command = np.split(matrix @ np.concatenate([z, row]), [states])
        commands.append(command)
    return np.array(commands)


@one_blas_thread()
def _realised(answers: Array, lags: NDArray[np.intp]) -> Array:
    """Matrix from answers to unit impulses, shape (sample, output, input)."""
    _, outputs, inputs = answers.shape

    def after(begin: int) -> Array:
        blocks = answers[begin + lags[:, None] + lags].transpose(0, 2, 1, 3)
        return np.asarray(blocks.reshape(len(lags) * outputs, len(lags) * inputs))

    left, size, right = np.linalg.svd(after(1), full_matrices=False)
    states = int((size > ORDER * size[0]).sum())
    left, right, root = left[:, :states], right[:states].T, np.sqrt(size[:states])
    own = (left / root).T @ after(2) @ (right / root)
    given, read = (right[:inputs] * root).T, left[:outputs] * root
    return np.block([[own, given], [read, answers[0]]])
