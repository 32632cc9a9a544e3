"""UIC60 / 60E1 rail head: tangent-continuous arcs R300 - R80 - R13, sides 1:20, at any inclination.

    drawing (upright, half a head) -> mirrored -> turned about the running direction -> highest point to (0, 0)

Signs   abscissa outward (away from the track centre), height upward; inclination positive leans the head inward.
Source  EN 13674-1 profile 60E1; the UIC60 of the Manchester contact benchmark has slightly other junctions.
Units   the drawing is in millimetres, what leaves this file is in metres.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from .errors import ProfileError
from .table import DEFAULT_STEP, STEEPEST_SLOPE, FloatArray, ProfileTable, tabulate

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

    def point(self, angle: float | FloatArray) -> FloatArray:
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


def head_height(arcs: list[Arc], y_mm: FloatArray) -> FloatArray:
    """Height [mm] of the head over the abscissa [mm]; NaN beyond the arcs."""
    y_mm = np.asarray(y_mm, dtype=np.float64)
    height = np.full(y_mm.shape, np.nan)
    for arc in arcs:
        inside = (y_mm >= arc.point(arc.start)[0]) & (y_mm <= arc.point(arc.end)[0])
        height[inside] = arc.z + np.sqrt(arc.radius**2 - (y_mm[inside] - arc.y) ** 2)
    return height


def outline(arcs: list[Arc], points_per_arc: int = 500) -> FloatArray:
    """Points [m] along the head from the foot of the gauge side to that of the field side; shape (n, 2)."""
    curve = np.concatenate(
        [arc.point(np.linspace(arc.start, arc.end, points_per_arc + 1)).T[(k > 0) :] for k, arc in enumerate(arcs)]
    )

    def side(end: FloatArray, angle: float) -> FloatArray:  # the straight flank, down to SIDE_BOTTOM
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
    if variant not in JUNCTIONS:
        raise ProfileError(f"uic60: variant: {variant!r} is not one of {', '.join(JUNCTIONS)}")
    if not abs(inclination) <= 0.2:
        raise ProfileError(f"uic60: inclination: {inclination}; allowed -0.2 to 0.2; 1:40 is written 0.025")
    if not 0 < step <= 1e-3:
        raise ProfileError(f"uic60: step: {step} m; allowed above 0 and up to 0.001 m")
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
