"""Wheel and rail profiles as curves of continuous curvature.

published definitions, measured files -> ProfileTable -> contact geometry
"""

from rollerrig.profiles.registry import SHAPES as SHAPES
from rollerrig.profiles.registry import profile_from_spec as profile_from_spec
from rollerrig.profiles.table import STEEPEST_SLOPE as STEEPEST_SLOPE
from rollerrig.profiles.table import ProfileError as ProfileError
from rollerrig.profiles.table import ProfileKind as ProfileKind
from rollerrig.profiles.table import ProfileTable as ProfileTable
from rollerrig.profiles.table import flange_angle as flange_angle
from rollerrig.profiles.table import gauge_point as gauge_point
from rollerrig.profiles.table import tabulate as tabulate
