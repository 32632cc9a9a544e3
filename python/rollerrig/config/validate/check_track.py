"""Checks of a track: segments that join, speeds the vehicle stays on its rails at, irregularities that reach far enough.

Rules and limits: docs/theory/layout.md.
"""

import math
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from rollerrig.config.errors import Mistake, show_value
from rollerrig.config.schema.case import CaseTables, Motion
from rollerrig.config.schema.support import Rig, changes_rails, heads, place, rail_heads
from rollerrig.config.schema.track import Curve, Foundation, Track, Transition, layout, rails_of_run
from rollerrig.config.schema.vehicle import Body
from rollerrig.config.validate.check_profile import check_gauge, check_profile, flange_clearance, wheel_load
from rollerrig.irregularity import IrregularityError, read_measured_track
from rollerrig.profiles import ProfileError, flange_angle, profile_from_spec
from rollerrig.track import Segment, highest_speed, limit_of_lateral_force, plane_acceleration

GIVE = (1e-7, 20e-3)
"""Least and largest displacement of a full-scale rail under the wheel load [m]; the contact itself gives way by 1e-4."""

RAIL_MASS = (1e-3, 10.0)
"""Least and largest mass of a piece of rail, or of its share of the sleepers, over the mass that its wheel carries [-]."""

SLOWEST_RETURN = 0.2
"""Damping over stiffness of a support [s]: a rail that comes back more slowly is as good as clamped; usual are milliseconds."""

TYPICAL = "flexible_track has typical values"

FLATTEST_FLANGE = math.radians(45)
"""A wheel that is nowhere steeper has no flange to climb."""


def check_support(support: Rig | Track) -> Iterator[Mistake]:
    """What only rails or rollers of valid tables can be asked."""
    for check in (check_gauge, check_line, check_measured_file, check_spot):
        yield from check(support)


def check_line(support: Rig | Track) -> Iterator[Mistake]:
    """Segments must join: curvature and cant jump nowhere, and a transition has something on either side."""
    if not isinstance(support, Track):
        return
    segments, joined = support.segment, True
    for i, segment in enumerate(segments):
        if isinstance(segment, Transition):
            lone = i in (0, len(segments) - 1) or isinstance(segments[i - 1], Transition)
            if lone or isinstance(segments[i + 1], Transition):
                allowed = "segments do not join; allowed: a transition between straights or curves, which it joins"
                joined = False
                yield f"segment[{i}].kind", "'transition'", allowed
    if joined:
        chain = layout(support)
        for i, (before, after) in enumerate(zip(chain[:-1], chain[1:], strict=True), 1):
            if before.curvature[1] != after.curvature[0] or before.cant[1] != after.cant[0]:
                ends = f"segment[{i - 1}] ends with {end_of(before)}, segment[{i}] begins with {end_of(after, 0)}"
                allowed = f"segments do not join: {ends}; put a transition between them"
                yield f"segment[{i}]", f"a {after.kind}", allowed
        yield from _rails(support)


def _rails(track: Track) -> Iterator[Mistake]:
    """Gauge and inclination jump nowhere; only profiles that have an inclination are laid at another one."""
    for i, segment in enumerate(track.segment):
        before = track.segment[max(i - 1, 0)]
        if isinstance(segment, Transition):
            continue
        for key, usual in (("gauge", f"{track.gauge:g} m"), ("inclination", "that of the profile")):
            own = getattr(segment, key)
            if not isinstance(before, Transition) and own != getattr(before, key):
                value, last = (usual if one is None else f"{one:g}" for one in (own, getattr(before, key)))
                between = "between two values put a transition, also on a straight"
                yield f"segment[{i}].{key}", value, f"allowed: as on segment[{i - 1}], {last}; {between}"
        if not isinstance(before, Transition) and heads(track, segment) != heads(track, before):
            allowed = f"allowed: as on segment[{i - 1}]; between two heads put a transition, also on a straight"
            yield f"segment[{i}].profile", "another head", allowed
        for side, head in heads(track, segment).items() if changes_rails(segment) else ():
            if segment.inclination is not None and not hasattr(head, "inclination"):
                lacks = f"the {side} rail, of kind {head.kind!r}, has none"
                allowed = f"{lacks}; allowed with 'uic60' and 'file'; leave it out"
                yield f"segment[{i}].inclination", f"{segment.inclination:g}", allowed
                break
            try:
                place(track, side, segment)
            except (ProfileError, OSError, ValueError) as error:
                key = "profile" if segment.inclination is None else "inclination"
                yield f"segment[{i}].{key}", f"the {side} rail", str(error)
                break


def end_of(segment: Segment, side: int = 1) -> str:
    """Curvature and cant at one end of a segment (0 its start, 1 its end), in words."""
    curvature, cant = segment.curvature[side], segment.cant[side]
    if not curvature:
        return "no curvature" + (f" and {1e3 * abs(cant):g} mm of cant" if cant else "")
    where = "left" if curvature > 0 else "right"
    outer = math.copysign(1e3 * cant, cant * curvature) if cant else 0.0
    return f"a radius of {1 / abs(curvature):g} m to the {where} and {outer:g} mm of cant"


def check_spot(support: Rig | Track) -> Iterator[Mistake]:
    """The generatrix of a spot must be usable, wherever the roller stands."""
    if isinstance(support, Rig) and support.spot is not None and support.spot.profile is not None:
        yield from check_profile(support.spot.profile, "rail", "spot.profile")


def check_heads(case: CaseTables) -> Iterator[Mistake]:
    """Heads that change are followed by strips alone, and on rollers need a known way of the crown."""
    support, name = case.support.data, case.contact.normal.kind
    heads_change = bool(rail_heads(support))
    if heads_change and name != "strips":
        allowed = "allowed where heads change along the rails or round the rollers: 'strips'"
        yield "contact.normal", show_value(name), allowed
    if heads_change and isinstance(support, Rig) and case.motion.drive != "speed_controlled":
        allowed = "allowed with a spot: 'speed_controlled', which says where on the roller the wheels stand"
        yield "motion.drive", show_value(case.motion.drive), allowed


def check_measured_file(support: Rig | Track) -> Iterator[Mistake]:
    """A file of measured rails must be readable, whatever runs over it."""
    if support.irregularity is not None and support.irregularity.kind == "file":
        path = support.irregularity.path
        try:
            read_measured_track(Path(path))
        except IrregularityError as error:
            yield "irregularity.path", show_value(path), str(error).removeprefix(f"{path}: ")


def check_track(case: CaseTables) -> list[Mistake]:
    """What only a vehicle at a speed can be asked."""
    support = case.support.data
    found = [*_irregularity(case)]
    if isinstance(support, Track) and support.foundation is not None:
        found += [*_rail_masses(case, support.foundation), *_give_way(case, support.foundation)]
    if isinstance(support, Track) and support.segment:
        found = found or [*_wheelbase_in_curves(case, support)] or [*_speed_in_curves(case, support)]
    return found


def _rail_masses(case: CaseTables, foundation: Foundation) -> Iterator[Mistake]:
    """Rails and sleepers have a mass, but not that of trains."""
    load, sleeper = wheel_load(case), foundation.sleeper
    lightest, heaviest = (share * load / case.gravity for share in RAIL_MASS)
    masses = {"rail_mass": foundation.rail_mass, **({"sleeper.mass": sleeper.mass} if sleeper else {})}
    for key, mass in masses.items():
        if not lightest <= mass <= heaviest:
            allowed = (
                f"allowed under the wheel load, {load / 1e3:.3g} kN: {lightest:.2g} to {heaviest:.2g} kg; {TYPICAL}"
            )
            yield f"support.data.foundation.{key}", f"{mass:g} kg", allowed


def _give_way(case: CaseTables, foundation: Foundation) -> Iterator[Mistake]:
    """Under a force as large as the wheel load a rail gives way by millimetres: neither by centimetres, nor not at all."""
    load = wheel_load(case)
    least, largest = (case.vehicle.data.wheel.profile.length_scale * give for give in GIVE)
    for part, where in ((foundation, "foundation"), (foundation.sleeper, "foundation.sleeper")):
        for key in ("lateral", "vertical", "roll"):
            law = getattr(part, key, None)
            arm, unit = (foundation.rail_height**2, "N m/rad") if key == "roll" else (1.0, "N/m")
            if law is None:
                continue
            name = f"support.data.{where}.{key}"
            if least <= (moved := load * arm / law.stiffness) <= largest:
                if law.damping > (most := SLOWEST_RETURN * law.stiffness):
                    damping = f"{most:.2g} {unit.replace('/', ' s/')}, {SLOWEST_RETURN:g} s times the stiffness"
                    yield f"{name}.damping", f"{law.damping:g}", f"allowed: at most {damping}; {TYPICAL}"
                continue
            allowed = (
                f"under the wheel load, {1e-3 * load:.3g} kN, the rail's head moves by {1e3 * moved:.2g} mm; "
                f"allowed: {load * arm / largest:.2g} to {load * arm / least:.2g} {unit}; {TYPICAL}; "
                "for a rigid rail leave it out"
            )
            yield f"{name}.stiffness", f"{law.stiffness:g}", allowed


def _wheelbase_in_curves(case: CaseTables, track: Track) -> Iterator[Mistake]:
    """Wheelsets under one frame must fit between the rails of a curve, by geometry.

    The outermost, w apart, are yawed by alpha = w / (2 R). A flange of angle delta, a cone, then takes alpha^2 r tan(delta) / 2
    more room on each side; one in their middle is w^2 / (8 R) off. Both together may take the play between flanges and rails.
    """
    wheel = case.vehicle.data.wheel
    steepest = flange_angle(profile_from_spec(wheel.profile.arguments(), "wheel"))
    if steepest < FLATTEST_FLANGE:
        return
    for frame, wheelsets in wheelsets_by_frame(case).items():
        places = [body.position[0] for body in wheelsets]
        base = max(places) - min(places)
        askew, off = (base / 2) ** 2 * wheel.radius * math.tan(steepest), base**2 / 8 if len(places) > 2 else 0.0
        for i, curve in enumerate(track.segment):
            if not isinstance(curve, Curve):
                continue
            play = flange_clearance(wheel, curve.gauge or track.gauge)
            if play is None or play <= 0.0:
                continue
            least = (off + math.sqrt(off**2 + 4 * askew * play)) / (2 * play)  # askew / R^2 + off / R = play
            if curve.radius < least:
                allowed = (
                    f"tighter than the wheelbase of {case.vehicle.data.name} allows: {len(places)} wheelsets under {frame}, "
                    f"{base:.3g} m, jam in the gauge, whose play is {1e3 * play:.1f} mm; allowed: at least {least:.3g} m"
                )
                yield f"support.data.segment[{i}].radius", f"{curve.radius:g} m", allowed


def wheelsets_by_frame(case: CaseTables) -> dict[str, list[Body]]:
    """Wheelsets of the case's part of the vehicle under each body that they carry."""
    vehicle, found = case.vehicle.data, dict[str, list[Body]]()
    wheelsets = {body.name: body for body in case.vehicle.wheelsets}
    for element in vehicle.element:
        for own, other in (element.between, element.between[::-1]):
            if element.carries_load and own in wheelsets and wheelsets[own] not in found.setdefault(other, []):
                found[other].append(wheelsets[own])
    return {frame: standing for frame, standing in found.items() if len(standing) > 1}


def _irregularity(case: CaseTables) -> Iterator[Mistake]:
    support, irregularity = case.support.data, case.support.data.irregularity
    if irregularity is None:
        return
    if isinstance(support, Rig) and case.motion.drive != "speed_controlled":
        allowed = "allowed with an irregularity that is fed to the rollers: 'speed_controlled', which says how far they have run"
        yield "motion.drive", show_value(case.motion.drive), allowed
        return
    try:
        rails_of_run(irregularity, foremost_wheelset(case), distance_run(case.motion, case.time.duration))
    except IrregularityError as error:
        path = str(getattr(irregularity, "path", ""))
        yield "support.data.irregularity.path", show_value(path), str(error).removeprefix(f"{path}: ")


def foremost_wheelset(case: CaseTables) -> float:
    """How far ahead of the middle of the vehicle (or of its cut) the foremost wheelset stands [m]."""
    return max(body.position[0] for body in case.vehicle.wheelsets) - case.vehicle.part.origin_x


def distance_run(motion: Motion, time: float) -> float:
    """Distance that the vehicle's frame runs until a time [m]."""
    if motion.speed_table is None:
        return motion.speed * time
    times, speeds = np.array(motion.speed_table).T
    knots = np.union1d(times[times < time], [0.0, time])
    return float(np.trapezoid(np.interp(knots, times, speeds), knots))


def speed_at(motion: Motion, distance: float, duration: float) -> float:
    """Speed with which the vehicle's frame passes a distance, or with which it stops short of it [m/s]."""
    if motion.speed_table is None:
        return motion.speed
    low, high = 0.0, duration
    while high - low > 1e-6 * duration:
        middle = (low + high) / 2
        low, high = (middle, high) if distance_run(motion, middle) < distance else (low, middle)
    times, speeds = np.array(motion.speed_table).T
    return float(np.interp(low, times, speeds))


def speeds_on(case: CaseTables, segment: Segment) -> tuple[float, float] | None:
    """Lowest and highest speed at which the vehicle's frame runs on a segment [m/s]; None if it does not get there."""
    motion, duration = case.motion, case.time.duration
    end = distance_run(motion, duration)
    if segment.start > end:
        return None
    places = [max(segment.start, 0.0), min(segment.end, end)]
    for time, _ in motion.speed_table or ():
        if time < duration and places[0] < distance_run(motion, time) < places[1]:
            places.append(distance_run(motion, time))
    found = [speed_at(motion, place, duration) for place in places]
    return min(found), max(found)


def highest_speed_on(case: CaseTables, track: Track, curve: Segment) -> float:
    """Speed beyond which the vehicle overturns on a curve or climbs its outer rail, by statics [m/s]."""
    limit, _ = lateral_force_limit(case)
    return highest_speed(curve.curvature[0], curve.cant[0], track.cant_base, limit, case.gravity)


def _speed_in_curves(case: CaseTables, track: Track) -> Iterator[Mistake]:
    _, what = lateral_force_limit(case)
    for i, (segment, curve) in enumerate(zip(layout(track), track.segment, strict=True)):
        speeds = speeds_on(case, segment) if isinstance(curve, Curve) else None
        if speeds is None or not isinstance(curve, Curve):
            continue
        curvature, cant = segment.curvature[0], segment.cant[0]
        highest = highest_speed_on(case, track, segment)
        if speeds[1] > highest:
            left = abs(plane_acceleration(speeds[1], curvature, cant, track.cant_base, case.gravity))
            allowed = (
                f"speed beyond {what} on support.data.segment[{i}], radius {curve.radius:g} m, cant {1e3 * curve.cant:g} mm: "
                f"{left:.2f} m/s^2 are left in the plane of the track; allowed there: at most {3.6 * highest:.0f} km/h"
            )
            yield "motion.speed", f"{3.6 * speeds[1]:g} km/h", allowed


def lateral_force_limit(case: CaseTables) -> tuple[float, str]:
    """Lateral force per load at which the free bodies of the case overturn or climb, and which of the two."""
    vehicle, bodies = case.vehicle.data, case.vehicle.bodies
    mass = sum(body.mass for body in bodies)
    height = sum(body.mass * body.position[2] for body in bodies) / mass
    steepest = flange_angle(profile_from_spec(vehicle.wheel.profile.arguments(), "wheel"))
    flange = steepest if steepest > FLATTEST_FLANGE else None
    base = case.support.data.cant_base if isinstance(case.support.data, Track) else 1.5
    return limit_of_lateral_force(height, base, flange, case.contact.flange_friction)
