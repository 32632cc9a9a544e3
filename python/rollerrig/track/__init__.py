"""The track's layout: curvature and cant along the line.

segments as an engineer lists them -> [line] -> piecewise cubics over the distance -> the core's moving frame
"""

from rollerrig.track.curving import (
    equilibrium_speed,
    highest_speed,
    limit_of_lateral_force,
    nadal_limit,
    plane_acceleration,
)
from rollerrig.track.line import Line, PiecewiseCubic, Segment, build_line, ramps

__all__ = [
    "Line",
    "PiecewiseCubic",
    "Segment",
    "build_line",
    "equilibrium_speed",
    "highest_speed",
    "limit_of_lateral_force",
    "nadal_limit",
    "plane_acceleration",
    "ramps",
]
