"""Tables of a rig under a vehicle, and the rails of a line or rollers of a rig as they are laid.

    segments, heads of the rails -> [rail_layout] -> y, z, roll of both rails as piecewise cubics -> the core's line
                                 -> [rail_heads]  -> heads on common knots, and which of them lies where -> the core's heads

A rail of another inclination is turned about the highest point of its head and moved so that the highest point of what results
is at the level of the rails again, and its gauge point where the gauge has it. A transition goes from one place to the next as
curvature and cant do, and from one head to the next. Equations: docs/theory/track.md, (W13), (W14).
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Annotated, Literal

import numpy as np
from pydantic import Discriminator, RootModel, StrictBool

from rollerrig.config.schema.base import Mistakes, Table, needed, optional
from rollerrig.config.schema.profile import AnyProfile
from rollerrig.config.schema.track import Curve, Mounting, Restraint, Straight, Track, WithGauge, at_ends, layout
from rollerrig.config.schema.units import Inertia, Mass, Quantity, RollerRadius
from rollerrig.profiles import ProfileTable, gauge_point, profile_from_spec, tabulate
from rollerrig.track import PiecewiseCubic, ramps


class Spot(Table):
    """A worn or out-of-round spot of the rollers, at the same place of all of them; ramps join it to the rest of the crown."""

    start: Annotated[float, Quantity("m", 0.0, 100.0)] = optional(
        0.5, "way that the crown runs until the spot first comes under the wheel"
    )
    length: Annotated[float, Quantity("m", 0.0, 100.0)] = needed("along the crown, between the ramps")
    ramp: Annotated[float, Quantity("m", 1e-3, 100.0)] = needed("length of each ramp")
    depth: Annotated[float, Quantity("m", -0.01, 0.01)] = optional(0.0, "depth by which its radius is less")
    profile: AnyProfile | None = optional(None, "generatrix of the spot; absent: that of the roller")
    sides: Literal["both", "left", "right"] = optional("both", "rollers that have it")


class RollerLosses(Table):
    """Torque against the spin of a pair of rollers with their axle: constant + linear * w + quadratic * w^2."""

    constant: Annotated[float, Quantity("N m", 0.0, 1e6)] = optional(0.0, "bearings and seals, at any speed")
    linear: Annotated[float, Quantity("N m s/rad", 0.0, 1e6)] = optional(0.0, "grease and oil, per angular speed")
    quadratic: Annotated[float, Quantity("N m s^2/rad^2", 0.0, 1e6)] = optional(0.0, "ventilation, per its square")


class Rig(WithGauge):
    """A roller rig: under each wheelset a pair of rollers on one axis, parallel to y, under the wheelset's axle."""

    kind: Literal["rig"] = needed("rollers")
    roller_radius: RollerRadius = needed("radius at the crown")
    roller_mass: Mass = needed("mass of a pair of rollers with their axle")
    roller_inertia: tuple[Inertia, Inertia, Inertia] = needed(
        "moments of inertia of a pair about x, y (spin) and z through its centre"
    )
    coupling: Literal["axle", "independent"] = optional(
        "axle", "axle: left and right turn as one; independent: each with half of the spin inertia"
    )
    losses: RollerLosses | None = optional(None, "torques of bearings and air, per pair of rollers; absent: none")
    mounting: Mounting | None = optional(None, "elastic support of the roller axles; absent: they only spin")
    restraint: Restraint | None = optional(
        None, "a coupler rod that holds a vehicle along the track which nothing else holds; absent: there is none"
    )
    steered: StrictBool = optional(
        True,
        "steering of the rollers: with an irregularity they also turn about z into the direction of "
        "the rail they represent, as real rails do; false: they are only moved sideways and up",
    )

    spot: Spot | None = optional(None, "worn or out-of-round spot; absent: rollers are round")

    def _mistakes(self) -> Mistakes:
        yield from super()._mistakes()
        round_it = 2.0 * math.pi * self.roller_radius
        if self.spot is not None and self.spot.start + self.spot.length + 2.0 * self.spot.ramp > round_it:
            yield "spot", f"allowed: start, both ramps and length within one turn, {round_it:.4g} m"
        x, spin, z = self.roller_inertia
        if abs(x - z) > 1e-9 * x or spin > (x + z) * (1 + 1e-6):
            yield "roller_inertia", "allowed: a body of revolution, [I, I_spin, I] with I_spin at most 2 I"


Side = Literal["left", "right"]


def heads(support: Track | Rig, segment: Straight | Curve | None = None) -> dict[Side, AnyProfile]:
    """Profiles of the rails or rollers of both sides, each as a left one has it; of a track also on one of its segments."""
    left, right = support.profile, support.right_profile or support.profile
    if segment is None:
        return {"left": left, "right": right}
    return {"left": segment.profile or left, "right": segment.right_profile or segment.profile or right}


AnySupport = Annotated[Rig | Track, Discriminator("kind")]


class SupportRoot(RootModel[AnySupport]):
    """A support of either kind, as a file of its own."""


RAIL_CURVES = tuple(f"{side}_{name}" for side in ("left", "right") for name in ("y", "z", "roll"))
"""Displacement of the highest point of each head to the left and up [m], and its turn about x [rad]."""

NOWHERE = PiecewiseCubic(np.empty((0, 5)))


def rail_layout(track: Track) -> dict[str, PiecewiseCubic] | None:
    """The curves of RAIL_CURVES, empty where nothing changes; None for rails that lie as the track has them everywhere."""
    if not any(changes_rails(segment) for segment in track.segment):
        return None
    curves: dict[str, PiecewiseCubic] = {}
    for side in heads(track):
        places = [place(track, side, one) if isinstance(one, Straight | Curve) else None for one in track.segment]
        mirror = (1.0, 1.0, 1.0) if side == "left" else (-1.0, 1.0, -1.0)
        for number, name in enumerate(("y", "z", "roll")):
            ends = at_ends([None if one is None else mirror[number] * one[number] for one in places], 0.0)
            still = not any(value for pair in ends for value in pair)
            curves[f"{side}_{name}"] = NOWHERE if still else ramps(layout(track), ends, track.smoothing)
    return curves


def changes_rails(segment: object) -> bool:
    """Whether a segment says something about its rails."""
    keys = ("gauge", "inclination", "profile", "right_profile")
    return any(getattr(segment, key, None) is not None for key in keys)


def place(track: Track, side: Side, segment: Straight | Curve) -> tuple[float, float, float]:
    """Displacement of a rail on a segment, outward and up [m], and its lean inwards [rad], by (W13)."""
    usual, head = heads(track)[side], heads(track, segment)[side]
    from scipy.optimize import brentq  # a second that a case without such rails does not wait

    upright = profile_from_spec(head.arguments(), "rail")
    wider = 0.0 if segment.gauge is None else (segment.gauge - track.gauge) / 2
    if head != usual:
        base = profile_from_spec(usual.arguments(), "rail")
        wider += gauge_point(base, track.gauge_depth) - gauge_point(upright, track.gauge_depth)
    own = getattr(head, "inclination", 0.0)
    if segment.inclination is None or segment.inclination == own:
        return wider, 0.0, 0.0
    lean = math.atan(segment.inclination) - math.atan(own)
    sine, cosine = math.sin(lean), math.cos(lean)
    # The highest point of the turned head: there its slope was -tan(lean).
    low, high = upright.domain
    top = brentq(lambda y: float(upright.evaluate(y, 1)) * cosine + sine, 0.5 * low, 0.5 * high, xtol=1e-12)
    height = float(upright.evaluate(top))
    leaning = profile_from_spec({**head.arguments(), "inclination": segment.inclination}, "rail")
    further = gauge_point(upright, track.gauge_depth) - gauge_point(leaning, track.gauge_depth)
    return wider + further - (cosine * top - sine * height), -(sine * top + cosine * height), lean


@dataclass(frozen=True, eq=False)
class RailHeads:
    """Heads of one side that change along the way."""

    tables: tuple[ProfileTable, ...]  # in the order in which they are met, all on the knots of the first
    place: PiecewiseCubic  # which of them, over the distance; 1.25 is a quarter of the way from the second to the third
    period: float = 0.0  # of the distance, one turn of a roller [m]; 0: none


def rail_heads(support: Track | Rig) -> dict[Side, RailHeads]:
    """Heads of the sides on which they change; every other side has one everywhere."""
    return _heads_of_segments(support) if isinstance(support, Track) else _heads_with_spot(support)


def _heads_of_segments(track: Track) -> dict[Side, RailHeads]:
    found: dict[Side, RailHeads] = {}
    for side, usual in heads(track).items():
        specs: list[AnyProfile] = []
        numbers: list[float | None] = []
        for segment in track.segment:
            if not isinstance(segment, Straight | Curve):
                numbers.append(None)
                continue
            spec = heads(track, segment)[side]
            if not specs or spec != specs[-1]:
                specs.append(spec)
            numbers.append(float(len(specs) - 1))
        if len(specs) > 1 or (specs and specs[0] != usual):
            tables = [profile_from_spec(spec.arguments(), "rail") for spec in specs]
            place = ramps(layout(track), at_ends(numbers, 0.0), track.smoothing)
            found[side] = RailHeads(on_common_knots(tables), place)
    return found


def _heads_with_spot(rig: Rig) -> dict[Side, RailHeads]:
    spot = rig.spot
    if spot is None:
        return {}
    ramp, after = spot.ramp, spot.start + spot.ramp
    begins = after + spot.length
    rows = [
        [spot.start, 0.0, 0.0, 3 / ramp**2, -2 / ramp**3],
        *([[after, 1.0, 0.0, 0.0, 0.0]] if begins > after else []),
        [begins, 1.0, 0.0, -3 / ramp**2, 2 / ramp**3],
        [begins + ramp, 0.0, 0.0, 0.0, 0.0],
    ]
    found: dict[Side, RailHeads] = {}
    for side, usual in heads(rig).items():
        if spot.sides in ("both", side):
            specs = (usual, spot.profile or usual)
            own, other = on_common_knots([profile_from_spec(spec.arguments(), "rail") for spec in specs])
            lower = replace(other, coefficients=other.coefficients - [spot.depth, 0.0, 0.0, 0.0])
            found[side] = RailHeads((own, lower), PiecewiseCubic(np.array(rows)), 2 * math.pi * rig.roller_radius)
    return found


def on_common_knots(tables: Sequence[ProfileTable]) -> tuple[ProfileTable, ...]:
    """The same heads, where all of them reach, on the knots of one: blended there by their coefficients."""
    low, high = max(table.domain[0] for table in tables), min(table.domain[1] for table in tables)
    return tuple(
        tabulate(table.evaluate, low, high, name=table.name, kind="rail", source=table.source, step=tables[0].step)
        for table in tables
    )
