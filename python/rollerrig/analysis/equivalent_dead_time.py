"""Equivalent dead time of a rig: how much later its slide protection acts on the rail than on track.

    AssembledModel of a case with [rig_control] -> [lags] -> Lags
    Case of a rig with [rig_control] -> [predicted_dead_time] -> DeadTime, in closed form
    numbers of rig and track -> [at_track_of] -> the dead time at which the track does as the rig does

A rig whose controller is late acts on the wheels like a track whose slide protection has that much more dead time: the axle's
torque reaches the virtual wheel late, and the wanted torque the roller. Equations: docs/theory/rig_control.md, (D17),
(Q7) and (Q8).
"""

import math
from dataclasses import dataclass

from rollerrig import _core
from rollerrig.assembly.actuators import assemble_with_actuators
from rollerrig.assembly.model import AssembledModel
from rollerrig.cases import rig_of
from rollerrig.config import Case
from rollerrig.config.schema.rig_control import (
    EstimatedTorque,
    ExactEstimator,
    ExtrapolatedTorque,
    LeadCommand,
    TorqueLoop,
)
from rollerrig.simulation.mechatronics import assumed_parameters, drive_command, estimator_response, motor


@dataclass(frozen=True)
class Lags:
    """Lags of slow changes [s]; negative: ahead."""

    torque: float  # of the axle's torque that the virtual train takes
    drive: float  # of the roller's torque behind the wanted one; half a sample ahead with the default lead, (D22)

    @property
    def total(self) -> float:
        """Equivalent dead time from a brake's torque to the rail's force on the real wheel, (D17) [s]."""
        return self.torque + self.drive


def lags(model: AssembledModel) -> Lags:
    """Lags that are left with the compensation of a case with [rig_control]."""
    control = rig_of(model.case)[1]
    torque, command = control.axle_torque, control.drive_command
    late = 0.0
    if isinstance(torque, EstimatedTorque | ExtrapolatedTorque) and not isinstance(control.estimator, ExactEstimator):
        late = estimator_response(model)["torque"][1]
    if isinstance(torque, ExtrapolatedTorque):
        late -= torque.ahead
    gain = command.gain if isinstance(command, TorqueLoop) else 0.0
    lead = drive_command(control).ahead if isinstance(command, LeadCommand) else 0.0
    drive = _core.torque_lag(motor(control.motor), control.sample_time, control.delay, gain)
    return Lags(late, drive - lead)


@dataclass(frozen=True)
class DeadTime(Lags):
    """Equivalent dead time of a rig by its parts [s]."""

    # part k / (1 + k) of a brake's torque that reaches the sliding wheel only through the controller, k = J_r (r/R)^2 /
    # J_w; the rest acts at once on wheel and roller as one inertia
    late_share: float

    @property
    def least(self) -> float:
        """Dead time from a brake's torque to the speed of a wheel that slides at constant adhesion, (Q8)."""
        return self.late_share * self.total


def predicted_dead_time(case: Case) -> DeadTime | None:
    """The equivalent dead time of a rig with [rig_control]; None for a user's controller, of which nothing is known."""
    if not rig_of(case)[1].is_ours:
        return None
    model = assemble_with_actuators(case)
    axle, late = assumed_parameters(model), lags(model)
    coupled = axle.roller_inertia * (axle.wheel_radius / axle.roller_radius) ** 2 / axle.wheelset_inertia
    return DeadTime(late.torque, late.drive, coupled / (1.0 + coupled))


def at_track_of(rig: float, track: dict[float, float]) -> tuple[float, float]:
    """Where a number on track, by additional dead time [s], such as the distance, has the rig's value: dead time and slope there.

    Linear between the points, the first crossing; on the first line also as far before its begin, since a rig may be ahead. NaN
    where no line has the value.
    """
    delays = sorted(track)
    for low, high in zip(delays[:-1], delays[1:], strict=True):
        a, b = track[low], track[high]
        if a != b and min(a, b) <= rig <= max(a, b):
            slope = (b - a) / (high - low)
            return low + (rig - a) / slope, slope
    slope = (track[delays[1]] - track[delays[0]]) / (delays[1] - delays[0])
    ahead = (rig - track[delays[0]]) / slope if slope else math.nan
    if delays[0] - delays[1] <= ahead < 0.0:
        return delays[0] + ahead, slope
    return math.nan, math.nan
