"""Conical wheel: the profile of the textbooks, and of closed-form tests."""

from __future__ import annotations

from .errors import ProfileError
from .table import ProfileTable, tabulate


def cone(conicity: float, half_width: float = 60e-3) -> ProfileTable:
    """Wheel whose radius falls off linearly outward, without a flange.

        value(S) = -conicity S

    Args:
        conicity: [-], e.g. 0.025 for 1:40; the wheel is larger towards the flange side where positive.
        half_width: the profile spans -half_width <= S <= half_width [m].

    Returns:
        The table; exact, since a spline holds a line.
    """
    if not abs(conicity) <= 1:
        raise ProfileError(f"cone: conicity: {conicity}; allowed -1 to 1; 1:40 is written 0.025")
    if not 0 < half_width <= 0.5:
        raise ProfileError(f"cone: half_width: {half_width} m; allowed above 0 and up to 0.5 m")
    return tabulate(
        lambda s: -conicity * s,
        -half_width,
        half_width,
        name=f"cone {conicity:g}",
        kind="wheel",
        source=f"cone of conicity {conicity:g}",
    )
