"""What `check` prints about actuators and controllers of a vehicle.

Case, AssembledModel -> [describe_bench] -> lines
"""

from __future__ import annotations

from typing import Any

from rollerrig.actuators import assemble_with_actuators
from rollerrig.assembly import AssembledModel
from rollerrig.bench.bench_run import users_controllers
from rollerrig.bench.controllers import COMMANDS
from rollerrig.bench.settings import estimator_response, fit, full_brake_torque
from rollerrig.config import Case

_SAMPLING = {
    "slide_protection": "slide_sampling",
    "wheel_slip_control": "wheel_slip_sampling",
    "rig_control": "rig_sampling",
}
_WORDS = {
    "proportional_integral": "proportional-integral feedback",
    "sliding_mode": "sliding mode",
    "none": "no feedback",
}


def actuator_lines(model: AssembledModel) -> list[str]:
    """Brake, drive, adhesion and controllers, a line each; empty for a case without actuators.

    Args:
        model: of the case; brakes and drives are added to it.

    Raises:
        ConfigError: a controller of the user cannot be loaded.
    """
    case = model.case
    users = users_controllers(case, {})
    if not case.on_bench:
        return []
    settings = fit(assemble_with_actuators(case), users).settings
    load = sum(model.axle_loads.values()) / len(model.wheelsets)
    lines = [*_brake(case, load), *_traction(case, load), *_adhesion(case), *_train(case, settings)]
    for role in COMMANDS:
        if getattr(case, role) is not None:
            user = type(users[role]).__name__ if role in users else ""
            lines.append(_controller(case, role, settings, user))
    return lines


def _brake(case: Case, load: float) -> list[str]:
    if case.brake is None:
        return []
    pressure = max(row[1] for row in case.brake.demand)
    radius = case.vehicle.data.wheel.radius
    torque = full_brake_torque(case)
    by = "by the traction motors" if case.brake.motors_stand_in else "by friction brakes"
    return [
        f"brake: {pressure / 1e5:.3g} bar at most, {torque / 1e3:.3g} kN m per axle {by}, "
        f"which asks for an adhesion of {torque / radius / load:.3f}"
    ]


def _traction(case: Case, load: float) -> list[str]:
    if case.traction is None:
        return []
    torque = max((abs(row[1]) for row in case.traction.demand), default=0.0)
    asks = torque / case.vehicle.data.wheel.radius / load
    return [] if torque == 0.0 else [f"traction: {torque / 1e3:.3g} kN m per axle at most, an adhesion of {asks:.3f}"]


def _adhesion(case: Case) -> list[str]:
    if case.adhesion is None:
        return []
    rails = [case.adhesion.rail, *(piece.rail for piece in case.adhesion.piece)]
    laws = [rail.friction for rail in rails]
    parts = [f"{law.mu_0:g} falling to {law.mu_0 * getattr(law, 'A', 1.0):g} with slip" for law in laws]
    cleaned = "; it recovers under sliding wheels" if case.adhesion.recovery_constant > 0.0 else ""
    return [f"adhesion of the rail: {', then '.join(parts)}{cleaned}"]


def _train(case: Case, settings: dict[str, Any]) -> list[str]:
    if case.rig_control is None:
        return []
    train = settings["train"]
    return [
        f"virtual train: {train['mass'] / 1e3:.3f} t on {len(train['static_load'])} axles, "
        f"static axle loads {', '.join(f'{q / 1e3:.1f}' for q in train['static_load'])} kN"
    ]


def _controller(case: Case, role: str, settings: dict[str, Any], user: str) -> str:
    sampling = settings[_SAMPLING[role]]
    step = 1e3 * case.bench.step
    text = f"{role}: every {sampling['every'] * step:g} ms, acting {sampling['delay'] * step:g} ms later"
    if user:
        return f"{text}, {user} of your own"
    if role == "rig_control" and case.rig_control is not None:
        estimator, motor = case.rig_control.estimator, case.rig_control.motor
        kind = case.rig_control.feedback.kind
        text += f", {estimator.kind.replace('_', ' ')} {estimator.bandwidth:g} Hz, {_WORDS.get(kind, kind)}"
        if kind == "proportional_integral":
            gains = settings["feedback"]
            text += f" {gains['proportional'] / 1e3:.3g} kN m s/rad and {gains['integral'] / 1e3:.3g} kN m/rad"
        text += f", roller drives {motor.bandwidth:g} Hz"
        if estimator.kind != "exact":
            text += "; measured on the estimates:"
            for name, (bandwidth, delay) in estimator_response(settings).items():
                text += f" {name} {bandwidth:.1f} Hz and {1e3 * delay:.1f} ms,"
            text = text.removesuffix(",")
    return text
