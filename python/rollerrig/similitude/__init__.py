"""Scaled rigs: models of a full-scale case, their results at full scale, and what a real model violates.

Case, strategy -> [similitude] -> Case of the model -> run -> map_back -> results at full scale
"""

from rollerrig.similitude.factors import FACTORS as FACTORS
from rollerrig.similitude.factors import STRATEGIES as STRATEGIES
from rollerrig.similitude.factors import Similitude as Similitude
from rollerrig.similitude.factors import map_back as map_back
from rollerrig.similitude.factors import similitude as similitude
from rollerrig.similitude.scale_case import factors_of as factors_of
from rollerrig.similitude.scale_case import scale_case as scale_case
from rollerrig.similitude.violations import Requirement as Requirement
from rollerrig.similitude.violations import distortion as distortion
from rollerrig.similitude.violations import requirements as requirements
