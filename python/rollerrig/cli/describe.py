"""A case or other file as a few tables of text, as `rollerrig check` prints it: line, actuators, controllers, bodies, balance.

Case -> assembled model, its equilibrium -> [describe_case] -> lines
"""

import math
import re
from collections.abc import Sequence

import xarray as xr

from rollerrig.analysis.equivalent_dead_time import lags
from rollerrig.analysis.slide_statistics import idle_valves
from rollerrig.assembly.actuators import assemble_with_actuators
from rollerrig.assembly.model import AssembledModel, assemble
from rollerrig.config import GRAVITY, Case, Element, Material, Programme, Rig, Track, Vehicle, code_of
from rollerrig.config.errors import ConfigError
from rollerrig.config.schema.base import Table
from rollerrig.config.schema.faults import fault_text
from rollerrig.config.schema.rig_control import BandwidthEstimator
from rollerrig.config.schema.track import SpectrumIrregularity, rails_of_run
from rollerrig.config.validate.check_track import highest_speed_on, speeds_on
from rollerrig.irregularity import RailIrregularity
from rollerrig.simulation.controllers import COMMANDS, fmu_controller, look_at_controller, users_controllers
from rollerrig.simulation.fmu_controller import FmuError
from rollerrig.simulation.mechatronics import estimator_response, feedback_gains, full_brake_torque, rig_controller
from rollerrig.simulation.starting_state import degrees_of_freedom, disturbances, equilibrium_dataset
from rollerrig.track import equilibrium_speed, plane_acceleration

Rows = list[dict[str, str]]
"""Rows of a table, heading -> text; what a row lacks is blank."""


def line_rows(track: Track, case: Case | None = None) -> Rows:
    """A row per segment; with a case, also how its vehicle runs there at its highest speed.

    A cant deficiency is the cant that would have to be added.
    """
    rows, gravity, base = Rows(), case.gravity if case else GRAVITY, track.cant_base
    for i, segment in enumerate(track.line.segments if track.line else ()):
        row = {"segment": f"{i} {segment.kind}", "from m": f"{segment.start:g}", "to m": f"{segment.end:g}"}
        speeds = speeds_on(case, segment) if case else None
        if case:
            row["speed km/h"] = f"{3.6 * speeds[1]:z.1f}" if speeds else "not reached"
        if segment.kind == "transition":
            row["radius m"] = segment.shape
        if segment.kind == "curve":
            curvature, cant = segment.curvature[0], segment.cant[0]
            outwards = math.copysign(1.0, curvature)
            balanced = equilibrium_speed(curvature, cant, base, gravity)
            row["radius m"] = f"{1 / abs(curvature):g} {'left' if curvature > 0 else 'right'}"
            row["cant mm"] = f"{1e3 * outwards * cant + 0.0:g}"
            row["equilibrium km/h"] = "none" if math.isnan(balanced) else f"{3.6 * balanced:z.1f}"
            if case and speeds:
                left_over = outwards * plane_acceleration(speeds[1], curvature, cant, base, gravity)
                row["cant deficiency mm"] = f"{1e3 * base * left_over / gravity:z.0f}"
                row["at most km/h"] = f"{3.6 * highest_speed_on(case, track, segment):z.0f}"
        rows.append(row)
    return rows


def irregularity_lines(support: Rig | Track, rails: RailIrregularity | None = None) -> list[str]:
    """Where the irregularity comes from, and the root mean square of its components where they are known."""
    chosen = support.irregularity
    if chosen is None:
        return []
    if isinstance(chosen, SpectrumIrregularity):
        rails = rails or rails_of_run(chosen, 0.0, 0.0)
        waves = f"waves of {chosen.shortest_wavelength:g} to {chosen.longest_wavelength:g} m"
        origin = f"ORE B 176, {chosen.level} level, seed {chosen.seed}, {waves}, repeating after {chosen.period:g} m"
    else:
        origin = f"measured, {chosen.path}"
    scaled = f", scaled by {chosen.scale:g}" if chosen.scale != 1.0 else ""
    lines = [f"irregularity: {origin}{scaled}, fading in over {chosen.fade_in:g} m"]
    if rails is not None:
        sizes = ", ".join(
            f"{name.replace('_', ' ')} {1e3 * size:z.2f}" for name, size in rails.root_mean_square().items()
        )
        lines.append(f"root mean square [mm]: {sizes}")
    return lines


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
    lines += [f"fault: {fault_text(fault)}" for fault in case.fault]
    if case.rig_control is not None:
        lines += [_train(model), *_roller_drives(case)]
    for name in COMMANDS:
        table = getattr(case, name)
        if table is not None:
            if table.fmu is not None:
                lines.append(_fmu(case, name, run_code))
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


def _fmu(case: Case, role: str, run_code: bool) -> str:
    """An FMU, of which only the description has been read unless its code may run."""
    table, controller = getattr(case, role), fmu_controller(case, role)
    try:
        if run_code:
            controller.try_out()
    except FmuError as error:
        raise ConfigError.of(case.name, f"{role}.fmu.file", repr(table.fmu.file), str(error)) from None
    finally:
        controller.close()
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
    by = "by the traction motors" if case.brake.by_traction_motors else "by friction brakes"
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
    instead = "" if isinstance(case.support.data, Rig) else ", in place of contact.friction"
    return [f"adhesion of the rail{instead}: {', then '.join(parts)}{recovery}"]


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
    left, command = lags(model), control.drive_command.kind.replace("_", " ")
    return (
        f"{text}; axle torque {control.axle_torque.kind}, drive command {command}: equivalent dead time "
        f"{1e3 * left.total:z.1f} ms, {1e3 * left.torque:z.1f} ms of the torque and {1e3 * left.drive:z.1f} ms of the drives"
    )


_CLOSED = 1e-6
"""Part of the weight: a larger difference to the wheel loads has a reason."""


def describe_case(case: Case, *, run_code: bool = False) -> list[str]:
    """The assembled model, static wheel loads and masses.

    Args:
        case: what is described.
        run_code: whether controllers that it brings are made and checked; they are only looked at otherwise.

    Raises:
        ConfigError: a disturbance moves what is locked.
        StartError: the model has no equilibrium.
    """
    model = assemble(case)
    disturbances(model)  # refused here as before a run
    run = equilibrium_dataset(model).isel(time=0)
    lines = [f"{case.name}: {case.description}", ""]
    lines += _bodies(model) + [""]
    if model.elements:
        lines += _elements(model) + [""]
    lines += _way(model)

    lines += _table([
        {
            f"wheels at {3.6 * float(run['speed']):.4g} km/h": wheel.name,
            "vertical kN": f"{float(run['vertical_force'][k]) / 1e3:z.3f}",
            "lateral kN": f"{float(run['lateral_force'][k]) / 1e3:z.3f}",
            "patches": f"{float(run['patch_count'][k]):z.0f}",
        }
        for k, wheel in enumerate(model.wheels)
    ])  # fmt: skip
    lines += [""] + _balance(model, run)
    actuators = actuator_lines(case, run_code=run_code)
    return [*lines, "", *actuators] if actuators else lines


def _across(part: Rig | Track) -> str:
    if part.contact_distance is None:
        return f"gauge {1e3 * part.gauge:g} mm"
    return f"contacts {1e3 * part.contact_distance:g} mm apart"


def describe_part(part: Table) -> list[str]:
    """A line or two about a vehicle, a support, a material, a profile or a test programme."""
    match part:
        case Vehicle():
            total = sum(body.mass for body in part.body)
            cuts = ", ".join(part.cut) or "none"
            return [
                f"{part.name}: {len(part.body)} bodies, {len(part.element)} force elements, {total / 1e3:z.3f} t",
                f"cuts: {cuts}",
            ]
        case Rig():
            rollers = f"{part.name}: rollers of {1e3 * part.roller_radius:g} mm radius, {_across(part)}"
            return [rollers, *irregularity_lines(part)]
        case Track():
            rails = "rigid rails" if part.foundation is None else "rails on an elastic foundation"
            lines = [f"{part.name}: track, {_across(part)}, {rails}", *irregularity_lines(part)]
            return lines + _table(line_rows(part))
        case Material():
            return [f"G = {part.shear_modulus / 1e9:g} GPa, Poisson's ratio {part.poisson_ratio:g}"]
        case Programme():
            kinds = [stop.kind for stop in part.stop]
            stops = ", ".join(f"{kinds.count(kind)} {kind}" for kind in dict.fromkeys(kinds))
            return [f"{part.name}: {len(kinds)} stops ({stops}) of {part.starts} starts, {len(part.limit)} limits"]
        case _:
            return [f"profile of kind {part.model_dump()['kind']}"]


def _way(model: AssembledModel) -> list[str]:
    """The line and the irregularity, each with an empty line behind it."""
    support = model.case.support.data
    rows = line_rows(support, model.case) if isinstance(support, Track) else []
    parts = (_table(rows), irregularity_lines(support, model.irregularity))
    return [line for part in parts if part for line in (*part, "")]


def _bodies(model: AssembledModel) -> list[str]:
    free = degrees_of_freedom(model)
    count = sum(len(directions) for directions in free.values())
    rows = [
        {
            f"bodies ({count} degrees of freedom)": body,
            "mass kg": f"{model.masses[body]:z.0f}",
            "free": ", ".join(free[body]) or ("speed-controlled" if body in model.rollers else "fixed"),
        }
        for body in model.bodies
    ]
    return _table(rows)


def _elements(model: AssembledModel) -> list[str]:
    known = {element.name: element for element in model.case.vehicle.data.element}
    sleepers = any(name.startswith("sleeper_") for name in model.rails)
    rows = []
    for name in model.elements:
        if element := known.get(name):
            between, acts = " - ".join(element.between), ", ".join(element.laws)
        elif name.removeprefix("mounting_") in model.rails:
            below = "sleeper" if sleepers and "_rail_" in name else "ground"
            between, acts = f"{below} - {name.split('_')[1]}", "mounting"
        else:
            between, acts = "ground - roller", "mounting"
        preload = f"{model.preloads[name] / 1e3:z.3f}" if name in model.preloads else ""
        rows.append({"force elements": name, "between": between, "acts along": acts, "preload kN": preload})
    return _table(rows)


def _balance(model: AssembledModel, run: xr.Dataset) -> list[str]:
    """Weight, and what fixed bodies add to it, against the sum of the wheel loads of the solved equilibrium."""
    own = list(model.lateral_bodies)
    mass = sum(model.masses[body] for body in own)
    weight = model.case.gravity * mass
    lines = [f"mass of {', '.join(own)}: {mass / 1e3:z.3f} t, weight {weight / 1e3:z.3f} kN"]
    supported = sum(
        _downward(run, element, model.fixed) for element in model.case.vehicle.data.elements_in(model.case.vehicle.part)
    )
    if model.fixed:
        design = sum(model.axle_loads.values()) - weight
        lines.append(
            f"load from {', '.join(model.fixed)}, which is fixed: {supported / 1e3:z.3f} kN, in the design position "
            f"{design / 1e3:z.3f} kN"
        )
    total, on_wheels = weight + supported, float(run["vertical_force"].sum())
    sums = f"total weight {total / 1e3:z.3f} kN, sum of the wheel loads {on_wheels / 1e3:z.3f} kN"
    if float(run["curvature"]) or float(run["cant"]):  # the plane of the track takes a part of both forces
        return [*lines, f"{sums}, normal to the track in the curve where the run starts"]
    lines.append(f"{sums} (difference {on_wheels - total:+.1e} N)")
    held = [body for body in own if "z" in model.case.vehicle.data.body_named(body).locked]
    if held and abs(on_wheels - total) > _CLOSED * total:
        lines.append(f"the difference is what holds {', '.join(held)}, whose z is locked")
    return lines


def _downward(run: xr.Dataset, element: Element, fixed: Sequence[str]) -> float:
    """Force by which an element presses free bodies down, 0 unless one of its ends is fixed [N]."""
    a_fixed, b_fixed = (name in fixed for name in element.between)
    force = float(run["element_force_z"].sel(element=element.name))
    return (force if b_fixed else 0.0) - (force if a_fixed else 0.0)


def _table(rows: Rows) -> list[str]:
    """Aligned columns below their headings; nothing without rows."""
    if not rows:
        return []
    columns = [[name, *(row.get(name, "") for row in rows)] for name in {name: "" for row in rows for name in row}]
    aligned = []
    for column in columns:
        width, numeric = max(map(len, column)), all(re.fullmatch(r"[-.\d]*", cell) for cell in column[1:])
        aligned.append([cell.rjust(width) if numeric else cell.ljust(width) for cell in column])
    return ["  ".join(line).rstrip() for line in zip(*aligned, strict=True)]
