"""Where the rails of a track lie and which heads they have: what its segments say, for each rail over the distance.

    segments, heads of the rails -> [rail_layout] -> y, z, roll of both rails as piecewise cubics -> the core's line
                                 -> [rail_heads]  -> heads on common knots, and which of them lies where -> the core's heads

A rail of another inclination is turned about the highest point of its head and moved so that the highest point of what results
is at the level of the rails again, and its gauge point where the gauge has it. A transition goes from one place to the next as
curvature and cant do, and from one head to the next. Equations: docs/theory/track.md, (W13), (W14).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from rollerrig.config.schema.profile import AnyProfile
from rollerrig.config.schema.support import Rig, Side, heads
from rollerrig.config.schema.track import Curve, Straight, Track, at_ends, layout
from rollerrig.profiles import ProfileTable, gauge_point, profile_from_spec, tabulate
from rollerrig.track import PiecewiseCubic, ramps

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
    """Heads of one side that change along the way.

    Attributes:
        tables: in the order in which they are met, all on the knots of the first.
        place: which of them, over the distance; 1.25 is a quarter of the way from the second to the third.
        period: of the distance, one turn of a roller [m]; 0: none.
    """

    tables: tuple[ProfileTable, ...]
    place: PiecewiseCubic
    period: float = 0.0


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
        *([[after, 1.0, 0.0, 0.0, 0.0]] if spot.length else []),
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
