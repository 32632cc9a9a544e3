"""Where the limits of a rig should lie by hand: closed forms beside the map.

Equations: docs/theory/envelope.md. Torques are magnitudes per axle [N m]; an adhesion may be an array.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rollerrig.assembly import assemble
from rollerrig.bench.virtual_train import load_transfer, train_mass
from rollerrig.config import Case, Motor, Rig, SlideProtection, WheelSlipControl

Array = NDArray[np.float64]


@dataclass(frozen=True)
class RigNumbers:
    """What the closed forms take."""

    wheel_radius: float
    """r [m]"""
    roller_radius: float
    """R [m]"""
    wheelset_inertia: float
    """J_w [kg m^2]"""
    roller_inertia: float
    """J_r of a roller axle [kg m^2]"""
    axle_load: float
    """N [N]"""
    train_mass: float
    """M that these axles brake or pull [kg]"""
    axles: int
    friction: float
    """mu_r between wheel and roller [-]"""
    drive_torque: float
    """U_max of a roller's drive [N m]; infinite: no limit is known"""
    load_transfer: float = 0.0
    """kappa: load that one axle loses and another gains, over the contact force of an axle [-]"""
    reproduced_transfer: float = 0.0
    """kappa_v: the same of the virtual train [-]"""

    @property
    def _inertia_share(self) -> float:
        """Part of a torque that turns the wheels where they grip, n J_w / (M r^2)."""
        return self.axles * self.wheelset_inertia / (self.train_mass * self.wheel_radius**2)

    @property
    def _lever(self) -> float:
        """Excess of axle torque that a roller's drive can follow over its own torque, J_w R / (J_r r)."""
        return self.wheelset_inertia * self.roller_radius / (self.roller_inertia * self.wheel_radius)

    def torque_of_force(self, force: Array | float) -> Array:
        """Axle torque for a contact force where the wheels grip, (V1)."""
        return np.asarray(self.wheel_radius * force * (1.0 + self._inertia_share), dtype=np.float64)

    def grip(self, adhesion: Array | float) -> Array:
        """Beyond it a wheel on the degraded rail slides, (V2)."""
        mu = np.asarray(adhesion)
        return self.torque_of_force(mu / (1.0 + mu * self.reproduced_transfer) * self.axle_load)

    def contact(self) -> float:
        """Beyond it a wheel that grips on the rail slides on its roller, (V3)."""
        return float(self.torque_of_force(self._contact_share * self.axle_load))

    def contact_adhesion(self) -> float:
        """On a rail that gives more than that a wheel that slides on it slides on its roller as well: (V2) with (V3)."""
        return self._contact_share / (1.0 - self._contact_share * self.reproduced_transfer)

    @property
    def _contact_share(self) -> float:
        """Largest mean force of the axles over their load."""
        return self.friction / (1.0 + self.friction * self.load_transfer)

    def drive_grip(self) -> float:
        """Beyond it a roller's drive cannot carry the force of a rail on which the wheel grips, (V4)."""
        arm = self.roller_radius - self.axles * self.roller_inertia / (self.roller_radius * self.train_mass)
        return float(self.torque_of_force(self.drive_torque / arm)) if arm > 0.0 else np.inf

    def drive_slide(self, adhesion: Array | float) -> Array:
        """Beyond it a roller's drive cannot follow a wheel into its slide, (V5); adhesion is that at the slip of the slide."""
        mu = np.asarray(adhesion)
        force = mu * (1.0 - mu * self.reproduced_transfer) * self.axle_load
        spare = self.drive_torque + self.roller_radius * force
        return np.asarray(self.wheel_radius * force + self._lever * spare)

    def drive_recovery(self, adhesion: Array | float) -> Array:
        """Below it a roller's drive cannot follow a wheel out of its slide, (V6): torque must be left on the axle."""
        mu = np.asarray(adhesion)
        return self.recovery_at(mu * (1.0 + mu * self.reproduced_transfer) * self.axle_load)

    def recovery_at(self, force: Array | float) -> Array:
        """The same for a force of the rail on the axle."""
        spare = self.drive_torque - self.roller_radius * np.asarray(force)
        return np.asarray(self.wheel_radius * force - self._lever * spare)


def rig_numbers(case: Case) -> RigNumbers:
    """The numbers of a case of a rig with [rig_control]."""
    rig, control, model = case.support.data, case.rig_control, assemble(case)
    assert isinstance(rig, Rig)
    assert control is not None
    largest = np.inf if control.user is not None else control.feedback.largest
    if control.motor.envelope is not None:
        speeds, torques = np.array(control.motor.envelope).T
        largest = min(largest, float(np.interp(case.motion.speed / rig.roller_radius, speeds, torques)))
    loads, mass = [model.axle_loads[name] for name in model.wheelsets], train_mass(model)
    own = case.model_copy(update={"rig_control": control.model_copy(update={"load_transfer": "quasi_static"})})
    return RigNumbers(
        wheel_radius=case.vehicle.data.wheel.radius,
        roller_radius=rig.roller_radius,
        wheelset_inertia=model.inertias[model.wheelsets[0]][1] + _rotor(case.traction.motor if case.traction else None),
        roller_inertia=rig.roller_inertia[1] + _rotor(control.motor),
        axle_load=sum(loads) / len(loads),
        train_mass=mass,
        axles=len(loads),
        friction=case.contact.friction,
        drive_torque=float(largest),
        load_transfer=_per_force(load_transfer(assemble(own)), mass),
        reproduced_transfer=_per_force(load_transfer(model), mass),
    )


def _rotor(motor: Motor | None) -> float:
    """Inertia of a drive's rotor on the driven axle [kg m^2]."""
    return motor.rotor_inertia * motor.gear_ratio**2 if motor is not None else 0.0


def _per_force(per_acceleration: Sequence[float], mass: float) -> float:
    """Largest change of load [kg per acceleration] over the contact force of an axle, of n that move the train."""
    return len(per_acceleration) * max(map(abs, per_acceleration)) / mass


def held_slip(case: Case) -> float:
    """Slip that slide protection, of a case with [brake], or wheel-slip control lets a wheel reach before it acts [-]."""
    if case.brake is not None:
        return (case.slide_protection or SlideProtection()).vent_slip
    return (case.wheel_slip_control or WheelSlipControl()).slip
