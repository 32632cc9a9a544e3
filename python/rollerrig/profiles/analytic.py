"""Profiles from formulas: S1002, the UIC60 rail head, and the cone, cylinder and arc of textbooks and closed-form tests.

S1002       published polynomials and arcs of ORE S1002, EN 13715.
UIC60, 60E1 tangent-continuous arcs R300 - R80 - R13, sides 1:20, of EN 13674-1; the UIC60 of the Manchester contact benchmark
            has slightly other junctions. At any inclination, positive leans the head inward:
            drawing (upright, half a head) -> mirrored -> turned about the running direction -> highest point to (0, 0)

Abscissa outward (away from the track centre), height upward; numbers of drawings in millimetres, what leaves this file in metres.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.polynomial import Polynomial

from rollerrig.common.arrays import Array
from rollerrig.profiles.table import DEFAULT_STEP, STEEPEST_SLOPE, ProfileKind, ProfileTable, tabulate

Segment = Callable[[Array], Array]

RUN_OUT = Polynomial([1.364323640, -0.066666667])
TREAD = Polynomial(
    [
        0.0,
        -3.358537058e-2,
        1.565681624e-3,
        -2.810427944e-5,
        5.844240864e-8,
        -1.562379023e-8,
        5.309217349e-15,
        -5.957839843e-12,
        2.646656573e-13,
    ]
)
FLANGE_ROOT_AS_PRINTED = Polynomial(
    [
        -4.320221063e3,
        -1.038384026e3,
        -1.065501873e2,
        -6.051367875,
        -2.054332446e-1,
        -4.169739389e-3,
        -4.687195829e-5,
        -2.252755540e-7,
    ]
)
FLANGE_FACE = Polynomial([-93.576667419, -2.747477419])


def _arc(s_0: float, centre: float, radius: float) -> Segment:
    """Arc about a centre, over it, or under it with a negative radius [mm]."""
    return lambda s: np.asarray(centre + np.sign(radius) * np.sqrt(radius**2 - (s - s_0) ** 2))


ROOT_ARC = _arc(-26.210665, 16.446, -13.0)


def _flange_root() -> Segment:
    """The polynomial between -35 and -26 mm, closed up with its neighbours.

    Its ten printed digits leave steps of 0.12 um at -35 and 0.04 um at -26 mm. Small, but a spline of 0.05 mm
    spacing would answer with curvature spikes of 50 1/m. A cubic through the four gaps (value and slope at both
    ends) closes them; it is nowhere larger than they are and changes the curvature by 0.03 1/m out of 190.
    """
    ends = np.array([-35.0, -26.0])
    arc_slope = (ends[0] + 26.210665) / np.sqrt(13.0**2 - (ends[0] + 26.210665) ** 2)
    value = np.array([ROOT_ARC(ends)[0], TREAD(ends[1])])
    slope = np.array([arc_slope, TREAD.deriv()(ends[1])])
    gap, length = value - FLANGE_ROOT_AS_PRINTED(ends), ends[1] - ends[0]
    turn = length * (slope - FLANGE_ROOT_AS_PRINTED.deriv()(ends))

    def closing(s: Array) -> Array:
        u = (s - ends[0]) / length
        of_values = gap[0] * (1 + 2 * u) * (1 - u) ** 2 + gap[1] * (3 - 2 * u) * u**2
        return np.asarray(of_values + turn[0] * u * (1 - u) ** 2 - turn[1] * (1 - u) * u**2)

    return lambda s: np.asarray(FLANGE_ROOT_AS_PRINTED(s) + closing(s))


#: (from S [mm], radius increase [mm] over S [mm]); each segment ends where the one above it starts.
SEGMENTS: tuple[tuple[float, Segment], ...] = (
    (32.15796, RUN_OUT),
    (-26.0, TREAD),
    (-35.0, _flange_root()),
    (-38.426669071, ROOT_ARC),
    (-39.764473993, FLANGE_FACE),
    (-49.662510381, _arc(-58.558326413, 8.834924130, 20.0)),
    (-62.764705882, _arc(-55.0, 16.0, 12.0)),
)


def s1002_height(s_mm: Array) -> Array:
    """Radius increase [mm] over the abscissa S [mm], -62.76 <= S <= 60."""
    s_mm = np.asarray(s_mm, dtype=np.float64)
    height, end = np.full(s_mm.shape, np.nan), np.inf
    for start, segment in SEGMENTS:
        inside = (s_mm >= start) & (s_mm < end)
        height[inside], end = segment(s_mm[inside]), start
    return height


def s1002(step: float = DEFAULT_STEP) -> ProfileTable:
    """Wheel profile S1002, flange tip to run-out: S from -60 to 60 mm.

    Args:
        step: knot spacing of the table [m].

    Returns:
        The table; 0 at the tape circle.
    """
    return tabulate(
        lambda s: s1002_height(s * 1e3) * 1e-3,
        -60e-3,
        60e-3,
        name="s1002",
        kind="wheel",
        source="ORE S1002, EN 13715: published polynomials and arcs",
        step=step,
    )


Variant = Literal["en_13674", "benchmark"]

#: Abscissae of the junctions R300 | R80 and R80 | R13 in the upright drawing [mm].
JUNCTIONS: dict[Variant, tuple[float, float]] = {"en_13674": (10.228, 26.0265), "benchmark": (10.5, 25.98803)}
RADII = (300.0, 80.0, 13.0)  # [mm]
SIDE_ANGLE = float(np.arctan2(20.0, 1.0))  # [rad] below the horizontal
SIDE_BOTTOM = -40.0  # [mm] how far down the straight side is drawn


@dataclass(frozen=True)
class Arc:
    """An arc of a convex head, crown up: a point is centre + radius (sin angle, cos angle).

    The angle is at once the downward slope angle towards positive y and the position on the arc.
    """

    y: float  # centre [mm]
    z: float  # centre [mm]
    radius: float  # [mm]
    start: float  # angle [rad], smaller abscissa
    end: float  # angle [rad], larger abscissa

    def point(self, angle: float | Array) -> Array:
        """Point(s) [mm] at an angle [rad]; shape (2,) or (2, n)."""
        return np.array([self.y + self.radius * np.sin(angle), self.z + self.radius * np.cos(angle)])


def half_head(variant: Variant) -> list[Arc]:
    """The three arcs of the field half (y > 0) of the upright head, crown first [mm]."""
    first, second = JUNCTIONS[variant]
    centre = np.array([0.0, -RADII[0]])
    angle = float(np.arcsin(first / RADII[0]))
    arcs = [Arc(0.0, -RADII[0], RADII[0], 0.0, angle)]
    for previous, radius in zip(RADII, RADII[1:], strict=False):
        # Tangent continuity: both centres lie on the common normal at the junction.
        centre = centre + (previous - radius) * np.array([np.sin(angle), np.cos(angle)])
        end = float(np.arcsin((second - centre[0]) / radius)) if radius == RADII[1] else SIDE_ANGLE
        arcs.append(Arc(float(centre[0]), float(centre[1]), radius, angle, end))
        angle = end
    return arcs


def inclined_head(variant: Variant, inclination: float) -> list[Arc]:
    """All arcs of the head, gauge side first, turned and with the highest point at the origin [mm].

    Args:
        variant: which drawing.
        inclination: tangent of the angle by which the head leans towards the track centre [-], e.g. 1/40.
    """
    field_side = half_head(variant)
    crown = field_side[0]
    gauge_side = [Arc(-a.y, a.z, a.radius, -a.end, -a.start) for a in reversed(field_side[1:])]
    upright = [*gauge_side, Arc(crown.y, crown.z, crown.radius, -crown.end, crown.end), *field_side[1:]]

    lean = float(np.arctan(inclination))
    cos, sin = np.cos(lean), np.sin(lean)
    turned = [
        Arc(a.y * cos - a.z * sin, a.y * sin + a.z * cos, a.radius, a.start - lean, a.end - lean) for a in upright
    ]
    top = next(a for a in turned if a.start <= 0.0 <= a.end).point(0.0)
    return [Arc(a.y - float(top[0]), a.z - float(top[1]), a.radius, a.start, a.end) for a in turned]


def head_height(arcs: list[Arc], y_mm: Array) -> Array:
    """Height [mm] of the head over the abscissa [mm]; NaN beyond the arcs."""
    y_mm = np.asarray(y_mm, dtype=np.float64)
    height = np.full(y_mm.shape, np.nan)
    for arc in arcs:
        inside = (y_mm >= arc.point(arc.start)[0]) & (y_mm <= arc.point(arc.end)[0])
        height[inside] = arc.z + np.sqrt(arc.radius**2 - (y_mm[inside] - arc.y) ** 2)
    return height


def outline(arcs: list[Arc], points_per_arc: int = 500) -> Array:
    """Points [m] along the head from the foot of the gauge side to that of the field side; shape (n, 2)."""
    curve = np.concatenate(
        [arc.point(np.linspace(arc.start, arc.end, points_per_arc + 1)).T[(k > 0) :] for k, arc in enumerate(arcs)]
    )

    def side(end: Array, angle: float) -> Array:  # the straight flank, down to SIDE_BOTTOM
        return np.array([[end[0] + (end[1] - SIDE_BOTTOM) / np.tan(angle), SIDE_BOTTOM]])

    whole = [side(curve[0], arcs[0].start), curve, side(curve[-1], arcs[-1].end)]
    return np.concatenate(whole) * 1e-3


def uic60(inclination: float, variant: Variant = "en_13674", step: float = DEFAULT_STEP) -> ProfileTable:
    """Rail head UIC60 / 60E1, or a roller with that generatrix.

    Args:
        inclination: tangent of the lean towards the track centre [-]: 0.025 is 1:40, 0 upright.
        variant: "en_13674" (60E1 as standardised) or "benchmark" (UIC60 of the Manchester contact benchmark).
        step: knot spacing of the table [m].

    Returns:
        The table, over all of the head whose slope is at most STEEPEST_SLOPE.
    """
    arcs = inclined_head(variant, inclination)
    steepest = float(np.arctan(STEEPEST_SLOPE))
    low = arcs[0].point(max(arcs[0].start, -steepest))[0] * 1e-3
    high = arcs[-1].point(min(arcs[-1].end, steepest))[0] * 1e-3
    drawing = {"en_13674": "EN 13674-1 60E1", "benchmark": "UIC60 of the Manchester contact benchmark"}[variant]
    lean = f"inclined 1:{1 / inclination:g}" if inclination else "upright"
    return tabulate(
        lambda y: head_height(arcs, y * 1e3) * 1e-3,
        float(low),
        float(high),
        name=f"{drawing}, {lean}",
        kind="rail",
        source=f"{drawing}: arcs R300-R80-R13, {lean}",
        step=step,
        outline=outline(arcs),
    )


def cone(conicity: float, half_width: float = 60e-3) -> ProfileTable:
    """Wheel whose radius falls off linearly outward, without a flange.

        value(S) = -conicity S

    Args:
        conicity: [-], e.g. 0.025 for 1:40; the wheel is larger towards the flange side where positive.
        half_width: the profile spans -half_width <= S <= half_width [m].

    Returns:
        The table; exact, since a spline holds a line.
    """
    return tabulate(
        lambda s: -conicity * s,
        -half_width,
        half_width,
        name=f"cone {conicity:g}",
        kind="wheel",
        source=f"cone of conicity {conicity:g}",
    )


SIDE_DEPTH = 40e-3  # [m] of the vertical flanks beside a rail head, so that it has a gauge


def cylinder(kind: ProfileKind = "rail", half_width: float = 36e-3) -> ProfileTable:
    """Constant profile: a flat rail head, a cylindrical roller or a cylindrical wheel.

    Args:
        kind: "rail" or "wheel"; a rail has vertical flanks at its ends, where its gauge is taken.
        half_width: the profile spans -half_width to half_width [m].
    """
    table = tabulate(np.zeros_like, -half_width, half_width, name="cylinder", kind=kind, source="constant profile")
    return _with_flanks(table)


def arc(radius: float, kind: ProfileKind = "rail", half_width: float = 36e-3) -> ProfileTable:
    """Convex circular profile with its top (rail) or largest radius (wheel) at the origin.

    The value falls off to both sides on a rail. On a wheel, convex towards the rail as well, the radius does.

    Args:
        radius: radius of the arc [m].
        kind: "rail" or "wheel".
        half_width: the profile spans -half_width to half_width [m], or less where it would be steeper than
            STEEPEST_SLOPE.
    """
    half_width = min(half_width, radius * float(np.sin(np.arctan(STEEPEST_SLOPE))))

    def height(y: Array) -> Array:
        return np.asarray(-(y**2) / (radius + np.sqrt(radius**2 - y**2)))  # sqrt(R^2 - y^2) - R, without cancellation

    name = f"arc R{radius * 1e3:g}"
    return _with_flanks(tabulate(height, -half_width, half_width, name=name, kind=kind, source=f"{name} mm"))


def _with_flanks(table: ProfileTable) -> ProfileTable:
    if table.kind == "wheel":
        return table
    low, high = table.domain
    outline = np.vstack([[low, -SIDE_DEPTH], table.outline, [high, -SIDE_DEPTH]])
    return ProfileTable(table.name, table.kind, table.start, table.step, table.coefficients, table.source, outline)
