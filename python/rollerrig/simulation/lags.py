"""How late the rig of a case follows, in closed form: its equivalent dead time.

AssembledModel of a case with [rig_control] -> [lags] -> Lags

A rig whose controller is late acts on the wheels like a track whose slide protection has that much more dead time: the axle's
torque reaches the virtual wheel late, and the wanted torque the roller. Equations: docs/theory/rig_control.md, (D17).
"""

from __future__ import annotations

from dataclasses import dataclass

from rollerrig import _core
from rollerrig.assembly.model import AssembledModel
from rollerrig.config.schema.rig_control import (
    EstimatedTorque,
    ExactEstimator,
    ExtrapolatedTorque,
    LeadCommand,
    TorqueLoop,
)
from rollerrig.simulation.mechatronics import drive_command, estimator_response, motor


@dataclass(frozen=True)
class Lags:
    """Lags of slow changes [s]; negative: ahead.

    Attributes:
        torque: of the axle's torque that the virtual train takes.
        drive: of the roller's torque behind the wanted one; half a sample ahead with the default lead, (D22).
    """

    torque: float
    drive: float

    @property
    def dead_time(self) -> float:
        """Equivalent dead time, their sum [s]."""
        return self.torque + self.drive


def lags(model: AssembledModel) -> Lags:
    """Lags that are left with the compensation of the case.

    Args:
        model: of a case with [rig_control].
    """
    control = model.case.rig_control
    assert control is not None
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
