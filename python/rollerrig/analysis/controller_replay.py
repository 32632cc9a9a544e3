"""The rig's controller on the log of a rig: its estimates and virtual train, what an estimate is off by, where it is wrong.

Case, log of a rig -> [replay] -> the core's controller, sample by sample: virtual train, torques of the drives
    -> estimates of force and torque, as the rig has them at the instant and without their delay, with bands of 95 %
    -> samples whose estimate is not to be relied on, and why

An estimate is late by its delay. The rows that follow say what it was late for: without the delay it is that of a later sample.
What is left then is noise of the sensors and what the estimator filters away. The former follows from the sensors of the case
and the estimator's impulse responses; the latter is about what the estimator loses of its own result (Tukey's twicing).
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import xarray as xr
from scipy.integrate import cumulative_trapezoid
from scipy.ndimage import uniform_filter1d
from scipy.signal import fftconvolve

from rollerrig import _core
from rollerrig.analysis.rig_log import means
from rollerrig.assembly.actuators import assemble_with_actuators
from rollerrig.assembly.laws import angular, part_of
from rollerrig.cases import rig_of
from rollerrig.common.arrays import Array, Mask
from rollerrig.config import Case
from rollerrig.config.schema.rig_control import BandwidthEstimator, Encoder, RigControl
from rollerrig.interfaces.plant import controller_part
from rollerrig.results import variable
from rollerrig.results.run_info import ResultsError
from rollerrig.simulation.mechatronics import assumed_parameters, estimator, estimator_response

NORMAL = 1.96  # half width of the interval of 95 % in standard deviations
FORGOTTEN, LONGEST = 1e-4, 400_000  # part of an error at the start that no longer counts [-], at most so many samples
LATE = 0.05  # part of the largest force or torque by which an estimate may be off before it is named
CLEAR = 6.0  # standard deviations of noise beyond which a difference is not due to the sensors

LEAST_TORQUE = 0.01
"""Least torque of an axle, known or found, over its load and wheel radius, from which signs of torques show [-]; not below the
noise of the sensors either."""

AT_LIMIT = 0.99  # part of a limit from which on a drive is at it [-]
JOINED = 0.1  # pauses shorter than this do not part two episodes [s]

REASONS = {
    "start": "the estimator settles, or no later rows are left",
    "late": "the force changes faster than the estimator follows",
    "torque": "the torque found is not that of brake and motor",
    "limit": "the drive is at its limit",
    "sliding": "the wheel slides on its roller",
    "locked": "the wheel stands: the torque of its brake is a reaction",
}
"""Why an estimate is not to be relied on."""


@dataclass(frozen=True)
class _Estimator:
    """The estimator of a case."""

    law: Any  # of _core.estimators
    assumed: _core.AssumedParameters
    bandwidth: float  # [rad/s]
    sample: float  # [s]
    delay: Array  # of force and torque, with exact sensors [samples]
    sensor_delay: float  # of the measured speeds [samples]

    @cached_property
    def memory(self) -> int:
        """Samples after which FORGOTTEN of the answers to impulses is left, of the slowest estimators LONGEST."""
        length = min(math.ceil(1e3 / (self.bandwidth * self.sample)), LONGEST)
        impulses = np.zeros((3, length, 3))  # of one quantity each
        impulses[range(3), 0, range(3)] = 1.0
        answers = np.abs(self.run(*impulses))
        left = (answers > FORGOTTEN * answers.max(axis=1, keepdims=True)).any(axis=(0, 2))
        return int(np.flatnonzero(left)[-1]) + 1

    def run(self, roller_speed: Array, wheel_speed: Array, torque: Array) -> Array:
        """Force and torque as estimated, shape (2, time, axle)."""
        samples = np.stack([roller_speed, wheel_speed, torque], axis=2).transpose(1, 0, 2)
        axles = [_core.estimate(self.law, self.assumed, self.sample, np.ascontiguousarray(axle)) for axle in samples]
        return np.stack(axles, axis=2).transpose(1, 0, 2)

    def without_delay(self, estimate: Array, sensors: float) -> Array:
        """Force and torque of later samples, the last one held; `sensors`: delay beside that of the estimator [samples]."""
        count = estimate.shape[1]
        later = (np.minimum(np.arange(count) + round(delay + sensors), count - 1) for delay in self.delay)
        return np.stack([one[rows] for one, rows in zip(estimate, later, strict=True)])

    def estimate_of(self, force: Array, torque: Array) -> Array:
        """Its estimates of a force and a torque that act, (D1), (D2), without the delay, shape (2, time, axle)."""
        p, h = self.assumed, self.sample
        rates = p.roller_radius * force / p.roller_inertia, (torque - p.wheel_radius * force) / p.wheelset_inertia
        roller, wheel = (cumulative_trapezoid(rate, dx=h, axis=0, initial=0) for rate in rates)
        return self.without_delay(self.run(roller, wheel, np.zeros_like(force)), 0.0)

    def found_and_lost(self, roller_speed: Array, wheel_speed: Array, torque: Array) -> tuple[Array, Array]:
        """Force and torque without the delay, and the part of them that the estimator loses, each (2, time, axle)."""
        found = self.without_delay(self.run(roller_speed, wheel_speed, torque), self.sensor_delay)
        return found, found - self.estimate_of(*found)

    def noise(self, case: Case) -> tuple[Array, Array]:
        """Standard deviations of both through noise and steps of the sensors, each of force and torque, shape (2,)."""
        length = 3 * self.memory
        impulses = np.zeros((3, length, 3))  # of one quantity each
        impulses[range(3), self.memory, range(3)] = 1.0
        variances = np.zeros((2, 2))
        for answers, sums in zip(self.found_and_lost(*impulses), variances, strict=True):
            for source, (response, variance) in enumerate(_sensor_noise(case, self.sample)):
                sums += variance * (fftconvolve(answers[:, :, source], response[None, :], axes=1) ** 2).sum(axis=1)
        found, lost = np.sqrt(variances)
        return found, lost


def _sensor_noise(case: Case, sample: float) -> Iterator[tuple[Array, float]]:
    """Reading of a unit of white noise and variance of that noise: speeds of roller and wheel, torque of the drive."""
    for sensor in (case.sensors.rollers, case.sensors.axles):
        response, variance = np.zeros(1), 0.0
        if isinstance(sensor, Encoder) and sensor.counts > 0.0:
            response = np.zeros(sensor.window + 1)
            response[0], response[-1] = 1.0, -1.0
            count = 2.0 * math.pi / (sensor.counts * sensor.window * sample)
            variance = (sensor.jitter**2 + 1.0 / 12.0) * count**2
        yield response, variance
    flange = case.sensors.roller_torque
    variance = flange.noise**2 + flange.resolution**2 / 12.0 if flange is not None else 0.0
    yield np.array([0.5, 0.5]), variance


def replay(case: Case, log: xr.Dataset) -> xr.Dataset:
    """Run the rig's controller of a case on the log of a rig.

    Args:
        case: with [rig_control].
        log: of `rollerrig.analysis.rig_log.read_rig_log`.

    Returns:
        The log, and over `time` and `axle`: `force_at_once`, `torque_at_once` and `torque_taken` as the rig has them at the
        instant; `force`, `torque` without their delay, half widths `force_band`, `torque_band` of their intervals, which
        hold 95 % where the sensors of the case have noise; `torque_known` of brake and motor, and `torque_expected`, the same as
        the estimator would find it; `virtual_axle_speed`, `drive_command`. `train_speed` (time) of the virtual train; `doubtful`
        (reason, time, axle), see REASONS; `axle_load` (axle).
        Attributes: `force_noise`, `torque_noise`, `force_delay_s`, `torque_delay_s`.

    Raises:
        ConfigError: the case has no such controller of ours.
        ResultsError: the torques of drive and brake contradict each other.
        StartError: the case finds no equilibrium to start from.
    """
    estimator, part = _estimator_of(case), controller_part(case, "rig_control")
    law = part.controller.controller
    assert isinstance(law, _core.RigControl)
    found = _estimates(case, log, estimator).assign_coords(axle_load=("axle", np.array(law.train.static_load)))
    _check_signs(found, estimator.assumed.wheel_radius)
    doubtful = _doubtful(case, found, estimator)
    found["doubtful"] = (("reason", "time", "axle"), np.stack(list(doubtful.values())))
    return found.assign_coords(reason=list(doubtful)).assign(_controller(part, log))


def _estimates(case: Case, log: xr.Dataset, estimator: _Estimator) -> xr.Dataset:
    """The log with what the estimator finds, at the instant and without its delay, and what is known of the torques."""
    known = np.zeros(log["axle_speed"].shape)
    for name in ("brake_torque", "motor_torque"):
        known = known + (log[name].to_numpy() if name in log else 0.0)
    roller, wheel, mean_torque = (log[name].to_numpy() for name in ("roller_speed", "axle_speed", "roller_torque"))
    at_once = estimator.run(roller, wheel, mean_torque)
    (force, torque), lost = estimator.found_and_lost(roller, wheel, mean_torque)
    noise, of_lost = estimator.noise(case)
    window = round(2.0 * math.pi / (estimator.bandwidth * estimator.sample))
    rest = uniform_filter1d(lost**2, window, axis=1, mode="nearest") - (of_lost**2)[:, None, None]
    band = NORMAL * np.sqrt((noise**2)[:, None, None] + np.maximum(rest, 0.0))
    data = {
        "force_at_once": ("N", "force on the axle as estimated at the instant, forward", at_once[0]),
        "torque_at_once": ("N m", "torque on the axle as estimated at the instant", at_once[1]),
        "force": ("N", "force on the axle without the delay of its estimate, forward", force),
        "torque": ("N m", "torque on the axle without the delay of its estimate", torque),
        "force_band": ("N", "half width of the interval of 95 % of the force", band[0]),
        "torque_band": ("N m", "half width of the interval of 95 % of the torque", band[1]),
        "torque_known": ("N m", "torque of brake and motor on the axle", known),
        "torque_expected": ("N m", "the same as the estimator would find it", estimator.estimate_of(force, known)[1]),
    }
    delay = (estimator.delay + estimator.sensor_delay) * estimator.sample
    return log.assign(
        {name: variable(("time", "axle"), values, unit, text) for name, (unit, text, values) in data.items()}
    ).assign_attrs(force_noise=noise[0], torque_noise=noise[1], force_delay_s=delay[0], torque_delay_s=delay[1])


def _estimator_of(case: Case) -> _Estimator:
    model, control = assemble_with_actuators(case), rig_of(case)[1]
    assert isinstance(control.estimator, BandwidthEstimator)
    delay = np.array([late for _, late in estimator_response(model).values()]) / control.sample_time
    rollers = case.sensors.rollers  # an encoder's speed is a mean over its window
    mean_over = rollers.window if isinstance(rollers, Encoder) and rollers.counts > 0.0 else 0
    return _Estimator(
        law=estimator(control),
        assumed=assumed_parameters(model),
        bandwidth=angular(control.estimator.bandwidth),
        sample=control.sample_time,
        delay=delay,
        sensor_delay=0.5 * mean_over,
    )


def _controller(part: _core.ControllerPart, log: xr.Dataset) -> dict[str, tuple]:  # type: ignore[type-arg]
    """The core's controller on the log: torques and speeds of the virtual axles, commands of the drives, speed of the train."""
    speeds = {name: log[name].to_numpy()[0].tolist() for name in ("axle_speed", "roller_speed")}
    started = part_of(_core.ControllerPart, part, train_speed=log.attrs["train_speed"], **speeds)
    plant = _core.ControllerPlant(started)
    plant.start()
    index = {(one.name, one.causality): number for number, one in enumerate(plant.variables)}
    inputs = {
        number: log[str(name)].sel(axle=axle).to_numpy()
        for name in log.data_vars
        for axle in part.axles
        for owner in (axle, "train")
        if (number := index.get((f"{owner}.{name}", "input"))) is not None
    }
    names = [f"{axle}.{name}" for name in ("virtual_speed", "roller_torque_command") for axle in part.axles]
    outputs = [index[name, "output"] for name in (*names, "train.speed")]
    found, taken = np.empty((log.sizes["time"], len(outputs))), np.empty(log["axle_speed"].shape)
    for k, row in enumerate(np.stack(list(inputs.values()), axis=1).tolist()):
        for number, value in zip(inputs, row, strict=True):
            plant.set_input(number, value)
        plant.advance((k + 1) * plant.period)
        found[k] = [plant.get(number) for number in outputs]
        taken[k] = plant.estimates["estimated_torque"]
    axles = len(part.axles)
    return {
        "torque_taken": variable(("time", "axle"), taken, "N m", "torque on the axle that the virtual train takes"),
        "virtual_axle_speed": variable(("time", "axle"), found[:, :axles], "rad/s", "speed of the virtual axle"),
        "drive_command": variable(("time", "axle"), found[:, axles:-1], "N m", "command of the roller's drive"),
        "train_speed": variable("time", found[:, -1], "m/s", "of the virtual train"),
    }


def _doubtful(case: Case, found: xr.Dataset, estimator: _Estimator) -> dict[str, Mask]:
    """Samples whose estimate is not to be relied on, by REASONS, shape (time, axle)."""
    control, p, memory = rig_of(case)[1], estimator.assumed, estimator.memory
    wheel, roller = p.wheel_radius * found["axle_speed"].to_numpy(), p.roller_radius * found["roller_speed"].to_numpy()

    def off(one: str, other: str, noise: str) -> Mask:
        largest = float(np.abs(found[other][memory:]).max())
        difference = np.abs(found[one].to_numpy() - found[other].to_numpy())
        return np.asarray(difference > max(CLEAR * found.attrs[noise], LATE * largest))

    start = np.zeros(wheel.shape, dtype=bool)
    start[:memory], start[len(wheel) - math.ceil((estimator.delay + estimator.sensor_delay).max()) :] = True, True
    return {
        "start": start,
        "late": off("force_at_once", "force", "force_noise"),
        "torque": off("torque_expected", "torque", "torque_noise"),
        "limit": _at_limit(control, np.abs(found["drive_torque"].to_numpy()), np.abs(roller) / p.roller_radius),
        "sliding": np.abs(wheel - roller) > control.protection.slip,
        "locked": np.abs(wheel) < control.locked_speed,
    }


def _at_limit(control: RigControl, torque: Array, speed: Array) -> Mask:
    """Where drives of a torque [N m] at a speed [rad/s] are at their limits, both without signs."""
    drive = control.motor
    largest = min(control.feedback.largest, drive.largest_torque or math.inf)
    power = AT_LIMIT * (drive.largest_power or math.inf)
    beyond = speed > AT_LIMIT * (drive.largest_speed or math.inf)
    return np.asarray((torque > AT_LIMIT * largest) | (torque * speed > power) | beyond)


def torque_ratio(found: Array, expected: Array) -> Array:
    """Torque found over torque expected of each axle by least squares, shape (axle,); NaN where none is expected."""
    square = (expected**2).sum(axis=0)
    none = np.full_like(square, math.nan)
    return np.asarray(np.divide((found * expected).sum(axis=0), square, out=none, where=square > 0.0))


def _check_signs(found: xr.Dataset, radius: float) -> None:
    """Refuse with a ResultsError torques that contradict each other by more than a sensor is wrong: a sign, or a unit."""
    period = float(found["time"][1] - found["time"][0])
    own, expected = (means(found[name].to_numpy(), period) for name in ("torque", "torque_expected"))
    # either may be the one that is wrong
    largest = np.sqrt(np.maximum((own**2).mean(axis=0), (expected**2).mean(axis=0)))
    least = np.maximum(LEAST_TORQUE * radius * found["axle_load"].to_numpy(), found.attrs["torque_noise"])
    for axle, factor, shows in zip(found["axle"].to_numpy(), torque_ratio(own, expected), largest > least, strict=True):
        if shows and not 0.2 < factor < 5.0:
            raise ResultsError(
                f"{found.attrs['file']}: {axle}: by drive and speeds its torque is {factor:.2g} times that of brake and motor; "
                "allowed: 0.2 to 5; look at the units of pressures and torques, and at the signs: roller_torque is "
                "positive where it drives the wheel forward, torques of brakes are negative"
            )


def episodes(found: xr.Dataset) -> list[tuple[str, str, float, float]]:
    """Axle, reason, begin and end [s] of what is not to be relied on; pauses of less than JOINED are no end."""
    time, period = found["time"].to_numpy(), float(found["time"][1] - found["time"][0])
    pieces = []
    for axle in found["axle"].to_numpy():
        for reason in found["reason"].to_numpy():
            at = time[found["doubtful"].sel(axle=axle, reason=reason).to_numpy()]
            if at.size:
                parts = np.split(at, np.flatnonzero(np.diff(at) > JOINED) + 1)
                pieces += [(str(axle), str(reason), float(part[0]), float(part[-1]) + period) for part in parts]
    return sorted(pieces, key=lambda piece: piece[2])
