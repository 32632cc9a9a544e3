"""The cases of the adhesion study: the track that a rig reproduces, and the rig without some of its imperfections.

Case of a rig with [rig_control] -> [adhesion_variants] -> Case on track, variants of the rig
"""

from __future__ import annotations

from typing import Any

from rollerrig.cases import on_track
from rollerrig.config import Case, ConfigError, ConfigProblem, Rig
from rollerrig.config.schema.rig_control import EstimatedTorque, ExactEstimator, LeadCommand

STEPS = ("rolling", "drives", "estimator")
VARIANTS = {
    "rig": "the rig as it is",
    "rolling": "pure rolling of its wheels on the rollers",
    "drives": "and roller drives without lag and torque limit",
    "estimator": "and force and torque of the axles known exactly",
    "static_loads": "the rig as it is, its virtual train without load transfer",
}
FAST_MOTOR_HZ, NO_LIMIT = 400.0, 1e7
"""More is not to be had with samples of 1 ms; [N m]."""


def track_case(case: Case) -> Case:
    """The same test on straight track with the rig's rail head: what the rig is to reproduce.

    Raises:
        ConfigError: the case is not that of a rig with [rig_control].
    """
    if not isinstance(case.support.data, Rig) or case.rig_control is None:
        needed = "needed: a case on rollers with [rig_control], which reproduces a track"
        raise ConfigError([ConfigProblem(case.name, "rig_control", "missing", needed)])
    if case.brake is None and case.traction is None:
        needed = "needed: [brake] or [traction], the test that is done on rail and rig"
        raise ConfigError([ConfigProblem(case.name, "brake", "missing", needed)])
    return on_track(case).model_copy(update={"name": f"{case.name}_track"})


def variants_of(case: Case) -> tuple[str, ...]:
    """Names of the variants that say something about this case."""
    assert case.rig_control is not None
    return (*STEPS, "static_loads") if case.rig_control.load_transfer != "none" else STEPS


def variant(case: Case, name: str) -> Case:
    """The rig without some of its imperfections; see VARIANTS."""
    control = case.rig_control
    assert control is not None
    if name == "static_loads":
        return case.model_copy(update={"rig_control": control.model_copy(update={"load_transfer": "none"})})
    taken = STEPS[: STEPS.index(name) + 1]
    changes: dict[str, Any] = {}
    if "drives" in taken:
        fast = {"bandwidth": FAST_MOTOR_HZ, "damping_ratio": 0.0, "envelope": None}
        changes["motor"] = control.motor.model_copy(update=fast)
        changes["drive_command"] = LeadCommand()
        changes["feedback"] = control.feedback.model_copy(update={"largest": NO_LIMIT})
    if "estimator" in taken:
        changes["estimator"] = ExactEstimator(kind="exact", torque=control.estimator.torque)
        changes["axle_torque"] = EstimatedTorque(kind="estimated")
    contact = case.contact.model_copy(update={"pure_rolling": True})
    return case.model_copy(update={"rig_control": control.model_copy(update=changes), "contact": contact})
