"""What `check` prints about actuators and controllers around a vehicle.

Case -> [describe_actuators] -> lines
"""

from __future__ import annotations

from rollerrig.analysis.slide_statistics import idle_valves
from rollerrig.assembly.actuators import assemble_with_actuators
from rollerrig.assembly.model import AssembledModel
from rollerrig.config import Case, Rig, code_of
from rollerrig.config.schema.rig_control import BandwidthEstimator
from rollerrig.simulation.controllers import COMMANDS, fmu_controller, look_at_controller, users_controllers
from rollerrig.simulation.lags import lags
from rollerrig.simulation.mechatronics import estimator_response, feedback_gains, full_brake_torque, rig_controller

_WORDS = {
    "proportional_integral": "proportional-integral feedback",
    "sliding_mode": "sliding mode",
    "none": "no feedback",
}


def actuator_lines(case: Case, *, run_code: bool = False) -> list[str]:
    """Brake, drive, adhesion and controllers, a line each; empty for a case without actuators.

    Args:
        case: what is described.
        run_code: whether the user's controllers are made; they are only looked at otherwise.

    Raises:
        ConfigError: a controller of the user cannot be used.
        StartError: the virtual train's vehicle has no equilibrium on track.
    """
    users = users_controllers(case, {}) if run_code else {}
    for code in code_of(case):
        look_at_controller(code, case.name)
    if not case.sampled:
        return []
    model = assemble_with_actuators(case)
    load = sum(model.axle_loads.values()) / len(model.wheelsets)
    lines = [*_brake(case, load), *_traction(case, load), *_adhesion(case)]
    if case.rig_control is not None:
        lines += [_train(model), *_roller_drives(case)]
    for name in COMMANDS:
        table = getattr(case, name)
        if table is not None:
            if table.fmu is not None:
                lines.append(_fmu(case, name))
                continue
            if table.user is not None and name not in users:
                own = f"class {table.user.rpartition(':')[2]} of your own, acting {1e3 * table.delay:g} ms later"
                lines.append(f"{name}: {own}; it has not been run, --allow-code does")
                continue
            time = users.get(name, table).sample_time
            text = f"{name}: every {1e3 * time:g} ms, acting {1e3 * table.delay:g} ms later"
            if name in users:
                text += f", {type(users[name]).__name__} of your own"
            elif name == "rig_control":
                text += _rig_control(model)
            lines.append(text)
    return [*lines, *idle_valves(case)]


def _fmu(case: Case, role: str) -> str:
    """An FMU, of which only the description has been read."""
    table, controller = getattr(case, role), fmu_controller(case, role)
    file = controller.file
    taken = ", ".join(link.signal for link in file.inputs)
    text = (
        f"{role}: every {1e3 * table.sample_time:g} ms, acting {1e3 * table.delay:g} ms later, FMU {controller.name} (FMI "
        f"{file.description.fmiVersion}): {taken} -> {file.command.signal}"
    )
    return text + (f"; nothing drives {', '.join(file.unused)}" if file.unused else "")


def _brake(case: Case, load: float) -> list[str]:
    if case.brake is None:
        return []
    pressure = max(row[1] for row in case.brake.demand)
    radius = case.vehicle.data.wheel.radius
    torque = full_brake_torque(case)
    by = "by the traction motors" if case.brake.motors_stand_in else "by friction brakes"
    return [
        f"brake: {pressure / 1e5:.3g} bar at most, {torque / 1e3:.3g} kN m per axle {by}, "
        f"which asks for an adhesion of {torque / radius / load:z.3f}"
    ]


def _traction(case: Case, load: float) -> list[str]:
    if case.traction is None:
        return []
    torque = max((abs(row[1]) for row in case.traction.demand), default=0.0)
    asks = torque / case.vehicle.data.wheel.radius / load
    return [] if torque == 0.0 else [f"traction: {torque / 1e3:.3g} kN m per axle at most, an adhesion of {asks:z.3f}"]


def _adhesion(case: Case) -> list[str]:
    if case.adhesion is None:
        return []
    rails = [case.adhesion.rail, *(piece.rail for piece in case.adhesion.piece)]
    laws = [rail.friction for rail in rails]
    parts = [f"{law.mu_0:g} falling to {law.mu_0 * getattr(law, 'A', 1.0):g} with slip" for law in laws]
    recovery = "; it recovers under sliding wheels" if case.adhesion.recovery_constant > 0.0 else ""
    return [f"adhesion of the rail: {', then '.join(parts)}{recovery}"]


def _roller_drives(case: Case) -> list[str]:
    """What a full brake that the wheels' adhesion bears asks of each roller axle's drive at the start, and what the drive can."""
    assert case.rig_control is not None
    support, motor = case.support.data, case.rig_control.motor
    torque = full_brake_torque(case)
    if torque == 0.0 or not isinstance(support, Rig):
        return []
    wheel = case.vehicle.data.wheel.radius
    at_roller = torque * support.roller_radius / wheel
    power = torque * case.motion.speed / wheel
    limits = [
        f"{value / 1e3:.4g} {unit}"
        for value, unit in ((motor.largest_torque, "kN m"), (motor.largest_power, "kW"))
        if value is not None
    ]
    has = f"they have {' and '.join(limits)}" if limits else "no limit is set"
    return [
        f"roller drives: a full brake at {3.6 * case.motion.speed:.4g} km/h asks for {at_roller / 1e3:.3g} kN m and "
        f"{power / 1e3:.4g} kW per axle; {has}"
    ]


def _train(model: AssembledModel) -> str:
    train = rig_controller(model).train
    loads = ", ".join(f"{q / 1e3:z.1f}" for q in train.static_load)
    return f"virtual train: {train.mass / 1e3:z.3f} t on {len(train.static_load)} axles, static axle loads {loads} kN"


def _rig_control(model: AssembledModel) -> str:
    control = model.case.rig_control
    assert control is not None
    estimator, kind = control.estimator, control.feedback.kind
    pole = f" {estimator.bandwidth:g} Hz" if isinstance(estimator, BandwidthEstimator) else ""
    text = f", {estimator.kind.replace('_', ' ')}{pole}, {_WORDS.get(kind, kind)}"
    if kind == "proportional_integral":
        proportional, integral = feedback_gains(model)
        text += f" {proportional / 1e3:.3g} kN m s/rad and {integral / 1e3:.3g} kN m/rad"
    text += f", roller drives {control.motor.bandwidth:g} Hz"
    if estimator.kind != "exact":
        text += "; measured on the estimates:"
        for name, (bandwidth, delay) in estimator_response(model).items():
            text += f" {name} {bandwidth:z.1f} Hz and {1e3 * delay:z.1f} ms,"
        text = text.removesuffix(",")
    left = lags(model)
    left, command = lags(model), control.drive_command.kind.replace("_", " ")
    return (
        f"{text}; axle torque {control.axle_torque.kind}, drive command {command}: equivalent dead time "
        f"{1e3 * left.dead_time:z.1f} ms, {1e3 * left.torque:z.1f} ms of the torque and {1e3 * left.drive:z.1f} ms of the drives"
    )
