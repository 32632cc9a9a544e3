"""A case as the core's sensors, controllers and actuators: names become indices, absent numbers follow from the vehicle.

Case, AssembledModel -> [setup] -> _core.MechatronicSetup
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from rollerrig import _core
from rollerrig.assembly.actuators import electrodynamic_brake, friction_brake, pneumatics, track_brake
from rollerrig.assembly.laws import angular, core_law, friction, kalker_stiffness, part_of
from rollerrig.assembly.model import AssembledModel
from rollerrig.assembly.model_parts import ABSENT
from rollerrig.assembly.train_axles import (
    air_groups,
    axle_places,
    brake_delay,
    simulated_axles,
    train_mass,
)
from rollerrig.config import Adhesion, Brake, Case, ForceSensor, Motor, Rig, RigControl, Sensors
from rollerrig.config.schema.actuators import SlideProtection, TableSlideProtection, entry_numbers
from rollerrig.config.schema.rig_control import (
    AnyAxleTorque,
    KnownTorque,
    LeadCommand,
    ProportionalIntegral,
)
from rollerrig.simulation.controllers import UserController
from rollerrig.simulation.virtual_train import load_transfer, rail_patch


def mechatronic_setup(
    model: AssembledModel, controllers: Mapping[str, UserController] | None = None
) -> _core.MechatronicSetup | None:
    """What acts on a vehicle and how it is sampled; None for a case without actuators and controllers.

    `controllers` are the user's, by table of the case.

    Raises:
        StartError: the virtual train's vehicle has no equilibrium on track.
    """
    case = model.case
    if not case.sampled:
        return None
    control = case.rig_control or RigControl()
    return _core.MechatronicSetup(
        step=case.time.sampling_step,
        speed=case.motion.speed,
        stop_speed=_stop_speed(case),
        axles=_axles(model),
        actuators=_actuators(model, control),
        sensors=_sensors(case.sensors),
        controllers=_controllers(model, controllers or {}),
        protection=part_of(_core.RollerProtection, control.protection),
        frame=_frame(model),
        **_rail(case, "rail_cell"),
        sanding=_sanding(case),
        simulated=simulated_axles(model, wheelset_inertia(model)),
        rail=virtual_rail(model) if model.axle_names != model.wheelsets else None,
        brake_delay=brake_delay(model),
        **air_groups(model),
    )


def _sanding(case: Case) -> _core.Sanding | None:
    table = case.sanding
    if table is None:
        return None
    start = law_of(_core.sanding_starts, table.start)
    return part_of(_core.Sanding, table, start=start)


def _stop_speed(case: Case) -> float:
    """A start from rest has no stop to end at."""
    stop = case.motion.stop_speed
    return stop if case.brake is not None and case.motion.speed > stop else 0.0


def _rail(case: Case, cell: str) -> dict[str, Any]:
    """The rail's memory: length of its `cell` [m], that of the wheels [m], width of energy, 0: of the patches, 1: per metre."""
    adhesion = case.adhesion or Adhesion.model_validate({"rail": "dry"})
    width = float(adhesion.recovery_per == "length")
    return {cell: adhesion.cell_length, "energy_width": width, "wheel_memory": adhesion.wheel_memory}


def _axles(model: AssembledModel) -> list[_core.AxleParts]:
    """Those of the model, then those that are only simulated, which have what the first one has."""
    case = model.case
    simulated = _core.AxleParts(
        **dict.fromkeys(("wheelset", "axle_torque", "brake", "roller", "roller_torque"), ABSENT),
        contacts=[ABSENT, ABSENT],
        electrodynamic=model.axles[0].electrodynamic,
        has_brake=case.brake is not None and not case.brake.by_traction_motors,
        has_motor=case.traction is not None,
        sands=False,
    )
    return [*model.axles, *[simulated] * (len(model.axle_names) - len(model.axles))]


def _frame(model: AssembledModel) -> _core.TravellingFrame:
    """Masses of a train on track: as a whole, and what of it the frame itself stands for."""
    if isinstance(model.case.support.data, Rig):
        return _core.TravellingFrame(train_mass=0.0, fixed_mass=0.0)
    mass = train_mass(model)
    free = sum(model.masses[b] for b in model.lateral_bodies)
    return _core.TravellingFrame(train_mass=mass, fixed_mass=max(0.0, mass - free) if model.fixed else 0.0)


# ---------------------------------------------------------------------------------------------------- parts


def law_of(registry: Mapping[str, Any], table: Any, **given: Any) -> Any:
    """The law of a registry of the core that a table names by its kind; its bandwidth is an angular frequency there."""
    if hasattr(table, "bandwidth"):
        given["bandwidth"] = angular(table.bandwidth)
    return part_of(registry[table.kind], table, **given)


def motor(table: Motor) -> _core.Motor:
    """A drive, without its rotor: that is a body of the model."""
    return part_of(_core.Motor, table, envelope=table.envelope or (), bandwidth=angular(table.bandwidth))


def _actuators(model: AssembledModel, control: RigControl) -> _core.Actuators:
    case = model.case
    brake = case.brake or Brake(demand=((0.0, 0.0), (1.0, 0.0)))
    traction = case.traction
    return _core.Actuators(
        brake=friction_brake(brake),
        pneumatics=pneumatics(brake),
        by_traction_motors=brake.by_traction_motors,
        electrodynamic=electrodynamic_brake(brake, case.vehicle.data.wheel.radius),
        track_brake=None if case.track_brake is None else track_brake(case.track_brake, model.bogies),
        brake_demand=brake.demand,
        motor=motor(traction.motor if traction else Motor()),
        torque_demand=traction.demand if traction else (),
        roller_drive=motor(control.motor),
    )


def _sensors(table: Sensors) -> _core.Sensors:
    flange = table.roller_torque
    return part_of(
        _core.Sensors,
        table,
        axles=law_of(_core.speed_sensors, table.axles),
        rollers=law_of(_core.speed_sensors, table.rollers),
        vehicle=None if table.vehicle is None else law_of(_core.speed_sensors, table.vehicle),
        roller_torque=None if flange is None else _force_sensor(flange),
        axle_load=_force_sensor(table.axle_load),
    )


def _force_sensor(table: ForceSensor) -> _core.ForceSensor:
    return part_of(_core.ForceSensor, table, bandwidth=table.bandwidth and angular(table.bandwidth))


# ---------------------------------------------------------------------------------------------------- controllers


def _controllers(model: AssembledModel, users: Mapping[str, UserController]) -> list[_core.SampledController]:
    """Those of the case, in the order of the core's registry."""
    found, step = [], model.case.time.sampling_step
    for name in _core.controllers:
        table = getattr(model.case, name)
        if table is not None:
            time = users[name].sample_time if name in users else table.sample_time
            steps = {"every": round(time / step), "delay": round(table.delay / step)}
            sampling = _core.Sampling(**steps, external=name in users)
            found.append(_core.SampledController(sampling=sampling, controller=controller_of(model, name)))
    return found


def controller_of(model: AssembledModel, name: str) -> Any:
    """Our own controller of a table that the case has.

    Raises:
        StartError: the virtual train's vehicle has no equilibrium on track.
    """
    case, law = model.case, _core.controllers[name]
    table, radius = getattr(case, name), case.vehicle.data.wheel.radius
    if isinstance(table, RigControl):
        return rig_controller(model)
    if name == "brake_unit" and case.brake is not None:
        return law(pneumatics=pneumatics(case.brake), **air_groups(model))
    if name == "slide_protection":
        return slide_protection(table, radius)
    search = part_of(_core.SlipSearch, table.search, axle_inertia=wheelset_inertia(model))
    return part_of(law, table, wheel_radius=radius, search=search)


def slide_protection(table: SlideProtection | TableSlideProtection, wheel_radius: float) -> Any:
    """Slide protection by the law of a table, for wheels of an assumed radius [m]."""
    given: dict[str, Any] = {"entries": entry_numbers(table)} if isinstance(table, TableSlideProtection) else {}
    law = part_of(_core.slide_protections[table.kind], table, **given)
    again = table.return_speed or table.least_speed
    return part_of(_core.SlideProtection, table, law=law, wheel_radius=wheel_radius, return_speed=again)


def rig_controller(model: AssembledModel) -> _core.RigControl:
    """The controller of the rollers: its estimator, the virtual train and its rail, and the feedback.

    Raises:
        StartError: the vehicle has no equilibrium on track.
    """
    control = model.case.rig_control
    assert control is not None
    return part_of(
        _core.RigControl,
        control,
        assumed=assumed_parameters(model),
        estimator=estimator(control),
        axle_torque=axle_torque(control.axle_torque),
        feedback=law_of(_core.feedbacks, control.feedback),
        drive_command=drive_command(control),
        largest=control.feedback.largest,
        commanded_torque=control.estimator.torque == "commanded",
        measured_loads=control.loads == "measured",
        train=_virtual_train(model),
        rail=virtual_rail(model),
    )


def virtual_rail(model: AssembledModel) -> _core.VirtualRail:
    """The rail under axles that are only computed.

    Raises:
        StartError: the vehicle has no equilibrium on track.
    """
    case, contact, patch, memory = model.case, model.case.contact, rail_patch(model), _rail(model.case, "cell")
    return _core.VirtualRail(
        creep=core_law(contact.creep),
        friction=friction(contact, model.adhesion),
        wheel_load=patch.load,
        a=patch.a,
        b=patch.b,
        width=memory.pop("energy_width") or patch.width,
        **memory,
        sand_kept=case.sanding.kept if case.sanding else 1.0,
        stiffness=kalker_stiffness(contact, patch.a, patch.b),
        creepage_regularisation_speed=contact.creepage_regularisation_speed,
    )


def estimator(control: RigControl) -> Any:
    """The estimator of contact force and axle torque."""
    return law_of(_core.estimators, control.estimator)


def axle_torque(table: AnyAxleTorque) -> Any:
    """Where the controller takes the torque of an axle from."""
    if isinstance(table, KnownTorque):
        return law_of(_core.axle_torque_laws, table, bandwidth=angular(table.correction))
    return law_of(_core.axle_torque_laws, table)


def drive_command(control: RigControl) -> Any:
    """How the drives are asked for their torque; a lead without a time of its own has that of (D22)."""
    table = control.drive_command
    given: dict[str, Any] = {}
    if isinstance(table, LeadCommand) and table.ahead is None:
        lag = _core.torque_lag(motor(control.motor), control.sample_time, control.delay, 0.0)
        given = {"ahead": lag + 0.5 * control.sample_time}
    return law_of(_core.drive_commands, table, **given)


def assumed_parameters(model: AssembledModel) -> _core.AssumedParameters:
    """Wheel and roller as the controller assumes them: the rig's own, where the case does not say otherwise."""
    case = model.case
    control, rig = case.rig_control, case.support.data
    assert control is not None
    assert isinstance(rig, Rig)
    true = {
        "roller_inertia": rig.roller_inertia[1] + rotor_inertia(control.motor),
        "roller_radius": rig.roller_radius,
        "wheelset_inertia": wheelset_inertia(model),
        "wheel_radius": case.vehicle.data.wheel.radius,
    }
    chosen: dict[str, Any] = {name: getattr(control.assumed, name) or value for name, value in true.items()}
    return _core.AssumedParameters(**chosen)


def rotor_inertia(table: Motor | None) -> float:
    """Inertia of a drive's rotor on the driven axle [kg m^2]; 0 without a drive."""
    return float(_core.reflected_inertia(table.rotor_inertia, table.gear_ratio)) if table is not None else 0.0


def wheelset_inertia(model: AssembledModel) -> float:
    """Inertia of a wheelset about its axle, with the rotor of its motor [kg m^2]."""
    traction = model.case.traction
    return model.inertias[model.wheelsets[0]][1] + rotor_inertia(traction.motor if traction else None)


def _virtual_train(model: AssembledModel) -> _core.VirtualTrain:
    case = model.case
    return part_of(
        _core.VirtualTrain,
        case.train,
        mass=train_mass(model),
        gravity=case.gravity,
        wheelset_inertia=wheelset_inertia(model),
        wheel_radius=case.vehicle.data.wheel.radius,
        static_load=[*model.axle_loads.values()],
        load_transfer=load_transfer(model),
        position=axle_places(model),
    )


def full_brake_torque(case: Case) -> float:
    """Against the turning of each axle, at the largest pressure asked for and the speed of the start [N m]."""
    if case.brake is None or case.motion.speed <= 0.0:
        return 0.0
    pressure = max(row[1] for row in case.brake.demand)
    speed = case.motion.speed / case.vehicle.data.wheel.radius
    return -float(friction_brake(case.brake).torque(pressure, speed))


def feedback_gains(model: AssembledModel) -> tuple[float, float]:
    """Proportional [N m s/rad] and integral gain [N m/rad] of PI feedback on a rig with [rig_control], (D6).

    Those of the case; with feedback of another kind those that PI feedback has by default.
    """
    control = model.case.rig_control
    assert control is not None
    table = control.feedback if isinstance(control.feedback, ProportionalIntegral) else ProportionalIntegral()
    proportional, integral = _core.feedback_gains(law_of(_core.feedbacks, table), assumed_parameters(model))
    return proportional, integral


def estimator_response(model: AssembledModel) -> dict[str, tuple[float, float]]:
    """Measured bandwidth [Hz] and delay of slow changes [s] of the estimates 'force' and 'torque', with exact sensors."""
    control = model.case.rig_control
    assert control is not None
    found = _core.estimator_response(estimator(control), assumed_parameters(model), control.sample_time)
    return {name: (of[0] / angular(1.0), of[1]) for name, of in zip(("force", "torque"), found, strict=True)}
