"""Scaled rigs: models of a full-scale case, their results at full scale, and what a real model violates.

Case, strategy -> [similitude] -> Case of the model -> run -> map_back -> results at full scale
"""

from rollerrig.similitude.factors import FACTORS, STRATEGIES, Similitude, map_back, similitude
from rollerrig.similitude.scale_case import factors_of, scale_case
from rollerrig.similitude.violations import ContactAtRest, Requirement, contact_at_rest, distortion, requirements

__all__ = [
    "FACTORS",
    "STRATEGIES",
    "ContactAtRest",
    "Requirement",
    "Similitude",
    "contact_at_rest",
    "distortion",
    "factors_of",
    "map_back",
    "requirements",
    "scale_case",
    "similitude",
]
