"""Checks across the tables of a case or programme, and of its size.

    Case -> [check_case] -> problems that say which key to change, before anything is computed
    Programme -> [check_programme] -> mistakes

A run must end: each key may be in its range, and the numbers kept, steps integrated and rail remembered be too many.
"""

from collections.abc import Iterator, Mapping
from typing import Any

from rollerrig import _core
from rollerrig.config.errors import ConfigProblem, Mistake, nearest, one_of, problems_of, show_value
from rollerrig.config.schema.case import CaseTables
from rollerrig.config.schema.programme import Programme
from rollerrig.config.schema.vehicle import Vehicle
from rollerrig.config.validate.check_actuators import DRIVE_OF_RIG_CONTROL, check_actuators
from rollerrig.config.validate.check_profile import check_fit, check_patch
from rollerrig.config.validate.check_track import check_heads, check_track
from rollerrig.config.validate.check_vehicle import labelled, unknown_names

MOST_NUMBERS = 2e9
"""Results of one run: 16 GB."""
MOST_STEPS = 1e9
"""Largest number of steps of a fixed-step method: hours for a wheelset, days for a vehicle."""


def numbers_per_sample(case: CaseTables) -> int:
    """About how many numbers a run keeps at each output time."""
    part, bodies, axles = case.vehicle.part, case.vehicle.bodies, len(case.vehicle.wheelsets)
    of_the_train = len(case.train.axles.positions) if case.train.axles else 0
    of_a_wheel = len(_core.wheel_fields) + _core.patches_recorded * len(_core.patch_fields)
    return (
        (len(bodies) + len(part.fixed) + 2 * axles) * len(_core.body_fields)
        + 2 * axles * of_a_wheel
        + len(case.vehicle.data.elements_in(part)) * len(_core.element_fields)
        + (max(axles, of_the_train) * len(_core.axle_fields) if case.sampled else 0)
    )


def _results(case: CaseTables) -> Iterator[Mistake]:
    """Runs that would not fit into memory."""
    duration, step = case.time.duration, case.time.output_step
    width = numbers_per_sample(case)
    if width * duration / step > MOST_NUMBERS:
        least = width * duration / MOST_NUMBERS
        allowed = (
            f"too many results: {duration / step:.3g} samples of {width} numbers are {8e-9 * width * duration / step:.3g} GB; "
            f"allowed for {duration:g} s: at least {1e3 * least:.3g} ms, or a shorter time.duration"
        )
        yield "time.output_step", f"{1e3 * step:g} ms", allowed


def _steps(case: CaseTables) -> Iterator[Mistake]:
    """Runs that would not end within days."""
    duration, own = case.time.duration, case.integration
    asked = {
        "step": own.step if own.fixed else None,
        "maximum_step": case.time.maximum_step,
        "sampling_step": case.time.sampling_step if case.sampled else None,
    }
    for key, step in asked.items():
        if step is not None and duration / step > MOST_STEPS:
            allowed = (
                f"{duration / step:.3g} steps would take days; allowed for {duration:g} s: at least "
                f"{1e3 * duration / MOST_STEPS:.3g} ms, or a shorter time.duration"
            )
            yield f"time.{key}", f"{1e3 * step:g} ms", allowed


def _rail(case: CaseTables) -> Iterator[Mistake]:
    """The rail that is remembered must reach from the first wheelset to the last, or the following wheels find it as it was."""
    adhesion = case.adhesion
    if adhesion is None or not adhesion.recovery_constant:
        return
    places = [body.position[0] for body in case.vehicle.wheelsets]
    least = (max(places) - min(places)) / (_core.rail_cells - 2)
    if adhesion.cell_length < least:
        apart = f"{_core.rail_cells} cells are kept of wheelsets {max(places) - min(places):.4g} m apart"
        allowed = f"allowed: at least {1e3 * least:.3g} mm: {apart}"
        yield "adhesion.cell_length", f"{1e3 * adhesion.cell_length:g} mm", allowed


def check_case_names(raw: Mapping[str, Any], vehicle: Vehicle) -> Iterator[Mistake]:
    """Names of cuts and bodies that the vehicle does not have; works on raw tables next to other mistakes."""
    choice = raw.get("vehicle")
    name = choice.get("cut", "vehicle") if isinstance(choice, Mapping) else "vehicle"
    if name not in vehicle.cut_names():
        yield from unknown_names(name, vehicle.cut_names(), "vehicle.cut")
        return
    cut = vehicle.cut_named(name)
    free = [body.name for body in vehicle.bodies_in(cut)]
    wheelsets = [body.name for body in vehicle.bodies_in(cut) if body.kind == "wheelset"]
    for label, torque in labelled(raw, "axle_torque"):
        yield from unknown_names(torque.get("wheelset"), wheelsets, f"{label}.wheelset")
        others = ["none", *(name for name in (*free, *cut.fixed) if name != torque.get("wheelset"))]
        yield from unknown_names(torque.get("reacts_on"), others, f"{label}.reacts_on")
    for label, disturbance in labelled(raw, "disturbance"):
        yield from unknown_names(disturbance.get("body"), free, f"{label}.body")


def check_drive(raw: Mapping[str, Any], file: str) -> list[ConfigProblem]:
    """A torque asked of rollers that a controller drives; works on raw tables: without a table of it the case is no case."""
    motion = raw.get("motion")
    if "rig_control" not in raw or not isinstance(motion, Mapping) or motion.get("drive") != "torque":
        return []
    return [ConfigProblem(file, "motion.drive", "'torque'", f"{DRIVE_OF_RIG_CONTROL}; no motion.torque_table")]


def check_case(case: CaseTables, file: str) -> list[ConfigProblem]:
    """What only a case of valid tables can be asked."""
    checks = (check_fit, _disturbances, _drive, check_heads, _restraint, check_actuators, check_patch,
              _results, _steps, _rail)  # fmt: skip
    return problems_of(file, (mistake for check in checks for mistake in check(case)))


def _drive(case: CaseTables) -> Iterator[Mistake]:
    if case.support.data.kind == "track" and case.motion.drive != "speed_controlled":
        allowed = "allowed on a track: 'speed_controlled', the vehicle's frame moves at motion.speed"
        yield "motion.drive", show_value(case.motion.drive), allowed
    else:
        yield from check_track(case)


def _restraint(case: CaseTables) -> Iterator[Mistake]:
    """A coupler rod needs a body that it can hold."""
    support = case.support.data
    if support.kind != "rig" or support.restraint is None:
        return
    free = [body.name for body in case.vehicle.bodies if body.kind != "wheelset" and "x" not in body.locked]
    heaviest = case.vehicle.data.heaviest_in(case.vehicle.part)
    name = support.restraint.body or (heaviest.name if heaviest else "none")
    if name not in free:
        allowed = "allowed: no restraint; nothing of this vehicle that it could hold is free in x"
        yield "support.restraint.body", show_value(name), one_of(free) if free else allowed, nearest(name, free)


def _disturbances(case: CaseTables) -> Iterator[Mistake]:
    """Which directions are free is found with the model, before the run."""
    bodies = [disturbance.body for disturbance in case.disturbance]
    for body in bodies:
        if bodies.count(body) > 1:
            yield "disturbance", show_value(body), "allowed: each body once"


def check_programme(programme: Programme) -> Iterator[Mistake]:
    """What only a programme of valid tables can be asked."""
    names = [stop.name for stop in programme.stop]
    for number, name in enumerate(names):
        if name in names[:number]:
            yield f"stop[{number}].name", show_value(name), "allowed: each name once"
    for number, limit in enumerate(programme.limit):
        at, held = f"limit[{number}]", [stop for stop in programme.stop if limit.holds_for(stop)]
        drag = f"allowed for {limit.criterion}: stops in which the train stops, which drag braking is not"
        for name in limit.stops:
            if name not in names:
                yield f"{at}.stops", show_value(name), one_of(names), nearest(name, names)
            elif name not in [stop.name for stop in held]:
                yield f"{at}.stops", show_value(name), drag
        if not limit.stops and not held:
            yield f"{at}.criterion", show_value(limit.criterion), f"holds for no stop; {drag}"
        before = [other for other in programme.limit[:number] if other.criterion == limit.criterion]
        twice = [stop.name for stop in held if any(other.holds_for(stop) for other in before)]
        if twice:
            allowed = f"allowed: one limit of it for {twice[0]}; name in `stops` what each of them holds for"
            yield f"{at}.criterion", show_value(limit.criterion), allowed
