"""Limits of a rig that reproduces a degraded rail: closed forms, and which one a run reached first.

    Case of a rig with [rig_control] -> [rig_limits] -> RigLimits -> limits over adhesion, magnitudes per axle [N m]
    Case, adhesion of its rail       -> [creep_peak] -> peak of the virtual rail's creep curve, from the core's laws
    Dataset of a run -> [assess_limits] -> numbers, limits reached with their times, region of the operating envelope

The closed forms are (V1) to (V6) of docs/theory/envelope.md: rolling without sliding, steady forces, no lag of drives and
estimator. An adhesion may be an array.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr

from rollerrig.analysis.slide_statistics import spells, tracking, under_test, virtual_slip, wheel_radius
from rollerrig.analysis.virtual_rail import FULL_SLIDING, creep_curve, creep_peak, patch_of
from rollerrig.assembly.model import assemble
from rollerrig.assembly.train_axles import train_mass
from rollerrig.cases import rig_of
from rollerrig.common.arrays import Array, Mask
from rollerrig.config import Case, SlideProtection, WheelSlipControl
from rollerrig.results import COMPLETED
from rollerrig.simulation.mechatronics import rotor_inertia, wheelset_inertia
from rollerrig.simulation.virtual_train import load_transfer

LINES = {
    "line_grip": "rail: wheel begins to slide (V2)",
    "line_contact": "roller: wheel begins to slide (V3)",
    "line_drive_grip": "drive carries the rail's force (V4)",
    "line_drive_slide": "drive follows into the slide (V5)",
    "line_drive_recovery": "torque to be left for recovery (V6)",
    "line_vehicle": "vehicle's own brake or motor",
}
"""Closed form -> meaning; magnitudes [N m]."""

PITCHING = 1.04
"""Part of the friction that an axle uses while the bogie pitches, over that at rest, as measured in runs [-]."""


@dataclass(frozen=True)
class RigLimits:
    """Closed forms of one rig, vehicle and load."""

    # wheel_radius, roller_radius: r, R [m]
    wheel_radius: float
    roller_radius: float
    # wheelset_inertia, roller_inertia: J_w, J_r of an axle with its rotor [kg m^2]
    wheelset_inertia: float
    roller_inertia: float
    axle_load: float  # N [N]
    train_mass: float  # M that these axles brake or pull [kg]
    axles: int  # n
    friction: float  # mu_r between wheel and roller [-]
    drive_torque: float  # U_m of a roller drive [N m]; infinite: not limited
    load_transfer: float  # kappa: load that one axle loses and another gains, over the contact force of an axle [-]
    virtual_transfer: float  # kappa_v: the same of the virtual train [-]

    @property
    def _lever(self) -> float:
        """lambda: excess of axle torque that a roller drive can follow over its own torque, J_w R / (J_r r)."""
        return self.wheelset_inertia * self.roller_radius / (self.roller_inertia * self.wheel_radius)

    @property
    def _contact_share(self) -> float:
        """Largest mean force of the axles over their load, (V3): of the friction that counts as sliding."""
        friction = FULL_SLIDING * self.friction
        return friction / (1.0 + friction * self.load_transfer)

    def torque_of_force(self, force: Array | float) -> Array:
        """Axle torque for a contact force where the wheels grip, (V1)."""
        inertia_share = self.axles * self.wheelset_inertia / (self.train_mass * self.wheel_radius**2)
        return np.asarray(self.wheel_radius * force * (1.0 + inertia_share), dtype=np.float64)

    def grip(self, adhesion: Array | float) -> Array:
        """Beyond it a wheel on the degraded rail slides, (V2)."""
        mu = np.asarray(adhesion)
        return self.torque_of_force(mu / (1.0 + mu * self.virtual_transfer) * self.axle_load)

    def grip_of_loaded(self, adhesion: Array | float) -> Array:
        """Beyond it also the axle that gains load slides on the degraded rail; up to here it carries its whole torque."""
        mu = np.asarray(adhesion)
        return self.torque_of_force(mu / (1.0 - mu * self.virtual_transfer) * self.axle_load)

    def contact(self) -> float:
        """Beyond it a wheel that grips on the rail slides on its roller, (V3)."""
        return float(self.torque_of_force(self._contact_share * self.axle_load))

    def contact_adhesion(self) -> float:
        """On a rail with more adhesion than this a wheel that slides on it slides on its roller as well: (V2) with (V3)."""
        return self._contact_share / (1.0 - self._contact_share * self.virtual_transfer)

    def drive_grip(self) -> float:
        """Beyond it a roller drive cannot reproduce the force of a rail on which the wheel grips, (V4)."""
        arm = self.roller_radius - self.axles * self.roller_inertia / (self.roller_radius * self.train_mass)
        return float(self.torque_of_force(self.drive_torque / arm)) if arm > 0.0 else np.inf

    def drive_slide(self, adhesion: Array | float) -> Array:
        """Beyond it a roller drive cannot follow a wheel into its slide, (V5); adhesion is that at the slip of the slide."""
        mu = np.asarray(adhesion)
        force = mu * (1.0 - mu * self.virtual_transfer) * self.axle_load
        return np.asarray(self.wheel_radius * force + self._lever * (self.drive_torque + self.roller_radius * force))

    def drive_recovery(self, adhesion: Array | float) -> Array:
        """Below it a roller drive cannot follow a wheel out of its slide, (V6): torque that must remain on the axle."""
        mu = np.asarray(adhesion)
        return self.recovery_at(mu * (1.0 + mu * self.virtual_transfer) * self.axle_load)

    def recovery_at(self, force: Array | float) -> Array:
        """The same for a force of the rail on the axle."""
        spare = self.drive_torque - self.roller_radius * np.asarray(force)
        return np.asarray(self.wheel_radius * force - self._lever * spare)


def rig_limits(case: Case) -> RigLimits:
    """The closed forms of a case of a rig with [rig_control]; StartError: the vehicle has no equilibrium on track."""
    (rig, control), model = rig_of(case), assemble(case)
    largest = control.feedback.largest if control.is_ours else np.inf
    if control.motor.envelope is not None:
        speeds, torques = np.array(control.motor.envelope).T
        largest = min(largest, float(np.interp(case.motion.speed / rig.roller_radius, speeds, torques)))
    loads, mass = [model.axle_loads[name] for name in model.wheelsets], train_mass(model)
    own = case.model_copy(update={"rig_control": control.model_copy(update={"load_transfer": "quasi_static"})})
    return RigLimits(
        wheel_radius=case.vehicle.data.wheel.radius,
        roller_radius=rig.roller_radius,
        wheelset_inertia=wheelset_inertia(model),
        roller_inertia=rig.roller_inertia[1] + rotor_inertia(control.motor),
        axle_load=sum(loads) / len(loads),
        train_mass=mass,
        axles=len(loads),
        friction=case.contact.friction.mu_0,
        drive_torque=float(largest),
        load_transfer=_per_force(load_transfer(assemble(own)), mass),
        virtual_transfer=_per_force(load_transfer(model), mass),
    )


def _per_force(per_acceleration: Sequence[float], mass: float) -> float:
    """Largest change of load [kg per acceleration] over the contact force of an axle, of n that move the train."""
    return len(per_acceleration) * max(map(abs, per_acceleration)) / mass


def closed_forms(case: Case, adhesion: Array) -> dict[str, Any]:
    """The closed forms of LINES by name where each of them applies, NaN elsewhere [N m], and `contact_adhesion` [-].

    Over adhesions of the rail at no slip, ascending. The case has the load; whether it brakes or pulls sets the slip of a slide.
    """
    rig, patch = rig_limits(case), patch_of(assemble(case))
    peak = np.array([creep_peak(case, patch, float(mu))[1] for mu in adhesion])
    slip = np.array([protection_slip(case)])
    at_protection = np.array([creep_curve(case, patch, float(mu), slip)[0][0] for mu in adhesion])
    grip, slide = rig.grip(peak), rig.drive_slide(at_protection)
    recovery = rig.drive_recovery(peak)  # at the end of it, where adhesion is back
    contact, drive = rig.contact(), rig.drive_grip()
    near = PITCHING * grip >= contact  # there a wheel that begins to slide on the rail slides on the roller, too
    return {
        "axle_load": rig.axle_load,
        "contact_adhesion": float(np.interp(rig.contact_adhesion() / PITCHING, peak, adhesion, right=np.nan)),
        "line_grip": grip,
        "line_contact": np.where(near, np.minimum(contact, grip), np.nan),
        "line_drive_grip": np.where(drive <= rig.grip_of_loaded(peak), drive, np.nan),
        "line_drive_slide": np.where(slide >= grip, slide, np.nan),
        "line_drive_recovery": np.where((recovery > 0.0) & (recovery < grip), recovery, np.nan),
    }


def protection_slip(case: Case) -> float:
    """Slip that slide protection, of a case with [brake], or wheel-slip control lets a wheel reach before it acts [-]."""
    if case.brake is not None:
        return (case.slide_protection or SlideProtection()).vent_slip
    return (case.wheel_slip_control or WheelSlipControl()).slip


Record = dict[str, Any]

TRACKING_LIMIT = 0.01  # tracking error, RMS over train speed, up to which the rig reproduces the rail [-]
LEAST_DURATION = 0.03  # a limit counts where it persists for at least this time; the corner of a ramp is shorter [s]

REGIONS: Mapping[str, str] = {
    "grip": "reproduced, wheels grip",
    "slide": "reproduced, wheels slide",
    "held": "reproduced, a brake holds a wheel",
    "drive_grip": "drive at its limit, wheels grip",
    "drive_slide": "drive at its limit, into the slide",
    "drive_recovery": "drive at its limit, out of the slide",
    "drive_power": "drive at its limit of power",
    "contact": "wheel slides on roller",
    "tracking": "no limit reached, tracking error above 1 %",
    "failed": "run failed",
}
"""Region of the operating envelope -> meaning."""

REPRODUCED = ("grip", "slide", "held")

NUMBERS = {
    "tracking_rms": ("1", "wheel less virtual wheel over train speed, RMS over time and axles"),
    "tracking_largest": ("1", "the same, largest"),
    "slip_largest": ("1", "largest slip of a virtual wheel"),
    "friction_used": ("1", "creep force over friction times normal force between wheel and roller, largest"),
    "real_sliding_mps": ("m/s", "wheel surface speed less that of the roller, largest"),
    "roller_torque_nm": ("N m", "largest torque of a roller drive"),
    "roller_power_w": ("W", "largest power of a roller drive"),
    "recovery_margin_nm": (
        "N m",
        "least torque on an axle that comes out of a slide, over what (V6) asks for; NaN: none does",
    ),
}
"""Number of a record -> unit and meaning."""


def assess_limits(run: xr.Dataset, case: Case, torque: float, grip_slip: float, rig: RigLimits | None = None) -> Record:
    """Numbers and limits of a run of the operating envelope.

    Of a torque on each axle, positive forward [N m], the slip up to which a virtual wheel grips [-], and closed forms for the
    margin of (V6); None: that is left out. The record has the `region` of REGIONS: the limit reached first, or the kind of run
    where there is none; `limits`: all that were reached, with their times [s]; the numbers of NUMBERS, None where not defined;
    `status` and `message` of the run.
    """
    slip = np.abs(virtual_slip(run).to_numpy())
    used = friction_used(run, case.contact.friction.mu_0)
    limits = {**_contact_limit(run, used), **_drive_limits(run, case, torque, slip > grip_slip)}
    rms, largest = tracking(run)
    slip_largest = float(np.nanmax(slip)) if np.isfinite(slip).any() else 0.0
    status, roller = str(run.attrs["status"]), np.abs(run["roller_torque"].to_numpy())
    kind = "held" if _held(run, case) else "slide" if slip_largest > grip_slip else "grip"
    return {
        "region": region(status, limits, rms, kind),
        "limits": dict(sorted(limits.items(), key=lambda item: item[1])),
        "tracking_rms": _finite(rms),
        "tracking_largest": _finite(largest),
        "slip_largest": slip_largest,
        "friction_used": float(used.max(initial=0.0)),
        "real_sliding_mps": float(np.abs(run["real_sliding"].to_numpy()).max(initial=0.0)),
        "roller_torque_nm": float(roller.max(initial=0.0)),
        "roller_power_w": float((roller * np.abs(run["roller_speed"].to_numpy())).max(initial=0.0)),
        "recovery_margin_nm": None if rig is None else _finite(_recovery_margin(run, torque, slip > grip_slip, rig)),
        "status": status,
        "message": "" if status in COMPLETED else str(run.attrs["status_message"]),
    }


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None


def failed(status: str, message: str) -> Record:
    """The record of a run that could not start."""
    return {"region": "failed", "limits": {}, **dict.fromkeys(NUMBERS), "status": status, "message": message}


def _held(run: xr.Dataset, case: Case) -> bool:
    """Whether a brake holds a wheel of the virtual train for LEAST_DURATION while that runs, (D15)."""
    control, rolling = rig_of(case)[1], wheel_radius(run) * np.abs(run["virtual_speed"].to_numpy())
    runs = run["train_speed"].to_numpy()[:, None] - rolling > control.locked_speed
    return persists_since(run["time"].to_numpy(), (rolling < control.locked_speed) & runs) is not None


def _recovery_margin(run: xr.Dataset, torque: float, sliding: Mask, rig: RigLimits) -> float:
    """Least torque over what (V6) asks for, on an axle whose virtual wheel slides and regains speed [N m]; NaN: none does."""
    time, speed = run["time"].to_numpy(), run["virtual_speed"].to_numpy()
    out = sliding & (-np.sign(torque) * np.gradient(speed, time, axis=0) > 0.0)
    acting = np.sign(torque) * (run["brake_torque"] + run["traction_torque"]).to_numpy()
    margin = acting - rig.recovery_at(np.abs(run["virtual_force"].to_numpy()))
    return float(margin[out].min()) if out.any() else math.nan


def region(status: str, limits: Mapping[str, float], tracking_rms: float, kind: str) -> str:
    """The region of a run, a key of REGIONS; its kind, of REPRODUCED, where none of the limits, by when [s], was reached."""
    if status not in (*COMPLETED, "rollers_protected"):
        return "failed"
    if limits:
        return min(limits, key=lambda name: limits[name])
    if not tracking_rms < TRACKING_LIMIT:
        return "tracking"
    return kind


def persists_since(times: Array, reached: Mask) -> float | None:
    """When a condition, shape (time, axle), began to persist for LEAST_DURATION or longer on any axle [s]; None: never."""
    begins = []
    for column in reached.T:
        first, after = spells(column)
        begin, end = times[first], times[after - 1]
        begins += begin[end - begin >= LEAST_DURATION * (1.0 - 1e-9)].tolist()
    return min(begins, default=None)


def friction_used(run: xr.Dataset, friction: float) -> Array:
    """Creep force over friction times normal force of both wheels of each axle under test, shape (time, axle)."""
    run = under_test(run)
    size = np.hypot(run["patch_creep_force_x"].to_numpy(), run["patch_creep_force_y"].to_numpy())
    per_axle = (run.sizes["time"], run.sizes["axle"], -1)
    force = np.nan_to_num(size).reshape(per_axle).sum(axis=2)
    normal = np.nan_to_num(run["patch_normal"].to_numpy()).reshape(per_axle).sum(axis=2)
    return np.asarray(force / np.maximum(friction * normal, 1.0))


def _contact_limit(run: xr.Dataset, used: Array) -> dict[str, float]:
    since = persists_since(run["time"].to_numpy(), used >= FULL_SLIDING)
    if since is None and run.attrs["status"] == "rollers_protected":
        since = float(run.attrs["stopped_at_s"])
    return {} if since is None else {"contact": since}


def _drive_limits(run: xr.Dataset, case: Case, torque: float, sliding: Mask) -> dict[str, float]:
    """Where the command is the largest torque of a roller drive, and what it is needed for."""
    control, command = rig_of(case)[1], run["roller_command"].to_numpy()
    largest = control.feedback.largest if control.is_ours else np.inf
    available = np.full(command.shape, largest)
    weaker = np.zeros(command.shape, dtype=bool)
    if control.motor.envelope is not None:
        speeds, torques = np.array(control.motor.envelope).T
        at_speed = np.interp(np.abs(run["roller_speed"].to_numpy()), speeds, torques)
        weaker = at_speed < min(largest, 0.999 * torques.max())
        available = np.minimum(available, at_speed)
    at_limit = np.abs(command) >= 0.999 * available
    into = command * np.sign(torque) > 0.0  # the drive helps the wheel in the direction of its torque
    masks = {
        "drive_power": at_limit & weaker,
        "drive_slide": at_limit & ~weaker & into,
        "drive_recovery": at_limit & ~weaker & ~into & sliding,
        "drive_grip": at_limit & ~weaker & ~into & ~sliding,
    }
    found = {name: persists_since(run["time"].to_numpy(), mask) for name, mask in masks.items()}
    return {name: since for name, since in found.items() if since is not None}
