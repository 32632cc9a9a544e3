"""Checks of brakes, drives, sensors and controllers.

Case -> [check_actuators] -> problems
"""

from collections.abc import Iterator

from rollerrig import _core
from rollerrig.config.errors import ConfigProblem, Mistake, nearest, one_of, show_value
from rollerrig.config.schema.brakes import MOST_AXLES, ReservoirAir
from rollerrig.config.schema.case import CaseTables
from rollerrig.config.schema.contact import Polach
from rollerrig.config.schema.faults import OF_SENSORS
from rollerrig.config.schema.support import Rig


def simulated_axles(case: CaseTables, study: str) -> list[ConfigProblem]:
    """The problem that a case has axles which are only simulated; none if all axles of its train are under test."""
    axles = case.train.axles
    if axles is None or len(axles.positions) == len(axles.under_test):
        return []
    others = f"{len(axles.positions)} axles, {len(axles.under_test)} of them under test"
    allowed = f"allowed: all axles under test; {study} knows no others. Leave [train.axles] away"
    return [ConfigProblem(case.name, "train.axles", others, allowed)]


_PLACED = 1e-3
"""To which places of axles must agree [m]."""
_PIPE_FILLED = 0.64
"""Pressure of a pipe that choked flow may change within a sampling step, over that before the orifice: 64 parts of 1 %."""
_DEAD_TIMES = ("opening_time", "closing_time", "least_pulse")
DRIVE_OF_RIG_CONTROL = "allowed with [rig_control]: 'free', its drives act on the rollers"


def check_actuators(case: CaseTables) -> Iterator[Mistake]:
    """What actuators, controllers and support ask of each other."""
    checks = [_needs, _faults]
    if case.sampled:
        checks += [_drives, _air, _pipes, _machines, _train, _train_axles, _support, _times]
    elif case.contact.pure_rolling:
        yield "contact.pure_rolling", "true", "allowed with actuators: [brake], [traction] or [rig_control]"
    for check in checks:
        yield from check(case)


def _needs(case: CaseTables) -> Iterator[Mistake]:
    """Tables that mean nothing without another one."""
    machine = case.brake.electrodynamic if case.brake else None
    controlled = machine is not None and machine.on_slide == "slip_control"
    if controlled and case.wheel_slip_control is None:
        allowed = "allowed with [wheel_slip_control], which then acts on the brake's motors, too"
        yield "brake.electrodynamic.on_slide", "'slip_control'", allowed
    acting = {"slide_protection": "brake", "wheel_slip_control": "traction", "brake_unit": "brake"}
    for key, of in acting.items():
        if key == "wheel_slip_control" and controlled:
            continue
        if getattr(case, key) is not None and getattr(case, of) is None:
            yield key, "a table", f"allowed only with [{of}], on which it acts"
    if case.sanding is not None and case.adhesion is None:
        yield "sanding", "a table", "allowed only with [adhesion], the rail that it covers"


def _faults(case: CaseTables) -> Iterator[Mistake]:
    """Axles that are there, and what a fault of them needs."""
    axles = case.axle_names
    for number, fault in enumerate(case.fault):
        at, kind = f"fault[{number}]", show_value(fault.kind)
        if case.brake is None or case.brake.electrodynamic is not None:
            without = "brake.electrodynamic, with which the built-in unit shares the demand"
            yield at, fault.kind, f"allowed with [brake], and without {without}"
        if fault.kind in OF_SENSORS and case.slide_protection is None:
            yield f"{at}.kind", kind, "allowed with [slide_protection], which reads it"
        if fault.begin >= case.time.duration:
            yield f"{at}.begin", f"{fault.begin:g} s", f"allowed: before time.duration, {case.time.duration:g} s"
        if any((fault.kind, fault.axle) == (other.kind, other.axle) for other in case.fault[:number]):
            yield f"{at}.kind", kind, f"allowed: once for {fault.axle}"
        of_axle = [other.kind for other in case.fault if other.axle == fault.axle]
        if fault.kind == "dragging" and "isolated" in of_axle:
            yield f"{at}.kind", kind, f"allowed: one of isolated and dragging for {fault.axle}"
        if fault.axle not in axles:
            yield f"{at}.axle", show_value(fault.axle), one_of(axles), nearest(fault.axle, axles)


def _drives(case: CaseTables) -> Iterator[Mistake]:
    if case.brake is not None and case.brake.by_traction_motors and case.traction is None:
        yield "brake.by_traction_motors", "true", "needed: [traction], the motors that replace the brake"
    if len(case.vehicle.wheelsets) > MOST_AXLES:
        yield "vehicle.cut", show_value(case.vehicle.cut), f"allowed: at most {MOST_AXLES} axles"
    if case.axle_torque:
        yield "axle_torque", "given", "allowed beside actuators: [traction], which drives every axle"


def _machines(case: CaseTables) -> Iterator[Mistake]:
    """Electrodynamic brake, track brake and sand: what they act on."""
    machine = case.brake.electrodynamic if case.brake else None
    if case.brake is not None and machine is not None and case.brake.by_traction_motors:
        allowed = "allowed without brake.by_traction_motors: the motors either replace the brake or brake beside it"
        yield "brake.electrodynamic", "a table", allowed
    if case.brake_unit is not None and machine is not None:
        allowed = "allowed without brake.electrodynamic, whose torque the built-in brake unit takes off its own"
        yield "brake_unit", "a table", allowed
    if case.track_brake is not None and isinstance(case.support.data, Rig) and case.rig_control is None:
        why = "it brakes the virtual train, there is no rail beside the rollers"
        yield "track_brake", "a table", f"allowed on rollers with [rig_control]: {why}"
    protected = case.slide_protection is not None or case.wheel_slip_control is not None
    if case.sanding is not None and case.sanding.start.kind == "on_slide" and not protected:
        allowed = "allowed with [slide_protection] or [wheel_slip_control], which see the slide; or 'from_time', 'from_distance'"
        yield "sanding.start", "'on_slide'", allowed
    wheelsets = [body.name for body in case.vehicle.wheelsets]
    for key, table in (("brake.electrodynamic.axles", machine), ("sanding.axles", case.sanding)):
        for name in (table.axles or ()) if table is not None else ():
            if name not in wheelsets:
                yield key, show_value(name), one_of(wheelsets), nearest(name, wheelsets)


def _air(case: CaseTables) -> Iterator[Mistake]:
    """A reservoir that presses the pads at all once it has shared its air with the cylinders."""
    brake = case.brake
    if brake is None or not isinstance(brake.air, ReservoirAir):
        return
    air, key, start = brake.air, "reservoir_pressure", brake.air.reservoir_pressure
    if start is None:
        key, start = "main_pipe_pressure", air.main_pipe_pressure
    axles = len(case.train.axles.positions if case.train.axles else case.vehicle.wheelsets)
    fed = min(axles, air.axles_per_reservoir or axles)
    volume = brake.volume + (air.pipe.volume if air.pipe is not None else 0.0)
    share = air.reservoir_volume / (air.reservoir_volume + fed * volume)
    least = brake.spring_force / brake.piston_area / share
    if start <= least:
        empty = "a reservoir that is empty from the start brakes nothing"
        allowed = f"{empty}; allowed: above {least / 1e5:.3g} bar, at which the pads touch"
        yield f"brake.air.{key}", f"{start / 1e5:.3g} bar", allowed


def _pipes(case: CaseTables) -> Iterator[Mistake]:
    """Pipes that a sampling step resolves, behind relay valves that have one reservoir."""
    air = case.brake.air if case.brake is not None else None
    if not isinstance(air, ReservoirAir) or air.pipe is None:
        return
    own, together = air.pipe, air.axles_per_reservoir
    if together is not None and together % own.axles_per_relay_valve:
        allowed = f"allowed: a divisor of brake.air.axles_per_reservoir, {together}"
        yield "brake.air.pipe.axles_per_relay_valve", str(own.axles_per_relay_valve), allowed
    axles = len(case.train.axles.positions if case.train.axles else case.vehicle.wheelsets)
    conductance = max(air.fill_conductance, own.relay_conductance / min(axles, own.axles_per_relay_valve))
    least = air.reference_pressure * conductance * case.time.sampling_step / _PIPE_FILLED
    if own.volume < least:
        filled = f"a volume of {1e6 * own.volume:.3g} cm^3 is filled within a sampling step"
        longer = f"at least {own.length * least / own.volume:.3g} m, or a shorter time.sampling_step"
        yield "brake.air.pipe.length", f"{own.length:g} m", f"{filled}; allowed: {longer}"


def _train_axles(case: CaseTables) -> Iterator[Mistake]:
    """The axles under test are those of the vehicle, and the others have a train."""
    table, on_rig = case.train.axles, isinstance(case.support.data, Rig)
    if table is None:
        return
    places = sorted((body.position[0] for body in case.vehicle.wheelsets), reverse=True)
    if not case.vehicle.part.fixed and table.simulated:
        allowed = f"allowed where a body of the vehicle is fixed in the train; '{case.vehicle.cut}' has none"
        yield "train.axles", "a table", allowed
    if on_rig and case.rig_control is None and table.simulated:
        yield "train.axles", "a table", "allowed with [rig_control], whose virtual train they belong to, or on track"
    if len(table.under_test) != len(places):
        allowed = f"allowed: as many as the vehicle under test has, {len(places)}"
        yield "train.axles.under_test", show_value(table.under_test), allowed
        return
    behind = [table.positions[k - 1] - table.positions[table.under_test[0] - 1] for k in table.under_test]
    own = [places[0] - x for x in places]
    if any(abs(a - b) > _PLACED for a, b in zip(behind, own, strict=True)):
        spaced = f"spaced as those of the vehicle, {[round(x, 4) for x in own]} m"
        allowed = f"allowed: axles {list(table.under_test)} {spaced}"
        yield "train.axles.positions", show_value(table.positions), allowed
    reach = _core.rail_cells * (case.adhesion.cell_length if case.adhesion else 1e9)
    if table.positions[-1] >= reach:
        allowed = f"allowed: within {reach:.3g} m, the rail that is remembered; or a longer adhesion.cell_length"
        yield "train.axles.positions", f"{table.positions[-1]:g} m", allowed


def _train(case: CaseTables) -> Iterator[Mistake]:
    fixed, mass, axles = case.vehicle.part.fixed, case.train.mass, len(case.vehicle.wheelsets)
    if mass is not None and not fixed:
        allowed = f"allowed where a body of the vehicle is fixed; '{case.vehicle.cut}' is the train itself"
        yield "train.mass", f"{mass:g} kg", allowed
    moving = sum(body.mass for body in case.vehicle.bodies)
    if mass is not None and fixed and mass < moving:
        yield "train.mass", f"{mass:g} kg", f"allowed: at least what is under test, {moving:g} kg"
    transfer = case.rig_control.load_transfer if case.rig_control else "none"
    if not isinstance(transfer, str) and len(transfer) != axles:
        allowed = f"allowed: 'quasi_static', 'none', or {axles} numbers, one for each axle"
        yield "rig_control.load_transfer", show_value(transfer), allowed


def _support(case: CaseTables) -> Iterator[Mistake]:
    """What only a track, or only rollers allow."""
    support = case.support.data
    if isinstance(support, Rig):
        if support.coupling != "axle":
            allowed = "allowed with actuators: 'axle', one drive for each pair of rollers"
            yield "support.data.coupling", show_value(support.coupling), allowed
        if case.adhesion is not None and case.rig_control is None:
            allowed = "allowed on rollers with [rig_control], which reproduces it: the rollers themselves are dry"
            yield "adhesion", "a table", allowed
        if case.rig_control is not None and case.motion.drive != "free":
            yield "motion.drive", show_value(case.motion.drive), DRIVE_OF_RIG_CONTROL
        return
    if case.rig_control is not None:
        yield "rig_control", "a table", "allowed on rollers; a track reproduces nothing"
    if case.contact.pure_rolling:
        yield "contact.pure_rolling", "true", "allowed on rollers: the assumption of their control law"
    if case.motion.speed_table is not None:
        yield "motion.speed_table", "given", "allowed: motion.speed, from which the train runs on"
    creep = case.contact.creep
    if case.adhesion is not None and isinstance(creep, Polach) and (creep.k_A, creep.k_S) != (1.0, 1.0):
        allowed = "allowed on track with [adhesion]: 1 and 1; k_A and k_S of adhesion.rail take their place"
        yield "contact.creep", f"k_A = {creep.k_A:g}, k_S = {creep.k_S:g}", allowed


def _times(case: CaseTables) -> Iterator[Mistake]:
    """All times at multiples of the sampling step; a fixed step of the method is a whole part of it."""
    step, brake = case.time.sampling_step, case.brake
    times = [("time.output_step", case.time.output_step)]
    for key in ("slide_protection", "wheel_slip_control", "rig_control", "brake_unit"):
        controller = getattr(case, key)
        if controller is not None:
            times += [(f"{key}.sample_time", controller.sample_time), (f"{key}.delay", controller.delay)]
    if brake is not None and isinstance(brake.air, ReservoirAir):
        times += [(f"brake.air.{key}", getattr(brake.air, key)) for key in _DEAD_TIMES]
    if brake is not None and brake.electrodynamic is not None:
        times.append(("brake.electrodynamic.blending_delay", brake.electrodynamic.blending_delay))
    if case.sanding is not None:
        times.append(("sanding.delay", case.sanding.delay))
    for key, value in times:
        steps = value / step
        least = 0 if key.endswith(("delay", *_DEAD_TIMES)) else 1
        if abs(steps - round(steps)) > 1e-6 * max(1.0, steps) or round(steps) < least:
            near = max(round(steps), least) * step
            allowed = f"allowed: a multiple of time.sampling_step, {1e3 * step:g} ms; the nearest is {1e3 * near:g} ms"
            yield key, f"{1e3 * value:g} ms", allowed
    if step > 2e-3:
        yield "time.sampling_step", f"{1e3 * step:g} ms", "allowed: at most 2 ms, for motors, valves and the plant"
    own = case.integration
    if own.fixed and own.step is not None:
        parts = step / own.step
        if round(parts) < 1 or abs(parts - round(parts)) > 1e-6 * parts:
            near = step / max(1, round(parts))
            allowed = f"allowed: time.sampling_step, {1e3 * step:g} ms, or a whole part of it; the nearest is {1e3 * near:g} ms"
            yield "time.step", f"{1e3 * own.step:g} ms", allowed
