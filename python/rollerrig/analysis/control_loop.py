"""The contact in steady rolling, and the rig's control loop about it, linearised: gain and phase margin in closed form.

    Case -> equilibrium -> [contact_state] -> approach, creep stiffness, kinematic wavelength
    Case -> [loop_of, users_loop] -> Loop -> [margins]          one axle in continuous time, (Q1) and (Q2)
                              -> analysis.loop_stability        eigenvalues of the sampled loop, with or without the vehicle

Small motion about steady running: no limits, constant friction. Equations: docs/theory/rig_control.md.
"""

import math
from dataclasses import dataclass, replace

import numpy as np
import xarray as xr

from rollerrig import _core
from rollerrig.analysis.linear_controller import identified_controller, linear_controller
from rollerrig.analysis.linear_system import Margins, margins_of
from rollerrig.analysis.mode_names import HUNTING_SHARE, wheelset_lateral_share
from rollerrig.analysis.modes import Lineariser, eigensystem, energy_shares, oscillates
from rollerrig.assembly.actuators import assemble_with_actuators
from rollerrig.assembly.laws import angular, linear_coefficients, part_of
from rollerrig.cases import rig_of, wheelsets, without_actuators
from rollerrig.common.arrays import Array, Complex
from rollerrig.config import Case, Rig
from rollerrig.config.schema.rig_control import ExactEstimator, ProportionalIntegral, SlidingMode, TorqueLoop
from rollerrig.simulation.controllers import users_controllers
from rollerrig.simulation.mechatronics import feedback_gains, rig_controller, rotor_inertia
from rollerrig.simulation.starting_state import recorded_state

SLOW = 5 / 3.6  # speed at which the hunting mode is kinematic: inertia plays no part [m/s]
REFERENCE_SPEED = 100 / 3.6  # speed at which approach and creep stiffness are read; they hardly depend on it [m/s]


@dataclass(frozen=True)
class ContactState:
    """Numbers of one wheel of the leading wheelset, and of the kinematic motion."""

    patches: int  # number of patches
    approach: float  # of the deepest patch [m]
    creep_stiffness: float  # sum of f11 over its patches, linear theory [N]
    wavelength: float  # of slow hunting [m]; NaN if the motion does not oscillate


@dataclass(frozen=True)
class RollingState:
    """Steady rolling at one speed [m/s]: every signal of the wheels, as of a run without time.

    Creep stiffness: per wheel the sum of f11 over its patches, linear theory [N].
    """

    speed: float
    wheels: xr.Dataset
    creep_stiffness: dict[str, float]


def rolling_state(case: Case | Lineariser, speed: float) -> RollingState:
    """The equilibrium at a speed [m/s], recorded; StartError: none was found."""
    lineariser = case if isinstance(case, Lineariser) else Lineariser(case)
    linear = lineariser.at(speed)
    wheels = recorded_state(lineariser.simulation_at(speed), lineariser.model, linear.equilibrium).isel(time=0)
    stiffness = {}
    for name in map(str, wheels["wheel"].to_numpy()):
        wheel, total = wheels.sel(wheel=name), 0.0
        for k in range(int(wheel["patch_count"])):
            a, b = float(wheel["patch_a"][k]), float(wheel["patch_b"][k])
            total += linear_coefficients(lineariser.case.contact, a, b)[0]
        stiffness[name] = total
    return RollingState(speed, wheels, stiffness)


def contact_state(case: Case) -> ContactState:
    """The contact of the leading left wheel in steady rolling, and the wavelength of slow hunting."""
    lineariser = Lineariser(case)
    state = rolling_state(lineariser, REFERENCE_SPEED)
    wheel = state.wheels.isel(wheel=0)
    count, stiffness = int(wheel["patch_count"]), state.creep_stiffness[str(wheel["wheel"].item())]
    return ContactState(count, float(wheel["patch_approach"].max()), stiffness, slow_wavelength(lineariser))


def slow_wavelength(lineariser: Lineariser, speed: float = SLOW) -> float:
    """Wavelength of the least damped mode in which wheelsets weave, at low speed [m]; NaN if none oscillates.

    Klingel's for a lone wheelset, 2 pi sqrt(r l0 / conicity); times sqrt(1 + (half base / l0)^2) for a rigid bogie.
    """
    linear = lineariser.at(speed)
    system = eigensystem(linear.matrix)
    columns = np.flatnonzero(oscillates(system.values)).tolist()
    weave = wheelset_lateral_share(list(linear.rate_rows), energy_shares(linear, system, columns)) >= HUNTING_SHARE
    weaving = system.values[columns][weave]
    if not weaving.size:
        return math.nan
    return 2 * math.pi * speed / float(weaving[np.argmax(weaving.real)].imag)


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


@dataclass(frozen=True)
class Loop:
    """What closes around the axles: of each the same."""

    wheel: Wheel  # wheelset and roller
    axles: int
    creep: float  # slope of the contact's force over sliding, both wheels [N s/m]
    drive_bandwidth: float  # of the roller drive's torque loop [rad/s]
    drive_damping: float  # of a second-order one; 0: first order
    # step, sample, delay: sampling step, sample time, delay of the command [s]
    step: float
    sample: float
    delay: float
    # proportional, integral: gains on virtual minus measured axle speed [N m s/rad, N m/rad]
    proportional: float
    integral: float
    torque_gain: float  # of the loop around the drive, (D21) [-]
    controller: Array  # see analysis.linear_controller
    feedback: Array  # part of it that is in proportion to the gains

    def scaled(self, factor: float) -> "Loop":
        """This loop with both gains times a factor."""
        return replace(
            self,
            proportional=factor * self.proportional,
            integral=factor * self.integral,
            controller=self.controller + (factor - 1.0) * self.feedback,
            feedback=factor * self.feedback,
        )


def wheel_of(case: Case) -> Wheel:
    """Wheelset and roller of a rig's case, each with the rotor of its motor."""
    rig, control = case.support.data, case.rig_control
    assert isinstance(rig, Rig)
    wheelset = wheelsets(case)[0].inertia[1]
    wheelset += rotor_inertia(case.traction.motor if case.traction is not None else None)
    roller = rig.roller_inertia[1] + rotor_inertia(control.motor if control is not None else None)
    return Wheel(wheelset, roller, case.vehicle.data.wheel.radius, rig.roller_radius)


def creep_slope(case: Case) -> float:
    """Slope of an axle's creep force over sliding at small creepage [N s/m]: sum of f11 over both wheels, over speed."""
    stiffness = rolling_state(without_actuators(case), case.motion.speed).creep_stiffness
    return 2.0 * sum(stiffness.values()) / len(stiffness) / case.motion.speed


LARGE = 1e9  # torque that no small motion reaches [N m]


def loop_of(case: Case, creep: float, *, sliding: bool) -> Loop | None:
    """The loop of a case of a rig with our own [rig_control], and the creep slope of its contact, see `creep_slope`.

    The virtual wheels roll, or slide on a rail that gives nothing. None where the linear loop does not know what is measured: the
    forces that really act, a torque by other means than the drive's own, motors with rotors.
    """
    control = case.rig_control
    if control is None or not control.is_ours or not _measures_motions(case):
        return None
    unmoved = {"rig_control.load_transfer": "none"}  # which acts where wheels slip
    model = assemble_with_actuators(case.with_changes(unmoved))
    law = rig_controller(model)
    gains = (0.0, 0.0)
    if isinstance(control.feedback, ProportionalIntegral):
        gains = feedback_gains(model)
    elif isinstance(control.feedback, SlidingMode):  # within its boundary layer, however thin
        gains = (control.feedback.switching / control.feedback.boundary_layer, 0.0)

    def with_gains(proportional: float, integral: float) -> Array:
        of_none = {"bandwidth": 1.0, "damping_ratio": 1.0}  # from which other gains would follow
        feedback = _core.ProportionalIntegralFeedback(**of_none, proportional=proportional, integral=integral)
        unlimited = part_of(_core.RigControl, law, feedback=feedback, largest=LARGE)
        return linear_controller(model, unlimited, sliding=sliding)

    own = with_gains(*gains)
    return _loop(case, creep, control.sample_time, own, own - with_gains(0.0, 0.0), *gains)


def users_loop(case: Case, creep: float) -> Loop:
    """The same of a user's controller, whose virtual wheels roll, in a case whose own controller has a loop.

    Raises:
        ConfigError: it cannot be used.
        ControllerError: it has no linear loop; the message says why.
    """
    sample = users_controllers(case, {})["rig_control"].sample_time
    own = identified_controller(assemble_with_actuators(case), sample)
    return _loop(case, creep, sample, own, np.zeros_like(own))


def _measures_motions(case: Case) -> bool:
    """Whether all that a controller is given follows from the small motions of a rig without rotors."""
    control = rig_of(case)[1]
    motors = (control.motor, *((case.traction.motor,) if case.traction is not None else ()))
    exact = isinstance(control.estimator, ExactEstimator)
    as_driven = control.estimator.torque == "measured" and case.sensors.roller_torque is None
    return as_driven and not exact and not any(motor.rotor_inertia for motor in motors)


def _loop(
    case: Case, creep: float, sample: float, controller: Array, feedback: Array, k_p: float = 0.0, k_i: float = 0.0
) -> Loop:
    control = rig_of(case)[1]
    command = control.drive_command
    return Loop(
        wheel=wheel_of(case),
        axles=len(wheelsets(case)),
        creep=creep,
        drive_bandwidth=angular(control.motor.bandwidth),
        drive_damping=control.motor.damping_ratio,
        step=case.time.sampling_step,
        sample=sample,
        delay=control.delay,
        proportional=k_p,
        integral=k_i,
        torque_gain=command.gain if isinstance(command, TorqueLoop) else 0.0,
        controller=controller,
        feedback=feedback,
    )


def open_loop(loop: Loop, frequency: Array) -> Complex:
    """Frequency response of the feedback's open loop, (Q1), over angular frequency [rad/s]."""
    s = 1j * np.asarray(frequency)
    wheel, w = loop.wheel, loop.drive_bandwidth
    turning = wheel.roller_radius**2 * wheel.wheelset_inertia + wheel.wheel_radius**2 * wheel.roller_inertia
    both = wheel.wheelset_inertia * wheel.roller_inertia / loop.creep
    plant = wheel.wheel_radius * wheel.roller_radius / (s * (turning + both * s))
    lag = s / w + 1.0 if loop.drive_damping == 0.0 else (s / w) ** 2 + 2.0 * loop.drive_damping * s / w + 1.0
    dead_time = np.exp(-s * (loop.delay + 0.5 * loop.sample))
    drive = (1.0 + loop.torque_gain) / (lag + loop.torque_gain)
    return np.asarray((loop.proportional + loop.integral / s) * plant * drive * dead_time)


def margins(loop: Loop) -> Margins:
    """Gain and phase margin of the feedback loop of one axle alone."""
    frequency = np.geomspace(1e-3, math.pi / loop.step, 4000)
    return margins_of(frequency / (2.0 * math.pi), open_loop(loop, frequency))
