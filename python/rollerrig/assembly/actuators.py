"""A plant with what acts on it: brakes, traction motors, roller drives, adhesion of the rails, running resistance.

    Case -> [AssembledModel] -> plant -> [actuators] -> AssembledModel with the indices of its actuators

How they are driven during a run is the matter of `rollerrig.simulation.mechatronics`.
"""

import math
from typing import Any

from rollerrig import _core
from rollerrig.assembly.laws import adhesion_map, core_law, part_of
from rollerrig.assembly.model import GROUND, AssembledModel, assemble, axle_torque
from rollerrig.assembly.model_parts import ABSENT, add_part
from rollerrig.config import Brake, Case, Track, Traction
from rollerrig.config.schema.brakes import AnyTrackBrake, MagneticTrackBrake, ReservoirAir


def assemble_as_run(case: Case) -> AssembledModel:
    """The compiled model of a case as a run has it: with actuators where the case has any."""
    return assemble_with_actuators(case) if case.sampled else assemble(case)


def assemble_with_actuators(case: Case, *, torque_on_all: bool = False) -> AssembledModel:
    """Build the compiled model of a case with its actuators.

    Args:
        case: the case.
        torque_on_all: whether an axle without a motor takes a torque, too.
    """
    adhesion = adhesion_map(case.adhesion, case.sanding) if case.adhesion is not None else None
    # on the wheels on track; on a rig for the virtual train alone
    model = AssembledModel(case, adhesion if isinstance(case.support.data, Track) else None)
    model.adhesion = adhesion
    axles = range(len(model.wheelsets))
    model.axles = tuple(_add_axle(model, number, torque_on_all=torque_on_all) for number in axles)
    _add_resistance(model)
    model.bogies = _add_track_brakes(model)
    if case.contact.pure_rolling:
        for name in model.wheelsets:
            add_part(model.parts, "rolling_wheelsets", model.body_index(name))
    return model.finish()


def _add_axle(model: AssembledModel, number: int, *, torque_on_all: bool) -> _core.AxleParts:
    case, parts, name = model.case, model.parts, model.wheelsets[number]
    wheelset, frame = model.body_index(name), model.frame_of(name)
    brake = torque = roller = roller_torque = ABSENT
    if case.brake is not None and not case.brake.by_traction_motors:
        own = _core.AxleBrake(wheelset=wheelset, reaction=frame, brake=friction_brake(case.brake))
        brake = add_part(parts, "brakes", own)
    machine = case.brake.electrodynamic if case.brake else None
    brakes = machine is not None and (machine.axles is None or name in machine.axles)
    if case.traction is not None:
        torque = add_part(parts, "axle_torques", _traction_motor(model, name, frame, case.traction))
    elif brakes or torque_on_all:
        torque = add_part(parts, "axle_torques", axle_torque(wheelset, frame, []))
    if model.rollers:
        roller = model.body_index(model.rollers[number])
    if model.rollers and case.rig_control is not None:
        drive = part_of(_core.RollerTorque, case.rig_control.motor, roller=roller, torque=[])
        roller_torque = add_part(parts, "roller_torques", drive)
    return _core.AxleParts(
        wheelset=wheelset,
        contacts=[wheel.contact for wheel in model.wheels if wheel.wheelset == name],
        brake=brake,
        axle_torque=torque,
        roller=roller,
        roller_torque=roller_torque,
        electrodynamic=brakes,
        sands=name in (case.sanding.axles or model.wheelsets[:1] if case.sanding else ()),
        has_brake=False,
        has_motor=False,
    )


def _traction_motor(model: AssembledModel, name: str, frame: int, traction: Traction) -> _core.AxleTorque:
    """The motor of one axle: where its moment goes, and its rotor."""
    link = 0.0
    if traction.suspension == "axle" and frame != GROUND:
        ahead = model.positions[model.bodies[frame]][0] - model.positions[name][0]
        link = math.copysign(traction.link or 0.0, ahead)
    reaction = GROUND if traction.suspension == "ground" else frame
    wheelset = model.body_index(name)
    return part_of(_core.AxleTorque, traction.motor, wheelset=wheelset, reaction=reaction, torque=[], link=link)


def friction_brake(brake: Brake) -> _core.FrictionBrake:
    """Chain from cylinder pressure to the torque of an axle's brake."""
    return part_of(_core.FrictionBrake, brake)


def electrodynamic_brake(brake: Brake, wheel_radius: float) -> _core.ElectrodynamicBrake | None:
    """Traction motors that brake, on wheels of a radius [m]; None where there are none."""
    table = brake.electrodynamic
    if table is None:
        return None
    law = _core.electrodynamic_brakes[table.kind]
    return part_of(
        _core.ElectrodynamicBrake,
        table,
        characteristic=part_of(law, table),
        wheel_radius=wheel_radius,
        on_slide=("keep", "reduce", "switch_off", "slip_control").index(table.on_slide),
    )


def track_brake(table: AnyTrackBrake, bogies: int) -> _core.TrackBrake:
    """Brakes of some bogies that act on the rail."""
    law = _core.track_brakes[table.kind]
    own = {"friction": core_law(table.friction)} if isinstance(table, MagneticTrackBrake) else {}
    return part_of(_core.TrackBrake, table, law=part_of(law, table, **own), bogies=bogies)


def pneumatics(brake: Brake) -> _core.Pneumatics:
    """Chain from brake demand and the dump valves' commands to cylinder pressures."""
    given: dict[str, Any] = {}
    if isinstance(brake.air, ReservoirAir):
        if brake.air.reservoir_pressure is None:
            given["reservoir_pressure"] = brake.air.main_pipe_pressure
        if brake.air.pipe is not None:
            given["pipe"] = part_of(_core.CylinderPipe, brake.air.pipe)
    air = part_of(_core.airs[brake.air.kind], brake.air, **given)
    return _core.Pneumatics(control_valve=part_of(_core.ControlValve, brake), air=air)


def _add_track_brakes(model: AssembledModel) -> int:
    """On what carries the wheelsets, or else the vehicle's body; on a rig nowhere: there is no rail beside the rollers.

    Returns:
        How many there are.
    """
    table = model.case.track_brake
    if table is None:
        return 0
    frames = {model.frame_of(name) for name in model.wheelsets}
    bodies = {model.body_index(model.main_body) if frame == GROUND else frame for frame in frames}
    for body in sorted(bodies) if isinstance(model.support, Track) else ():
        add_part(model.parts, "track_brakes", _core.BodyTrackBrake(body=body, brake=track_brake(table, 1)))
    return len(bodies)


def _add_resistance(model: AssembledModel) -> None:
    train = model.case.train
    model.parts["resistance"] = _core.RunningResistance(
        body=model.body_index(model.main_body),
        constant=train.resistance_constant,
        linear=train.resistance_linear,
        quadratic=train.resistance_quadratic,
        gradient=train.gradient,
    )
