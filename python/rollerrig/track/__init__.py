"""The track's layout: curvature and cant along the line.

segments as an engineer lists them -> [line] -> piecewise cubics over the distance -> the core's moving frame
"""

from rollerrig.track.curving import equilibrium_speed as equilibrium_speed
from rollerrig.track.curving import highest_speed as highest_speed
from rollerrig.track.curving import limit_of_lateral_force as limit_of_lateral_force
from rollerrig.track.curving import nadal_limit as nadal_limit
from rollerrig.track.curving import plane_acceleration as plane_acceleration
from rollerrig.track.line import Line as Line
from rollerrig.track.line import PiecewiseCubic as PiecewiseCubic
from rollerrig.track.line import Segment as Segment
from rollerrig.track.line import build_line as build_line
from rollerrig.track.line import ramps as ramps
