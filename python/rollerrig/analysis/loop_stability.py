"""Stability of the sampled loop of the roller drives: eigenvalues of the linear loop, and growth measured in runs.

Loop, Plant -> [sampled_matrix] -> growth rate and frequency, gain limit
run of a lightly excited rig -> [measured_growth] -> the same, from the tracking error
Loop -> [estimator_matrices] -> the estimator alone, as one matrix from sample to sample

The linear controller is written from the equations (D1) to (D5), (D10) of docs/theory/rig_control.md and not from the core's
code, so that runs of the core check it; the plant is the core's exact linearisation.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy.linalg import expm

from rollerrig import _core
from rollerrig.analysis.control_loop import Loop, Wheel
from rollerrig.analysis.modes import DIRECTIONS
from rollerrig.assembly.model import assemble
from rollerrig.cases import without_actuators
from rollerrig.common.arrays import Array, Mask
from rollerrig.common.linear_algebra import one_blas_thread
from rollerrig.config import Case, Rig
from rollerrig.simulation.starting_state import starting_state

NEUTRAL = 1e-6
"""Eigenvalues so near to 1 are neutral: double ones, as of an angle and its speed, are found to the root of rounding."""

ABOVE = 10.0  # the slow motions of bogie and loop, which are damped, stay below this frequency [Hz]

WINDOW = 0.1
"""Window of the RMS values from which a growth rate is measured [s], and how many of them it takes at least:"""
LEAST_WINDOWS = 4

LINEAR_RANGE = (1e-10, 2e-2)
"""An instability grows exponentially between these tracking errors: below is rounding, above torque and adhesion saturate
[rad/s]."""


@dataclass(frozen=True)
class Plant:
    """x' = A x + B u of wheels and rollers under the torques u of the roller drives."""

    matrix: Array  # A, shape (state, state)
    torque: Array  # B, shape (state, axle)
    # wheel, roller: speeds of axles and rollers, positive forward, from x: shape (axle, state)
    wheel: Array
    roller: Array
    brake: Array  # torque of the brakes from x, which a controller knows from pressure and speed: shape (axle, state)


def rolling_plant(wheel: Wheel, creep: float, brake: float = 0.0) -> Plant:
    """One axle with its roller, (D1) and (D2), between them creep of a slope of force over sliding [N s/m].

    Of a brake that holds a locked wheel, the slope of its torque over the axle's speed [N m s/rad].
    """
    r, R = wheel.wheel_radius, wheel.roller_radius
    force = creep * np.array([r, -R])  # T over (w, W)
    held = np.array([brake, 0.0])
    matrix = np.stack([-(r * force + held) / wheel.wheelset_inertia, R * force / wheel.roller_inertia])
    torque = np.array([[0.0], [1.0 / wheel.roller_inertia]])
    return Plant(matrix, torque, np.array([[1.0, 0.0]]), np.array([[0.0, 1.0]]), -held[None, :])


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


def _observer(loop: Loop, z: dict[str, Array]) -> None:
    """Luenberger observer of roller speed and contact force, both poles at the bandwidth; filtered acceleration of the wheel."""
    p, h, w = loop.assumed, loop.sample, loop.bandwidth * loop.sample
    poles = np.exp(-loop.damping * w + np.array([1.0, -1.0]) * w * np.emath.sqrt(loop.damping**2 - 1.0))
    predicted = z["roller_estimate"] + h * (z["mean"] + p.roller_radius * z["force"]) / p.roller_inertia
    error = z["roller"] - predicted
    z["roller_estimate"] = predicted + (1.0 - np.prod(poles).real) * error
    z["force"] = z["force"] + np.prod(1.0 - poles).real * p.roller_inertia / (p.roller_radius * h) * error
    _torque_from_acceleration(loop, z)


def _filtered_derivative(loop: Loop, z: dict[str, Array]) -> None:
    """Low-pass of the first order behind the difference of the roller's speed."""
    p = loop.assumed
    rate = (z["roller"] - z["roller_estimate"]) / loop.sample
    raw = (p.roller_inertia * rate - z["mean"]) / p.roller_radius
    z["force"] = z["force"] + (1.0 - math.exp(-loop.bandwidth * loop.sample)) * (raw - z["force"])
    z["roller_estimate"] = z["roller"]
    _torque_from_acceleration(loop, z)


def _torque_from_acceleration(loop: Loop, z: dict[str, Array]) -> None:
    """(D2) with the wheel's acceleration behind a low-pass."""
    p, low_pass = loop.assumed, 1.0 - math.exp(-loop.bandwidth * loop.sample)
    z["wheel_rate"] = z["wheel_rate"] + low_pass * ((z["wheel"] - z["wheel_estimate"]) / loop.sample - z["wheel_rate"])
    z["wheel_estimate"] = z["wheel"]
    z["axle_torque"] = p.wheelset_inertia * z["wheel_rate"] + p.wheel_radius * z["force"]


def _kalman(loop: Loop, z: dict[str, Array]) -> None:
    """Stationary Kalman filter of both speeds, force and torque, (D10), with the core's gain."""
    p, h = loop.assumed, loop.sample
    assert loop.kalman_gain is not None
    predicted = [
        z["roller_estimate"] + h * (z["mean"] + p.roller_radius * z["force"]) / p.roller_inertia,
        z["wheel_estimate"] + h * (z["axle_torque"] - p.wheel_radius * z["force"]) / p.wheelset_inertia,
        z["force"],
        z["axle_torque"],
    ]
    error = np.stack([z["roller"] - predicted[0], z["wheel"] - predicted[1]])
    corrected = np.stack(predicted) + np.tensordot(loop.kalman_gain, error, axes=1)
    z["roller_estimate"], z["wheel_estimate"], z["force"], z["axle_torque"] = corrected


_ESTIMATORS: dict[str, Callable[[Loop, dict[str, Array]], None]] = {
    "observer": _observer,
    "filtered_derivative": _filtered_derivative,
    "kalman": _kalman,
}

_OF_ESTIMATOR = ("roller_estimate", "wheel_estimate", "force", "axle_torque", "wheel_rate", "late", "correction",
                 "last_torque", "slope")  # fmt: skip
ESTIMATED = (*_OF_ESTIMATOR, "taken")  # states of `estimator_matrices`
_STATES = (*_OF_ESTIMATOR, "virtual", "sum", "feed_forward")


def _plant_step(loop: Loop, plant: Plant) -> Array:
    """Exact step of (x, torques, their rates, commands) over one sampling step with the commands constant."""
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


def _torque_of_axle(loop: Loop, z: dict[str, Array]) -> Array:
    """What the virtual axle takes for its torque: the estimate, its extrapolation (D19), or the known torque (D18)."""
    h, estimate = loop.sample, z["axle_torque"]
    if loop.correction is not None:
        z["late"] = z["late"] + (1.0 - math.exp(-loop.bandwidth * h)) * (z["brake"] - z["late"])
        beyond = estimate - z["late"] - z["correction"]
        z["correction"] = z["correction"] + (1.0 - math.exp(-loop.correction * h)) * beyond
        return z["brake"] + z["correction"]
    low_pass = 1.0 - math.exp(-loop.slope_bandwidth * h)
    z["slope"] = z["slope"] + low_pass * ((estimate - z["last_torque"]) / h - z["slope"])
    z["last_torque"] = estimate
    return estimate + loop.ahead * z["slope"]


def estimator_matrices(loop: Loop) -> tuple[Array, Array]:
    """F and G of one sample of the estimator of an axle, z' = F z + G u.

    u are speeds of roller and wheel, mean torque of the drive and known torque of the axle, z the states of ESTIMATED; `taken`
    is what the virtual axle takes for its torque.
    """
    inputs = ("roller", "wheel", "mean", "brake")
    z = dict(zip((*ESTIMATED, *inputs), np.eye(len(ESTIMATED) + len(inputs)), strict=True))
    _ESTIMATORS[loop.estimator](loop, z)
    z["taken"] = _torque_of_axle(loop, z)
    both = np.stack([z[name] for name in ESTIMATED])
    return both[:, : len(ESTIMATED)], both[:, len(ESTIMATED) :]


def _controller(loop: Loop, z: dict[str, Array]) -> Array:
    """Command of one sample: estimate, virtual axle, (D5), feedback and what is done against the drive's lag, all linear."""
    h, p, wheel = loop.sample, loop.assumed, loop.real
    _ESTIMATORS[loop.estimator](loop, z)
    torque = _torque_of_axle(loop, z)

    slope = wheel.wheel_radius * loop.virtual_creep  # force per virtual axle speed
    stiffness = wheel.wheel_radius * slope / wheel.wheelset_inertia
    reach = h - 1.0 / stiffness if stiffness * h > 2.0 else 0.5 * h  # of the theta method
    rate = (torque / wheel.wheelset_inertia - stiffness * z["virtual"]) / (1.0 + stiffness * reach)
    force = slope * (z["virtual"] + reach * rate)
    z["virtual"] = z["virtual"] + h * rate

    feed_forward = p.roller_inertia * wheel.wheel_radius / p.roller_radius * rate - p.roller_radius * force
    error = z["virtual"] - z["wheel"]
    z["sum"] = z["sum"] + h * error
    ahead = loop.lead / h * (feed_forward - z["feed_forward"])
    z["feed_forward"] = feed_forward
    wanted = feed_forward + loop.proportional * error + loop.integral * z["sum"]
    return wanted + ahead + loop.torque_gain * (wanted - z["torque"])


@one_blas_thread()
def sampled_matrix(loop: Loop, plant: Plant) -> Array:
    """Matrix from the state at one sample to that at the next, shape (state, state).

    The state is the plant's, then per axle the drive's, the controller's (_STATES), the mean torque over the last sampling step,
    and the commands still delayed.
    """
    n, axles = plant.torque.shape
    names = ("torque", "torque_rate", *_STATES, "mean")
    waiting = round(loop.delay / loop.step)
    unit = np.eye(n + axles * (len(names) + 1 + waiting))
    x, rest = unit[:n], unit[n:].reshape(-1, axles, len(unit))
    z: dict[str, Array] = dict(zip(names, rest, strict=False))
    queue = list(rest[len(names) :])
    z["wheel"], z["roller"], z["brake"] = plant.wheel @ x, plant.roller @ x, plant.brake @ x
    command, step = _controller(loop, z), _plant_step(loop, plant)
    for _ in range(round(loop.sample / loop.step)):
        queue = [*queue, command][1:]
        before = z["torque"]
        after = step @ np.concatenate([x, before, z["torque_rate"], queue[0]])
        x, (z["torque"], z["torque_rate"], _) = after[:n], after[n:].reshape(3, axles, -1)
        z["mean"] = 0.5 * (before + z["torque"])
    return np.concatenate([x, *(z[name] for name in names), *queue])


@one_blas_thread()
def growth(loop: Loop, plant: Plant, above: float = 0.0) -> tuple[float, float]:
    """Rate [1/s] and frequency [Hz] of the least damped motion; a rate above zero: the loop is unstable.

    Only motions of a frequency `above` count [Hz]; NaN where there is none. Those that neither grow nor decay are left out:
    angles turned, the common speed of train and wheels, an integral without a gain.
    """
    values = np.linalg.eigvals(sampled_matrix(loop, plant))
    values = values[(np.abs(values - 1.0) > NEUTRAL) & (np.abs(values) > 1e-12)]
    values = values[np.abs(np.angle(values)) >= 2.0 * math.pi * loop.sample * above]
    if not values.size:
        return math.nan, math.nan
    largest = values[np.argmax(np.abs(values))]
    return math.log(abs(largest)) / loop.sample, abs(float(np.angle(largest))) / (2.0 * math.pi * loop.sample)


def gain_limit(loop: Loop, plant: Plant, highest: float = 1e4) -> float:
    """Factor on the feedback's gains from which the sampled loop is unstable; NaN: not up to `highest`, 0: as it is."""
    from scipy.optimize import brentq  # slow to load, and seldom needed

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


def measured_growth(error: xr.DataArray, begin: float) -> tuple[tuple[float, float], float]:
    """Rate [1/s] and frequency [Hz] at which the tracking error of a run grows above ABOVE, and its RMS at the end [rad/s].

    Of virtual less real speeds [rad/s] over evenly spaced `time` [s], then axle, from `begin` [s] on; rate and frequency are NaN
    where nothing grew within LINEAR_RANGE.
    """
    from scipy.signal import butter, sosfiltfilt  # slow to load, and seldom needed

    step = float(error["time"][1] - error["time"][0])
    sos = butter(8, ABOVE, "highpass", fs=1.0 / step, output="sos")
    high = sosfiltfilt(sos, error.to_numpy(), axis=0)[round(begin / step) :]
    window = round(WINDOW / step)
    count = len(high) // window
    size = np.sqrt(np.mean(high[: count * window].reshape(count, window, -1) ** 2, axis=(1, 2)))
    least, largest = LINEAR_RANGE
    linear = (size < largest) & (size > 3.0 * max(float(size[:-2].min()), least))
    linear[-2:] = False  # the filter's end
    late = _last_part(linear)[-12:]
    if len(late) < LEAST_WINDOWS:
        return (math.nan, math.nan), float(size[-3])
    middle = (np.arange(count) + 0.5) * window * step
    rate = float(np.polyfit(middle[late], np.log(size[late]), 1)[0])
    piece = high[late[0] * window : (late[-1] + 1) * window]
    steady = piece[:, int(np.argmax(np.abs(piece).max(axis=0)))] * np.exp(-rate * step * np.arange(len(piece)))
    power = np.abs(np.fft.rfft(steady * np.hanning(len(steady)), 8 * len(steady)))
    frequency = float(np.argmax(power) / (8 * len(steady) * step))
    return (rate, frequency) if rate > 0.0 and frequency > ABOVE else (math.nan, math.nan), float(size[-3])


def _last_part(flags: Mask) -> NDArray[np.intp]:
    """Indices of the last connected true values that are enough for a rate, or of the last ones."""
    at = np.flatnonzero(flags)
    parts = np.split(at, np.flatnonzero(np.diff(at) > 1) + 1)
    return next((part for part in reversed(parts) if len(part) >= LEAST_WINDOWS), parts[-1])
