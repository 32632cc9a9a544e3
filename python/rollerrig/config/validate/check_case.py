"""Checks of a case across its tables: what it drives, disturbs and stands on must fit the chosen part of the vehicle."""

from collections.abc import Iterable, Mapping
from typing import Any

from rollerrig.config.errors import ConfigProblem, nearest, one_of, show_value
from rollerrig.config.schema.case import CaseTables, Disturbance
from rollerrig.config.schema.vehicle import DIRECTIONS, Vehicle
from rollerrig.config.validate.check_actuators import DRIVE_OF_RIG_CONTROL, check_actuators
from rollerrig.config.validate.check_patch import check_patch
from rollerrig.config.validate.check_profile import check_flange_clearance, check_reach, check_scales
from rollerrig.config.validate.check_size import check_size
from rollerrig.config.validate.check_track import check_heads, check_track
from rollerrig.config.validate.check_vehicle import labelled, unknown_names

_DISTURBANCES = ("longitudinal", "lateral", "vertical", "roll", "pitch", "yaw")


def check_case_names(raw: Mapping[str, Any], vehicle: Vehicle, file: str) -> list[ConfigProblem]:
    """Names of cuts and bodies that the vehicle does not have; works on raw tables next to other mistakes."""
    choice = raw.get("vehicle")
    name = choice.get("cut", "vehicle") if isinstance(choice, Mapping) else "vehicle"
    problems = unknown_names(name, vehicle.cut_names(), "vehicle.cut", file)
    if problems or not isinstance(name, str):
        return problems
    cut = vehicle.cut_named(name)
    free = [body.name for body in vehicle.bodies_in(cut)]
    wheelsets = [body.name for body in vehicle.bodies_in(cut) if body.kind == "wheelset"]
    for label, torque in labelled(raw, "axle_torque"):
        problems += unknown_names(torque.get("wheelset"), wheelsets, f"{label}.wheelset", file)
        others = ["none", *(name for name in (*free, *cut.fixed) if name != torque.get("wheelset"))]
        problems += unknown_names(torque.get("reacts_on"), others, f"{label}.reacts_on", file)
    for label, disturbance in labelled(raw, "disturbance"):
        problems += unknown_names(disturbance.get("body"), free, f"{label}.body", file)
    return problems


def check_drive(raw: Mapping[str, Any], file: str) -> list[ConfigProblem]:
    """A torque asked of rollers that a controller drives; works on raw tables: without a table of it the case is no case."""
    motion = raw.get("motion")
    if "rig_control" not in raw or not isinstance(motion, Mapping) or motion.get("drive") != "torque":
        return []
    return [ConfigProblem(file, "motion.drive", "'torque'", f"{DRIVE_OF_RIG_CONTROL}; no motion.torque_table")]


def check_case(case: CaseTables, file: str) -> list[ConfigProblem]:
    """What only a case of valid tables can be asked."""
    wheel, support = case.vehicle.data.wheel, case.support.data
    problems = check_scales(wheel, support, file) or check_reach(wheel, support, file)
    problems = problems or check_flange_clearance(wheel, support, file)
    bodies = [disturbance.body for disturbance in case.disturbance]
    for disturbance in case.disturbance:
        if bodies.count(disturbance.body) > 1:
            problems.append(ConfigProblem(file, "disturbance", show_value(disturbance.body), "allowed: each body once"))
        problems += _disturbance(case, disturbance, file)
    if case.support.data.kind == "track" and case.motion.drive != "speed_controlled":
        allowed = "allowed on a track: 'speed_controlled', the vehicle's frame moves at motion.speed"
        problems.append(ConfigProblem(file, "motion.drive", show_value(case.motion.drive), allowed))
    else:
        problems += check_track(case, file)
    problems += check_heads(case, file)
    problems += _restraint(case, file)
    problems += check_actuators(case, file)
    problems += check_patch(case, file)
    problems += check_size(case, file)
    return list(dict.fromkeys(problems))


def _restraint(case: CaseTables, file: str) -> Iterable[ConfigProblem]:
    """A coupler rod needs a body that it can hold."""
    support, vehicle, cut = case.support.data, case.vehicle.data, case.vehicle.part
    if support.kind != "rig" or support.restraint is None:
        return
    free = [body.name for body in vehicle.bodies_in(cut) if body.kind != "wheelset" and "x" not in body.locked]
    heaviest = vehicle.heaviest_in(cut)
    name = support.restraint.body or (heaviest.name if heaviest else "none")
    if name not in free:
        allowed = (
            one_of(free) if free else "allowed: no restraint; nothing of this vehicle that it could hold is free in x"
        )
        yield ConfigProblem(file, "support.restraint.body", show_value(name), allowed, nearest(name, free))


def _disturbance(case: CaseTables, disturbance: Disturbance, file: str) -> Iterable[ConfigProblem]:
    body = case.vehicle.data.body_named(disturbance.body)
    for key, direction in zip(_DISTURBANCES, DIRECTIONS, strict=True):
        value = getattr(disturbance, key)
        if value and direction in body.locked:
            allowed = f"allowed: no offset in a direction in which the vehicle locks {body.name}"
            yield ConfigProblem(file, f"disturbance.{body.name}.{key}", show_value(value), allowed)
    if disturbance.pitch and body.kind == "wheelset":
        allowed = "allowed: no pitch of a wheelset, a body of revolution"
        yield ConfigProblem(file, f"disturbance.{body.name}.pitch", show_value(disturbance.pitch), allowed)
