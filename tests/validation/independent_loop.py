"""The rig's controller in small motions from its equations, (D1) to (D5), (D10) to (D12), (D16), (D18) to (D21), not from the
core's code: a second way to the matrix of rollerrig.analysis.linear_controller.

States are those of ESTIMATOR, LAWS per axle, then speed and acceleration of the virtual train; inputs as there.
"""

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
from scipy.linalg import solve_discrete_are

from rollerrig.analysis.control_loop import Wheel, wheel_of
from rollerrig.analysis.virtual_rail import creep_curve, patch_of
from rollerrig.assembly.actuators import assemble_with_actuators
from rollerrig.cases import rig_of
from rollerrig.common.arrays import Array
from rollerrig.config import Case
from rollerrig.simulation.mechatronics import drive_command, feedback_gains

Signals = dict[str, Array]

ESTIMATOR = ("roller_estimate", "wheel_estimate", "force", "axle_torque", "wheel_rate")
LAWS = ("late", "correction", "last_torque", "slope", "virtual", "sum", "feed_forward")
INPUTS = ("wheel", "roller", "mean", "torque", "brake")


def assumed(case: Case) -> Wheel:
    """Wheel and roller as the controller assumes them."""
    own = {name: getattr(rig_of(case)[1].assumed, name) for name in Wheel.__dataclass_fields__}
    return replace(wheel_of(case), **{name: value for name, value in own.items() if value is not None})


def pulse(bandwidth_hz: float, sample: float) -> float:
    """What a low-pass of first order takes over in a sample."""
    return 1.0 - math.exp(-2.0 * math.pi * bandwidth_hz * sample)


def observer(case: Case, z: Signals) -> None:
    """Luenberger observer of roller speed and contact force, both poles at the bandwidth; filtered acceleration of the wheel."""
    p, estimator, h = assumed(case), rig_of(case)[1].estimator, rig_of(case)[1].sample_time
    w, damping = 2.0 * math.pi * estimator.bandwidth * h, estimator.damping_ratio
    poles = np.exp(-damping * w + np.array([1.0, -1.0]) * w * np.emath.sqrt(damping**2 - 1.0))
    predicted = z["roller_estimate"] + h * (z["mean"] + p.roller_radius * z["force"]) / p.roller_inertia
    error = z["roller"] - predicted
    z["roller_estimate"] = predicted + (1.0 - np.prod(poles).real) * error
    z["force"] = z["force"] + np.prod(1.0 - poles).real * p.roller_inertia / (p.roller_radius * h) * error
    torque_from_acceleration(case, z)


def filtered_derivative(case: Case, z: Signals) -> None:
    """Low-pass of the first order behind the difference of the roller's speed."""
    p, control = assumed(case), rig_of(case)[1]
    rate = (z["roller"] - z["roller_estimate"]) / control.sample_time
    raw = (p.roller_inertia * rate - z["mean"]) / p.roller_radius
    z["force"] = z["force"] + pulse(control.estimator.bandwidth, control.sample_time) * (raw - z["force"])
    z["roller_estimate"] = z["roller"]
    torque_from_acceleration(case, z)


def torque_from_acceleration(case: Case, z: Signals) -> None:
    """(D2) with the wheel's acceleration behind a low-pass."""
    p, control = assumed(case), rig_of(case)[1]
    h, low_pass = control.sample_time, pulse(control.estimator.bandwidth, control.sample_time)
    z["wheel_rate"] = z["wheel_rate"] + low_pass * ((z["wheel"] - z["wheel_estimate"]) / h - z["wheel_rate"])
    z["wheel_estimate"] = z["wheel"]
    z["axle_torque"] = p.wheelset_inertia * z["wheel_rate"] + p.wheel_radius * z["force"]


def kalman(case: Case, z: Signals) -> None:
    """Stationary Kalman filter of both speeds, force and torque, (D10) to (D12) with absent changes."""
    p, estimator, h = assumed(case), rig_of(case)[1].estimator, rig_of(case)[1].sample_time
    rates = np.zeros((4, 4))
    rates[0, 2] = p.roller_radius / p.roller_inertia
    rates[1, 2:] = -p.wheel_radius / p.wheelset_inertia, 1.0 / p.wheelset_inertia
    per_root = (2.0 * math.pi * estimator.bandwidth) ** 2 * estimator.speed_noise * math.sqrt(h)
    inertias = p.roller_inertia / p.roller_radius, p.wheelset_inertia + p.roller_inertia * p.ratio
    walk = np.diag([0.0, 0.0, (per_root * inertias[0]) ** 2, (per_root * inertias[1]) ** 2])
    noise = h * walk + h**2 / 2.0 * (rates @ walk + walk @ rates.T) + h**3 / 3.0 * rates @ walk @ rates.T
    step, speeds = np.eye(4) + h * rates, np.eye(4)[:2]
    scale = np.diag([1.0, 1.0, *(1.0 / np.sqrt(np.diag(noise)[2:]))])  # numbers of one size
    back, measured = np.linalg.inv(scale), estimator.speed_noise**2 * np.eye(2)
    found = back @ solve_discrete_are((scale @ step @ back).T, speeds.T, scale @ noise @ scale, measured) @ back
    gain = found[:, :2] @ np.linalg.inv(found[:2, :2] + measured)
    state = np.stack([z[name] for name in ESTIMATOR[:4]])
    predicted = np.tensordot(step, state, axes=1)
    predicted[0] += h * z["mean"] / p.roller_inertia
    corrected = predicted + np.tensordot(gain, np.stack([z["roller"], z["wheel"]]) - predicted[:2], axes=1)
    z |= dict(zip(ESTIMATOR, corrected, strict=False))


ESTIMATORS: dict[str, Callable[[Case, Signals], None]] = {
    "observer": observer,
    "filtered_derivative": filtered_derivative,
    "kalman": kalman,
}


def torque_of_axle(case: Case, z: Signals) -> Array:
    """What the virtual axle takes for its torque: the estimate, its extrapolation (D19), or the known torque (D18)."""
    control, estimate = rig_of(case)[1], z["axle_torque"]
    h, table = control.sample_time, control.axle_torque
    if table.kind == "known":
        known = table.brake_friction * z["brake"]
        z["late"] = z["late"] + pulse(control.estimator.bandwidth, h) * (known - z["late"])
        beyond = estimate - z["late"] - z["correction"]
        z["correction"] = z["correction"] + pulse(table.correction, h) * beyond
        return known + z["correction"]
    if table.kind == "extrapolated":
        z["slope"] = z["slope"] + pulse(table.bandwidth, h) * ((estimate - z["last_torque"]) / h - z["slope"])
        z["last_torque"] = estimate
        return np.asarray(estimate + table.ahead * z["slope"])
    return estimate


def virtual_creep(case: Case) -> float:
    """Slope of the virtual rail's force over sliding, of an axle [N s/m]: creepage is over a speed with its regularisation."""
    assert case.adhesion is not None
    model, small = assemble_with_actuators(case), 1e-7
    patch = patch_of(model)
    force = creep_curve(case, patch, case.adhesion.rail.friction.mu_0, np.array([small]))[1][0]
    axle = model.axle_loads[model.wheelsets[0]]
    grown = 2.0 * patch.load * (axle / (2.0 * patch.load)) ** (2.0 / 3.0)  # f11 grows as the patch
    speed = math.hypot(case.motion.speed, case.contact.creepage_regularisation_speed)
    return float(force * grown / (small * speed))


def command(case: Case, z: Signals, creep: float, mass: float) -> Array:
    """Command of one sample: estimate, virtual axles and train, (D3) to (D5), feedback, compensation of the drive."""
    wheel, p, control = wheel_of(case), assumed(case), rig_of(case)[1]
    h = control.sample_time
    ESTIMATORS[control.estimator.kind](case, z)
    torque = torque_of_axle(case, z)

    slope = wheel.wheel_radius * creep  # force per virtual axle speed
    stiffness = wheel.wheel_radius * slope / wheel.wheelset_inertia
    reach = h - 1.0 / stiffness if stiffness * h > 2.0 else 0.5 * h  # of the theta method
    train = (z["train"] + 0.5 * h * z["train_rate"]) / wheel.wheel_radius
    rate = (torque / wheel.wheelset_inertia - stiffness * (z["virtual"] - train)) / (1.0 + stiffness * reach)
    force = slope * (z["virtual"] + reach * rate - train)
    z["virtual"] = z["virtual"] + h * rate
    z["train_rate"] = force.sum(axis=0, keepdims=True) / mass
    z["train"] = z["train"] + h * z["train_rate"]

    feed_forward = p.roller_inertia * wheel.wheel_radius / p.roller_radius * rate - p.roller_radius * force
    error = z["virtual"] - z["wheel"]
    z["sum"] = z["sum"] + h * error
    law = drive_command(control)
    kind = control.drive_command.kind
    ahead = (law.ahead if kind == "lead" else 0.0) / h * (feed_forward - z["feed_forward"])
    z["feed_forward"] = feed_forward
    proportional, integral = feedback_gains(assemble_with_actuators(case))
    wanted = feed_forward + proportional * error + integral * z["sum"]
    return np.asarray(wanted + ahead + (law.gain if kind == "torque_loop" else 0.0) * (wanted - z["torque"]))


def controller_matrix(case: Case, axles: int, mass: float, *, sliding: bool) -> Array:
    """Rows states and commands, columns states and inputs, of a case with PI feedback whose virtual train has a mass [kg]."""
    names = (*ESTIMATOR, *LAWS)
    states = axles * len(names) + 2
    unit = np.eye(states + axles * len(INPUTS))
    z = dict(
        zip(
            (*names, *INPUTS),
            np.delete(unit, [states - 2, states - 1], axis=0).reshape(-1, axles, len(unit)),
            strict=True,
        )
    )
    z |= {"train": unit[[states - 2]], "train_rate": unit[[states - 1]]}
    commands = command(case, z, 0.0 if sliding else virtual_creep(case), mass)
    return np.concatenate([*(z[name] for name in names), z["train"], z["train_rate"], commands])
