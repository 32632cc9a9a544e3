"""A plant with what acts on it: brakes, traction motors, roller drives, adhesion of the rails, running resistance.

    Case -> [Assembly] -> plant -> [actuators] -> AssembledModel with the indices of its actuators

How they are driven during a run is the matter of `rollerrig.simulation.mechatronics`.
"""

import math
from dataclasses import replace
from typing import Any

from rollerrig import _core
from rollerrig.assembly.laws import adhesion_map, core_law, core_struct
from rollerrig.assembly.model import GROUND, AssembledModel, Assembly, assemble
from rollerrig.assembly.model_parts import ABSENT
from rollerrig.config import Brake, Case, Track, Traction
from rollerrig.config.schema.brakes import AnyTrackBrake, MagneticTrackBrake, ReservoirAir

_NO_ROTOR = {"link": 0.0, "gear_ratio": 1.0, "rotor_inertia": 0.0}


def assemble_as_run(case: Case) -> AssembledModel:
    """The compiled model of a case as a run has it: with actuators where the case has any."""
    return assemble_with_actuators(case) if case.sampled else assemble(case)


def assemble_with_actuators(case: Case, *, torque_on_all: bool = False) -> AssembledModel:
    """Build the compiled model of a case with its actuators.

    Args:
        case: the case.
        torque_on_all: whether an axle without a motor takes a torque, too.
    """
    assembly = Assembly(case)
    adhesion = _add_adhesion(assembly)
    axles = tuple(
        _add_axle(assembly, number, name, torque_on_all=torque_on_all) for number, name in enumerate(assembly.wheelsets)
    )
    _add_resistance(assembly)
    bogies = _add_track_brakes(assembly)
    if case.contact.pure_rolling:
        for name in assembly.wheelsets:
            assembly.builder.add_rolling_constraint(assembly.index(name))
    return replace(assembly.finish(), axles=axles, adhesion=adhesion, bogies=bogies)


def _add_adhesion(assembly: Assembly) -> _core.AdhesionMap | None:
    """The adhesion of the case's rails: on the wheels on track; on a rig for the virtual train alone."""
    if assembly.case.adhesion is None:
        return None
    adhesion = adhesion_map(assembly.case.adhesion, assembly.case.sanding)
    for wheel in assembly.wheels if isinstance(assembly.support, Track) else ():
        assembly.builder.set_adhesion(wheel.contact, adhesion)
    return adhesion


def _add_axle(assembly: Assembly, number: int, name: str, *, torque_on_all: bool) -> _core.AxleParts:
    case, builder = assembly.case, assembly.builder
    wheelset, frame = assembly.index(name), assembly.frame_of(name)
    brake = axle_torque = roller = roller_torque = ABSENT
    if case.brake is not None and not case.brake.motors_stand_in:
        brake = builder.add_brake(_core.AxleBrake(wheelset=wheelset, reaction=frame, brake=friction_brake(case.brake)))
    machine = case.brake.electrodynamic if case.brake else None
    brakes = machine is not None and (machine.axles is None or name in machine.axles)
    if case.traction is not None:
        axle_torque = builder.add_axle_torque(_traction_motor(assembly, name, frame, case.traction))
    elif brakes or torque_on_all:
        axle_torque = builder.add_axle_torque(
            _core.AxleTorque(wheelset=wheelset, reaction=frame, torque=[], **_NO_ROTOR)
        )
    if assembly.rollers:
        roller = assembly.index(assembly.rollers[number])
    if assembly.rollers and case.rig_control is not None:
        motor = case.rig_control.motor
        drive = _core.RollerTorque(
            roller=roller, torque=[], gear_ratio=motor.gear_ratio, rotor_inertia=motor.rotor_inertia
        )
        roller_torque = builder.add_roller_torque(drive)
    return _core.AxleParts(
        wheelset=wheelset,
        contacts=[wheel.contact for wheel in assembly.wheels if wheel.wheelset == name],
        brake=brake,
        axle_torque=axle_torque,
        roller=roller,
        roller_torque=roller_torque,
        electrodynamic=brakes,
        sands=name in (case.sanding.axles or assembly.wheelsets[:1] if case.sanding else ()),
        has_brake=False,
        has_motor=False,
    )


def _traction_motor(assembly: Assembly, name: str, frame: int, traction: Traction) -> _core.AxleTorque:
    """The motor of one axle: where its moment goes, and its rotor."""
    link = 0.0
    if traction.suspension == "axle" and frame != GROUND:
        ahead = assembly.positions[assembly.bodies[frame]][0] - assembly.positions[name][0]
        link = math.copysign(traction.link or 0.0, ahead)
    return _core.AxleTorque(
        wheelset=assembly.index(name),
        reaction=GROUND if traction.suspension == "ground" else frame,
        torque=[],
        link=link,
        gear_ratio=traction.motor.gear_ratio,
        rotor_inertia=traction.motor.rotor_inertia,
    )


def friction_brake(brake: Brake) -> _core.FrictionBrake:
    """Chain from cylinder pressure to the torque of an axle's brake."""
    return core_struct(_core.FrictionBrake, **{name: getattr(brake, name) for name in _core.FrictionBrake.fields})


def electrodynamic_brake(brake: Brake, wheel_radius: float) -> _core.ElectrodynamicBrake | None:
    """Traction motors that brake, on wheels of a radius [m]; None where there are none."""
    table = brake.electrodynamic
    if table is None:
        return None
    law = _core.electrodynamic_brakes[table.kind]
    return core_struct(
        _core.ElectrodynamicBrake,
        table,
        without=("kind", "axles", *law.fields),
        characteristic=core_struct(law, **{name: getattr(table, name) for name in law.fields}),
        wheel_radius=wheel_radius,
        on_slide=("keep", "reduce", "switch_off", "slip_control").index(table.on_slide),
    )


def track_brake(table: AnyTrackBrake, bogies: int) -> _core.TrackBrake:
    """Brakes of some bogies that act on the rail."""
    law = _core.track_brakes[table.kind]
    given: dict[str, Any] = {name: getattr(table, name) for name in law.fields}
    if isinstance(table, MagneticTrackBrake):
        given["friction"] = core_law(table.friction)
    timing = {name: getattr(table, name) for name in ("demand", "delay", "rise_time", "release_speed")}
    return core_struct(_core.TrackBrake, law=core_struct(law, **given), bogies=bogies, **timing)


def pneumatics(brake: Brake) -> _core.Pneumatics:
    """Chain from brake demand and the dump valves' commands to cylinder pressures."""
    valve = core_struct(_core.ControlValve, **{name: getattr(brake, name) for name in _core.ControlValve.fields})
    given: dict[str, Any] = {}
    if isinstance(brake.air, ReservoirAir):
        if brake.air.reservoir_pressure is None:
            given["reservoir_pressure"] = brake.air.main_pipe_pressure
        if brake.air.pipe is not None:
            given["pipe"] = core_struct(_core.CylinderPipe, brake.air.pipe, without=("axles_per_relay_valve",))
    air = core_struct(_core.airs[brake.air.kind], brake.air, without=("kind", "axles_per_reservoir"), **given)
    return core_struct(_core.Pneumatics, control_valve=valve, air=air)


def _add_track_brakes(assembly: Assembly) -> int:
    """On what carries the wheelsets, or else the vehicle's body; on a rig nowhere: there is no rail beside the rollers.

    Returns:
        How many there are.
    """
    table = assembly.case.track_brake
    if table is None:
        return 0
    frames = {assembly.frame_of(name) for name in assembly.wheelsets}
    bodies = {assembly.index(assembly.main_body) if frame == GROUND else frame for frame in frames}
    for body in sorted(bodies) if isinstance(assembly.support, Track) else ():
        assembly.builder.add_track_brake(_core.BodyTrackBrake(body=body, brake=track_brake(table, 1)))
    return len(bodies)


def _add_resistance(assembly: Assembly) -> None:
    train = assembly.case.train
    assembly.builder.set_resistance(
        _core.RunningResistance(
            body=assembly.index(assembly.main_body),
            constant=train.resistance_constant,
            linear=train.resistance_linear,
            quadratic=train.resistance_quadratic,
            gradient=train.gradient,
        )
    )
