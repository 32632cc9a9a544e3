"""Flat and circular profiles: not real ones, but those with closed-form answers."""

from __future__ import annotations

import numpy as np

from .errors import ProfileError
from .table import STEEPEST_SLOPE, FloatArray, ProfileKind, ProfileTable, tabulate

SIDE_DEPTH = 40e-3  # [m] of the vertical flanks beside a rail head, so that it has a gauge


def cylinder(kind: ProfileKind = "rail", half_width: float = 36e-3) -> ProfileTable:
    """Constant profile: a flat rail head, a cylindrical roller or a cylindrical wheel.

    Args:
        kind: "rail" or "wheel"; a rail has vertical flanks at its ends, where its gauge is taken.
        half_width: the profile spans -half_width to half_width [m].
    """
    if not 0 < half_width <= 0.5:
        raise ProfileError(f"cylinder: half_width: {half_width} m; allowed above 0 and up to 0.5 m")
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
    if not (np.isfinite(radius) and radius > 0):
        raise ProfileError(f"arc: radius: {radius} m; it must be positive; for a flat profile use kind = 'cylinder'")
    if not 0 < half_width <= 0.5:
        raise ProfileError(f"arc: half_width: {half_width} m; allowed above 0 and up to 0.5 m")
    half_width = min(half_width, radius * float(np.sin(np.arctan(STEEPEST_SLOPE))))

    def height(y: FloatArray) -> FloatArray:
        return np.asarray(-(y**2) / (radius + np.sqrt(radius**2 - y**2)))  # sqrt(R^2 - y^2) - R, without cancellation

    name = f"arc R{radius * 1e3:g}"
    return _with_flanks(tabulate(height, -half_width, half_width, name=name, kind=kind, source=f"{name} mm"))


def _with_flanks(table: ProfileTable) -> ProfileTable:
    if table.kind == "wheel":
        return table
    low, high = table.domain
    outline = np.vstack([[low, -SIDE_DEPTH], table.outline, [high, -SIDE_DEPTH]])
    return ProfileTable(table.name, table.kind, table.start, table.step, table.coefficients, table.source, outline)
