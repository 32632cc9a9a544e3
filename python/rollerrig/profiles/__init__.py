"""Wheel and rail profiles as curves of continuous curvature.

published definitions, measured files -> ProfileTable -> contact geometry
"""

from rollerrig.profiles.registry import CATALOGUE, SHAPES, profile_from_spec
from rollerrig.profiles.table import (
    DEFAULT_STEP,
    STEEPEST_SLOPE,
    ProfileError,
    ProfileKind,
    ProfileTable,
    flange_angle,
    gauge_point,
    tabulate,
)

__all__ = [
    "CATALOGUE",
    "DEFAULT_STEP",
    "SHAPES",
    "STEEPEST_SLOPE",
    "ProfileError",
    "ProfileKind",
    "ProfileTable",
    "flange_angle",
    "gauge_point",
    "profile_from_spec",
    "tabulate",
]
