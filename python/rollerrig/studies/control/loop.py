"""The rig's control loop, linear: its margins in closed form, and its eigenvalues as it is sampled.

Case -> loop_of -> Loop -> [open_loop, margins] of one axle in continuous time
Case -> rolling_plant or vehicle_plant -> Plant, with the Loop -> [sampled_matrix, growth, gain_limit] sample by sample

An independent check on the core's controller, written down from the equations in docs/theory/rig_control.md, (D1) to (D6) and
(Q1) to (Q4), not from its code. Small motion about steady running: no limits, friction that does not change.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import expm, solve_discrete_are
from scipy.optimize import brentq

from rollerrig import _core
from rollerrig.analysis.contact_state import rolling_state
from rollerrig.analysis.linearise import DIRECTIONS
from rollerrig.assembly import assemble
from rollerrig.cases import leading_wheelset, without_actuators
from rollerrig.config import Case, Rig
from rollerrig.config.schema.actuators import Motor
from rollerrig.config.schema.rig_control import RigControl
from rollerrig.starting_state import starting_state

Array = NDArray[np.float64]

NEUTRAL = 1e-6
"""Eigenvalues so near to 1 are neutral: double ones, as of an angle and its speed, are found to the root of rounding."""


@dataclass(frozen=True)
class Wheel:
    """Wheelset and roller: inertias J_w, J_r [kg m^2] and radii r, R [m]."""

    wheelset_inertia: float
    roller_inertia: float
    wheel_radius: float
    roller_radius: float

    @property
    def ratio(self) -> float:
        """r/R."""
        return self.wheel_radius / self.roller_radius

    @property
    def inertia(self) -> float:
        """Wheel and roller as one, J_w + J_r (r/R)^2 [kg m^2]."""
        return self.wheelset_inertia + self.roller_inertia * self.ratio**2


@dataclass(frozen=True)
class Loop:
    """What closes around one axle.

    Attributes:
        real, assumed: wheelset and roller, and what the controller takes them for.
        creep: slope of the real contact's force over sliding, both wheels [N s/m].
        virtual_creep: the same of the virtual rail; 0 while its wheel slides.
        drive_bandwidth: of the roller drive's torque loop [rad/s].
        drive_damping: of a second-order one; 0: first order.
        step, sample, delay: bench step, sample time, delay of the command [s].
        proportional, integral: gains on virtual minus measured axle speed [N m s/rad, N m/rad].
        estimator: its kind.
        bandwidth, damping: of the estimator [rad/s, 1].
        speed_noise: that a Kalman filter believes in [rad/s].
        changes: of contact force [N] and axle torque [N m] in 1 s that it believes in.
    """

    real: Wheel
    assumed: Wheel
    creep: float
    virtual_creep: float
    drive_bandwidth: float
    drive_damping: float
    step: float
    sample: float
    delay: float
    proportional: float
    integral: float
    estimator: str
    bandwidth: float
    damping: float
    speed_noise: float = 1e-3
    changes: tuple[float, float] = (0.0, 0.0)

    def scaled(self, factor: float) -> Loop:
        """With both gains times a factor."""
        return replace(self, proportional=factor * self.proportional, integral=factor * self.integral)


def default_gains(wheel: Wheel, bandwidth: float, damping: float) -> tuple[float, float]:
    """Gains of the PI controller, (D6), for a bandwidth [rad/s]."""
    scale = wheel.inertia / wheel.ratio
    return 2.0 * damping * bandwidth * scale, bandwidth**2 * scale


def wheel_of(case: Case) -> Wheel:
    """Wheelset and roller of a rig's case, each with the rotor that its motor drives it by."""
    rig, control = case.support.data, case.rig_control
    assert isinstance(rig, Rig)
    wheelset = leading_wheelset(case).inertia[1]
    roller = rig.roller_inertia[1]
    wheelset += rotor_inertia(case.traction.motor) if case.traction is not None else 0.0
    roller += rotor_inertia(control.motor) if control is not None else 0.0
    return Wheel(wheelset, roller, case.vehicle.data.wheel.radius, rig.roller_radius)


def rotor_inertia(motor: Motor) -> float:
    """Of a motor's rotor, on the driven axle [kg m^2]."""
    return motor.rotor_inertia * motor.gear_ratio**2


def creep_slope(case: Case) -> float:
    """Slope of an axle's creep force over sliding at small creepage [N s/m]: sum of f11 over both wheels, over speed.

    Raises:
        StartError: no rolling equilibrium was found.
    """
    stiffness = rolling_state(case, case.motion.speed).creep_stiffness
    return 2.0 * sum(stiffness.values()) / len(stiffness) / case.motion.speed


def loop_of(case: Case, creep: float, *, sliding: bool) -> Loop | None:
    """The loop of a case with [rig_control].

    Args:
        case: of a rig.
        creep: see `creep_slope`.
        sliding: whether the virtual wheel slides; else it rolls, on the creep slope of the real one as far as the condition
            of the virtual rail leaves it.

    Returns:
        The loop; None where this file has no equations for it: a user's controller, another
        estimator or measurement of torque, motors with rotors.
    """
    control = case.rig_control
    if control is None or control.user is not None or control.estimator.kind not in _ESTIMATORS:
        return None
    if control.estimator.torque != "measured" or case.sensors.roller_torque is not None:
        return None
    motors = (control.motor, *((case.traction.motor,) if case.traction is not None else ()))
    if any(motor.rotor_inertia for motor in motors):  # the plant has none
        return None
    real, feedback = wheel_of(case), control.feedback
    assumed = Wheel(
        *(getattr(control.assumed, name) or getattr(real, name) for name in Wheel.__dataclass_fields__),
    )
    proportional = integral = 0.0
    if feedback.kind == "proportional_integral":
        gains = default_gains(assumed, 2.0 * math.pi * feedback.bandwidth, feedback.damping_ratio)
        proportional = gains[0] if feedback.proportional is None else feedback.proportional
        integral = gains[1] if feedback.integral is None else feedback.integral
    elif feedback.kind == "sliding_mode":  # within its boundary layer
        proportional = feedback.switching / feedback.boundary_layer
    return Loop(
        real=real,
        assumed=assumed,
        creep=creep,
        virtual_creep=0.0 if sliding else creep * _weakened(case),
        drive_bandwidth=2.0 * math.pi * control.motor.bandwidth,
        drive_damping=control.motor.damping_ratio,
        step=case.bench.step,
        sample=control.sample_time,
        delay=control.delay,
        proportional=proportional,
        integral=integral,
        estimator=control.estimator.kind,
        bandwidth=2.0 * math.pi * control.estimator.bandwidth,
        damping=control.estimator.damping_ratio,
        speed_noise=control.estimator.speed_noise,
        changes=_changes(control, assumed),
    )


def _changes(control: RigControl, p: Wheel) -> tuple[float, float]:
    """Changes of force and torque that the Kalman filter believes in, (D12) where they are absent."""
    table = control.estimator
    scale = (2.0 * math.pi * table.bandwidth) ** 2 * table.speed_noise * math.sqrt(control.sample_time)
    force, torque = p.roller_inertia / p.roller_radius, p.wheelset_inertia + p.roller_inertia * p.ratio
    return table.force_change or scale * force, table.torque_change or scale * torque


def _weakened(case: Case) -> float:
    """What the condition of the virtual rail leaves of the creep curve's slope, (A4)."""
    rail = case.adhesion.rail if case.adhesion is not None else None
    return 0.5 * (rail.k_A + rail.k_S) if rail is not None else 1.0


# ------------------------------------------------------------------------------------------- continuous, (Q1) to (Q4)


@dataclass(frozen=True)
class Margins:
    """How far the feedback loop is from ringing.

    Attributes:
        crossover: where its gain is 1 [rad/s]; NaN if nowhere.
        phase: phase margin there [rad].
        turnover: where its phase passes -180 degrees on the way down [rad/s]; NaN if nowhere.
        gain: gain margin there, a factor.
    """

    crossover: float
    phase: float
    turnover: float
    gain: float


def open_loop(loop: Loop, frequency: Array) -> NDArray[np.complex128]:
    """Frequency response of the feedback's open loop, (Q1), over angular frequency [rad/s]."""
    s = 1j * np.asarray(frequency)
    wheel, w = loop.real, loop.drive_bandwidth
    turning = wheel.roller_radius**2 * wheel.wheelset_inertia + wheel.wheel_radius**2 * wheel.roller_inertia
    both = wheel.wheelset_inertia * wheel.roller_inertia / loop.creep
    plant = wheel.wheel_radius * wheel.roller_radius / (s * (turning + both * s))
    lag = s / w + 1.0 if loop.drive_damping == 0.0 else (s / w) ** 2 + 2.0 * loop.drive_damping * s / w + 1.0
    wait = np.exp(-s * (loop.delay + 0.5 * loop.sample))
    return np.asarray((loop.proportional + loop.integral / s) * plant / lag * wait)


def margins(loop: Loop) -> Margins:
    """Gain and phase margin of the feedback loop alone."""
    frequency = np.geomspace(1e-3, math.pi / loop.step, 4000)
    response = open_loop(loop, frequency)
    size, angle = np.log(np.abs(response) + 1e-300), np.unwrap(np.angle(response))
    angle -= (
        2.0 * math.pi * np.round((angle[0] + 0.5 * math.pi) / (2.0 * math.pi) - 0.25)
    )  # starts at -180 or -90 degrees
    crossover = _first_fall(frequency, size)
    phase = float(np.interp(math.log(crossover), np.log(frequency), angle)) + math.pi if crossover else math.nan
    above = angle + math.pi
    start = int(np.argmax(above > 1e-3)) if (above > 1e-3).any() else len(above)
    turnover = _first_fall(frequency[start:], above[start:])
    gain = math.exp(-float(np.interp(math.log(turnover), np.log(frequency), size))) if turnover else math.nan
    return Margins(crossover or math.nan, phase, turnover or math.nan, gain)


def _first_fall(frequency: Array, values: Array) -> float | None:
    """Where values first fall through zero, linear in the logarithm of the frequency."""
    down = np.flatnonzero((values[:-1] > 0.0) & (values[1:] <= 0.0))
    if not down.size:
        return None
    k = int(down[0])
    part = values[k] / (values[k] - values[k + 1])
    return float(frequency[k] * (frequency[k + 1] / frequency[k]) ** part)


def ideal_margin(bandwidth: float, damping: float, lag: float) -> tuple[float, float]:
    """Crossover [rad/s] and phase margin [rad] of (D6) with pure rolling and a total lag [s] of drive, delay and sampling.

    (Q2), with the drive's lag taken as a delay, as it is far below its bandwidth.
    """
    crossover = bandwidth * math.sqrt(2.0 * damping**2 + math.sqrt(4.0 * damping**4 + 1.0))
    return crossover, math.atan(2.0 * damping * crossover / bandwidth) - crossover * lag


# --------------------------------------------------------------------------------------------------- sampled


def _observer(loop: Loop, z: dict[str, Array]) -> None:
    """Luenberger observer of roller speed and contact force, both poles at the bandwidth; filtered acceleration of the wheel."""
    assumed, h, w = loop.assumed, loop.sample, loop.bandwidth * loop.sample
    poles = np.exp(-loop.damping * w + np.array([1.0, -1.0]) * w * np.emath.sqrt(loop.damping**2 - 1.0))
    predicted = z["roller_seen"] + h * (z["mean"] + assumed.roller_radius * z["force"]) / assumed.roller_inertia
    error = z["roller"] - predicted
    z["roller_seen"] = predicted + (1.0 - np.prod(poles).real) * error
    gain = np.prod(1.0 - poles).real * assumed.roller_inertia / (assumed.roller_radius * h)
    z["force"] = z["force"] + gain * error
    _torque_from_acceleration(loop, z)


def _filtered_derivative(loop: Loop, z: dict[str, Array]) -> None:
    """Low-pass of the first order behind the difference of the roller's speed."""
    assumed = loop.assumed
    rate = (z["roller"] - z["roller_seen"]) / loop.sample
    raw = (assumed.roller_inertia * rate - z["mean"]) / assumed.roller_radius
    z["force"] = z["force"] + (1.0 - math.exp(-loop.bandwidth * loop.sample)) * (raw - z["force"])
    z["roller_seen"] = z["roller"]
    _torque_from_acceleration(loop, z)


def _torque_from_acceleration(loop: Loop, z: dict[str, Array]) -> None:
    """(D2) with the wheel's acceleration behind a low-pass."""
    assumed, low_pass = loop.assumed, 1.0 - math.exp(-loop.bandwidth * loop.sample)
    z["wheel_rate"] = z["wheel_rate"] + low_pass * ((z["wheel"] - z["wheel_seen"]) / loop.sample - z["wheel_rate"])
    z["wheel_seen"] = z["wheel"]
    z["axle_torque"] = assumed.wheelset_inertia * z["wheel_rate"] + assumed.wheel_radius * z["force"]


def _kalman(loop: Loop, z: dict[str, Array]) -> None:
    """Stationary Kalman filter of both speeds, force and torque, (D10) to (D12)."""
    p, h = loop.assumed, loop.sample
    predicted = [
        z["roller_seen"] + h * (z["mean"] + p.roller_radius * z["force"]) / p.roller_inertia,
        z["wheel_seen"] + h * (z["axle_torque"] - p.wheel_radius * z["force"]) / p.wheelset_inertia,
        z["force"],
        z["axle_torque"],
    ]
    error = np.stack([z["roller"] - predicted[0], z["wheel"] - predicted[1]])
    corrected = np.stack(predicted) + np.tensordot(kalman_gain(loop), error, axes=1)
    z["roller_seen"], z["wheel_seen"], z["force"], z["axle_torque"] = corrected


def kalman_gain(loop: Loop) -> Array:
    """Gain of the filter from the Riccati equation of (D11), rows W, w, T, C over the errors of W and w."""
    p, h, noise = loop.assumed, loop.sample, loop.speed_noise
    rates = np.zeros((4, 4))
    rates[0, 2], rates[1, 2:] = (
        p.roller_radius / p.roller_inertia,
        (-p.wheel_radius / p.wheelset_inertia, 1.0 / p.wheelset_inertia),
    )
    force, torque = loop.changes
    walk = np.diag([0.0, 0.0, force**2, torque**2])
    disturbance = walk * h + (rates @ walk + walk @ rates.T) * h**2 / 2.0 + rates @ walk @ rates.T * h**3 / 3.0
    step, reads = np.eye(4) + h * rates, np.eye(2, 4)
    spread = solve_discrete_are(step.T, reads.T, disturbance, noise**2 * np.eye(2))
    return np.asarray(spread @ reads.T @ np.linalg.inv(reads @ spread @ reads.T + noise**2 * np.eye(2)))


_ESTIMATORS: dict[str, Callable[[Loop, dict[str, Array]], None]] = {
    "observer": _observer,
    "filtered_derivative": _filtered_derivative,
    "kalman": _kalman,
}

_STATES = ("roller_seen", "wheel_seen", "force", "axle_torque", "wheel_rate", "virtual", "sum")


@dataclass(frozen=True)
class Plant:
    """x' = A x + B u of wheels and rollers under the torques u of the roller drives.

    Attributes:
        matrix: A, shape (state, state).
        torque: B, shape (state, axle).
        wheel, roller: speeds of axles and rollers, positive forward, from x: shape (axle, state).
    """

    matrix: Array
    torque: Array
    wheel: Array
    roller: Array


def rolling_plant(wheel: Wheel, creep: float) -> Plant:
    """One axle with its roller, (D1) and (D2), between them creep."""
    r, R = wheel.wheel_radius, wheel.roller_radius
    pull = creep * np.array([r, -R])  # T over (w, W)
    matrix = np.stack([-r * pull / wheel.wheelset_inertia, R * pull / wheel.roller_inertia])
    torque = np.array([[0.0], [1.0 / wheel.roller_inertia]])
    return Plant(matrix, torque, np.array([[1.0, 0.0]]), np.array([[0.0, 1.0]]))


def vehicle_plant(case: Case) -> Plant:
    """The whole vehicle on its rollers, which turn freely: the core's exact linearisation at the start.

    Raises:
        StartError: no rolling equilibrium was found.
    """
    model = assemble(without_actuators(case))
    simulation = _core.Simulation(model.core)
    matrix = np.array(simulation.jacobian(0.0, np.asarray(starting_state(simulation, model)))[0])
    spin = DIRECTIONS.index("pitch")
    rows = [simulation.rate_index[model.body_index(name)][spin] for name in (*model.wheelsets, *model.rollers)]
    reads = np.eye(len(matrix))[rows]
    wheel, roller = reads[: len(model.wheelsets)], -reads[len(model.wheelsets) :]
    rig = case.support.data
    assert isinstance(rig, Rig)
    return Plant(matrix, roller.T / rig.roller_inertia[1], wheel, roller)


def _plant_step(loop: Loop, plant: Plant) -> Array:
    """Exact step of (x, torques, their rates, commands) over one bench step with the commands held."""
    n, axles = plant.torque.shape
    x, u, rate, command = slice(0, n), *(slice(n + k * axles, n + (k + 1) * axles) for k in range(3))
    w, one = loop.drive_bandwidth, np.eye(axles)
    rates = np.zeros((n + 3 * axles, n + 3 * axles))
    rates[x, x], rates[x, u] = plant.matrix, plant.torque
    if loop.drive_damping > 0.0:
        rates[u, rate] = one
        rates[rate, u], rates[rate, rate] = -(w**2) * one, -2.0 * loop.drive_damping * w * one
        rates[rate, command] = w**2 * one
    else:
        rates[u, u], rates[u, command] = -w * one, w * one
    return np.asarray(expm(loop.step * rates))


def _controller(loop: Loop, z: dict[str, Array]) -> Array:
    """Command of one sample: estimate, virtual axle, (D5) and feedback, all linear."""
    h, assumed, wheel = loop.sample, loop.assumed, loop.real
    _ESTIMATORS[loop.estimator](loop, z)

    slope = wheel.wheel_radius * loop.virtual_creep  # force per virtual axle speed
    stiffness = wheel.wheel_radius * slope / wheel.wheelset_inertia
    reach = h - 1.0 / stiffness if stiffness * h > 2.0 else 0.5 * h  # of the theta method
    rate = (z["axle_torque"] / wheel.wheelset_inertia - stiffness * z["virtual"]) / (1.0 + stiffness * reach)
    force = slope * (z["virtual"] + reach * rate)
    z["virtual"] = z["virtual"] + h * rate

    forward = assumed.roller_inertia * wheel.wheel_radius / assumed.roller_radius * rate
    error = z["virtual"] - z["wheel"]
    z["sum"] = z["sum"] + h * error
    return forward - assumed.roller_radius * force + loop.proportional * error + loop.integral * z["sum"]


def sampled_matrix(loop: Loop, plant: Plant) -> Array:
    """From the state at one sample to that at the next, shape (state, state).

    The state is the plant's, then per axle the drive's, the controller's (_STATES), the mean torque over the last bench step,
    and the commands still on their way.
    """
    n, axles = plant.torque.shape
    names = ("torque", "torque_rate", *_STATES, "mean")
    waiting = round(loop.delay / loop.step)
    unit = np.eye(n + axles * (len(names) + 1 + waiting))
    x, rest = unit[:n], unit[n:].reshape(-1, axles, len(unit))
    z: dict[str, Array] = dict(zip(names, rest, strict=False))
    queue = list(rest[len(names) :])
    z["wheel"], z["roller"] = plant.wheel @ x, plant.roller @ x
    command, step = _controller(loop, z), _plant_step(loop, plant)
    for _ in range(round(loop.sample / loop.step)):
        queue = [*queue, command][1:]
        before = z["torque"]
        after = step @ np.concatenate([x, before, z["torque_rate"], queue[0]])
        x, (z["torque"], z["torque_rate"], _) = after[:n], after[n:].reshape(3, axles, -1)
        z["mean"] = 0.5 * (before + z["torque"])
    return np.concatenate([x, *(z[name] for name in names), *queue])


def growth(loop: Loop, plant: Plant, above: float = 0.0) -> tuple[float, float]:
    """Rate [1/s] and frequency [Hz] of the least damped motion; a rate above zero: the loop rings up.

    Motions that neither grow nor decay are left out: angles turned, the common speed of train and wheels, an integral without
    a gain.

    Args:
        loop: the controller.
        plant: what it controls.
        above: only motions of a higher frequency count [Hz]; NaN where there is none.
    """
    values = np.linalg.eigvals(sampled_matrix(loop, plant))
    values = values[(np.abs(values - 1.0) > NEUTRAL) & (np.abs(values) > 1e-12)]
    values = values[np.abs(np.angle(values)) >= 2.0 * math.pi * loop.sample * above]
    if not values.size:
        return math.nan, math.nan
    largest = values[np.argmax(np.abs(values))]
    return math.log(abs(largest)) / loop.sample, abs(float(np.angle(largest))) / (2.0 * math.pi * loop.sample)


def gain_limit(loop: Loop, plant: Plant, highest: float = 1e4) -> float:
    """Factor on the feedback's gains at which the sampled loop begins to ring; NaN: not up to `highest`, 0: as it is."""

    def rate(log_factor: float) -> float:
        return growth(loop.scaled(math.exp(log_factor)), plant)[0]

    if loop.proportional == loop.integral == 0.0:
        return math.nan
    factors = np.linspace(0.0, math.log(highest), 80)
    if rate(0.0) > 0.0:
        return 0.0
    for low, high in zip(factors[:-1], factors[1:], strict=True):
        if rate(high) > 0.0:
            return math.exp(float(brentq(rate, low, high, xtol=1e-4)))
    return math.nan
