"""From a case to the settings of the core's bench: names become indices, absent numbers follow from the vehicle.

Case, AssembledModel -> [settings] -> dict for _core.Bench
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from rollerrig import _core
from rollerrig.actuators import brake_numbers
from rollerrig.assembly import AssembledModel
from rollerrig.bench.controllers import UserController
from rollerrig.bench.virtual_train import load_transfer, rail_contact, train_mass
from rollerrig.config import (
    Brake,
    Case,
    Controller,
    Encoder,
    ForceSensor,
    Motor,
    Rig,
    RigControl,
    SlideProtection,
    WheelSlipControl,
)
from rollerrig.config.schema.actuators import BenchSettings

_ABSENT = {"every": 0, "delay": 0, "external": False}


@dataclass(frozen=True)
class Fitted:
    """A model with machines on it.

    Attributes:
        settings: what _core.Bench takes, without the start.
        travels: whether the vehicle runs along a track.
    """

    settings: dict[str, Any]
    travels: bool


def fit(model: AssembledModel, controllers: Mapping[str, UserController]) -> Fitted:
    """How the actuators of a model are driven.

    Args:
        model: assembled with its actuators.
        controllers: the user's, by table of the case.
    """
    case = model.case
    rig = case.support.data if isinstance(case.support.data, Rig) else None
    control = case.rig_control
    mass = train_mass(model)
    free = sum(model.masses[b] for b in model.vehicle_bodies if b not in model.fixed)
    settings: dict[str, Any] = {
        "step": case.bench.step,
        "duration": case.time.duration,
        "speed": case.motion.speed,
        "floor_speed": _floor_speed(case.bench, case),
        "axles": [dataclasses.asdict(axle) for axle in model.axles],
        "brake_demand": _rows(case.brake.demand if case.brake else ()),
        "traction_demand": _rows(case.traction.demand if case.traction else ()),
        "brake": _brake(case.brake),
        "motor": _motor(case.traction.motor if case.traction else Motor()),
        "motor_brakes": bool(case.brake and case.brake.motors_stand_in),
        "slide_sampling": _sampling(case, "slide_protection", controllers),
        "slide_protection": _slide_protection(case),
        "wheel_slip_sampling": _sampling(case, "wheel_slip_control", controllers),
        "wheel_slip_control": _anti_slip(case),
        "axle_encoder": _encoder(case.sensors.axles),
        "roller_encoder": _encoder(case.sensors.rollers),
        "has_torque_sensor": case.sensors.roller_torque is not None,
        "torque_sensor": _force_sensor(case.sensors.roller_torque or ForceSensor()),
        "load_sensor": _force_sensor(case.sensors.axle_load),
        "commanded_torque": control is not None and control.estimator.torque == "commanded",
        "measured_loads": control is not None and control.loads == "measured",
        "seed": case.sensors.seed,
        "rig_sampling": _sampling(case, "rig_control", controllers),
        "reproduce": control is not None,
        "rail_cell": case.adhesion.cell_length if case.adhesion else 0.05,
        "travelling_mass": mass if rig is None else 0.0,
        "pure_rolling": case.bench.pure_rolling,
        "held_mass": max(0.0, mass - free) if rig is None and model.fixed else 0.0,
        **_rig_control(model, control or RigControl(), rig),
    }
    settings["rail"] = {"adhesion": model.adhesion, **(rail_contact(model) if control else _NO_RAIL)}
    return Fitted(settings, rig is None)


_NO_RAIL = {"wheel_load": 1.0, "a": 1.0, "b": 1.0, "width": 1.0}


def _floor_speed(bench: BenchSettings, case: Case) -> float:
    """A start has no standstill to end at."""
    return bench.standstill if case.brake is not None and case.motion.speed > bench.standstill else 0.0


def _rows(table: tuple[tuple[float, float], ...]) -> list[list[float]]:
    return [list(row) for row in table]


def _sampling(case: Case, role: str, controllers: Mapping[str, UserController]) -> dict[str, Any]:
    table: Controller | None = getattr(case, role)
    if table is None:
        return dict(_ABSENT)
    external = role in controllers
    time = controllers[role].sample_time if external else table.sample_time
    step = case.bench.step
    return {"every": round(time / step), "delay": round(table.delay / step), "external": external}


def _geared_inertia(motor: Motor) -> float:
    """Of the rotor, on the driven axle [kg m^2]."""
    return motor.rotor_inertia * motor.gear_ratio**2


def _motor(motor: Motor) -> dict[str, Any]:
    bandwidth = 2.0 * math.pi * motor.bandwidth
    return {"envelope": _rows(motor.envelope or ()), "bandwidth": bandwidth, "damping_ratio": motor.damping_ratio}


def _brake(brake: Brake | None) -> dict[str, Any]:
    return brake_numbers(brake or Brake(demand=((0.0, 0.0), (1.0, 0.0))))


def full_brake_torque(case: Case) -> float:
    """Against the turning of each axle, at the largest pressure asked for and the speed of the start [N m]."""
    if case.brake is None or case.motion.speed <= 0.0:
        return 0.0
    pressure = max(row[1] for row in case.brake.demand)
    return -float(_core.brake_torque(_brake(case.brake), pressure, case.motion.speed / case.vehicle.data.wheel.radius))


_TIMING = {"sample_time", "delay", "user"}


def _slide_protection(case: Case) -> dict[str, Any]:
    table = case.slide_protection or SlideProtection()
    return {**table.model_dump(exclude=_TIMING), "wheel_radius": case.vehicle.data.wheel.radius}


def _anti_slip(case: Case) -> dict[str, Any]:
    table = case.wheel_slip_control or WheelSlipControl()
    return {**table.model_dump(exclude=_TIMING), "wheel_radius": case.vehicle.data.wheel.radius}


def _encoder(encoder: Encoder) -> dict[str, Any]:
    return {"counts_per_turn": encoder.counts, "jitter_counts": encoder.jitter, "window": encoder.window}


def _force_sensor(sensor: ForceSensor) -> dict[str, float]:
    bandwidth = 2.0 * math.pi * (sensor.bandwidth or 0.0)
    return {**sensor.model_dump(), "bandwidth": bandwidth, "range": sensor.range or 0.0}


def estimator_response(settings: Mapping[str, Any]) -> dict[str, tuple[float, float]]:
    """Measured bandwidth [Hz] and delay of slow changes [s] of the estimates 'force' and 'torque', with exact sensors.

    Args:
        settings: of a Fitted model whose rig is controlled, by an estimator that is not exact.
    """
    period = settings["step"] * settings["rig_sampling"]["every"]
    found = _core.estimator_response(settings["estimator"], period)
    return {name: (bandwidth / (2.0 * math.pi), delay) for name, (bandwidth, delay) in found.items()}


def _rig_control(model: AssembledModel, control: RigControl, rig: Rig | None) -> dict[str, Any]:
    assumed, train = control.assumed, model.case.train
    wheel_radius = model.case.vehicle.data.wheel.radius
    drive = model.case.traction.motor if model.case.traction else Motor()
    wheelset_inertia = model.inertias[model.wheelsets[0]][1] + _geared_inertia(drive)
    roller_radius, roller_inertia = (rig.roller_radius, rig.roller_inertia[1]) if rig else (1.0, 1.0)
    roller_inertia += _geared_inertia(control.motor)
    estimator = {
        "kind": control.estimator.kind,
        "bandwidth": 2.0 * math.pi * control.estimator.bandwidth,
        "damping_ratio": control.estimator.damping_ratio,
        "speed_noise": control.estimator.speed_noise,
        "force_change": control.estimator.force_change or 0.0,
        "torque_change": control.estimator.torque_change or 0.0,
        "roller_inertia": assumed.roller_inertia or roller_inertia,
        "roller_radius": assumed.roller_radius or roller_radius,
        "wheelset_inertia": assumed.wheelset_inertia or wheelset_inertia,
        "wheel_radius": assumed.wheel_radius or wheel_radius,
    }
    transfer = load_transfer(model) if rig else [0.0] * len(model.wheelsets)
    return {
        "train": {
            **train.model_dump(exclude={"mass"}),
            "mass": train_mass(model),
            "gravity": model.case.gravity,
            "wheelset_inertia": wheelset_inertia,
            "wheel_radius": wheel_radius,
            "static_load": [model.axle_loads[name] for name in model.wheelsets],
            "load_transfer": transfer,
        },
        "estimator": estimator,
        "feedback": _feedback(control, estimator),
        "roller_motor": _motor(control.motor),
        "slip_limit": control.protection.slip,
        "slip_time": control.protection.time,
    }


def _feedback(control: RigControl, plant: Mapping[str, Any]) -> dict[str, Any]:
    """Gains of the PI loop around wheel and roller as one inertia, docs/theory/rig_control.md (D6)."""
    table = control.feedback
    ratio = plant["wheel_radius"] / plant["roller_radius"]
    inertia = plant["wheelset_inertia"] + plant["roller_inertia"] * ratio**2
    frequency = 2.0 * math.pi * table.bandwidth
    proportional = 2.0 * table.damping_ratio * frequency * inertia / ratio
    return {
        "kind": table.kind,
        "proportional": proportional if table.proportional is None else table.proportional,
        "integral": frequency**2 * inertia / ratio if table.integral is None else table.integral,
        "switching": table.switching,
        "boundary_layer": table.boundary_layer,
        "largest": table.largest,
    }
