"""Stability of rolling: modes over speed, critical speeds, limit cycles; and what engineers read off a run.

Case -> [linearise -> modes -> stability]   small motions, exact derivatives
     -> [hunting, ramp -> signals]          runs from a disturbance
run  -> [readings, ride -> filters]         wheel forces, Y/Q, wear number, accelerations, as EN 14363 assesses them
"""

from rollerrig.analysis.assessment import Assessment, Row, assess, table
from rollerrig.analysis.hunting import (
    HuntingRun,
    HuntingSettings,
    NonlinearCriticalSpeed,
    hunting_run,
    hunting_runs,
    hunting_table,
    nonlinear_critical_speed,
)
from rollerrig.analysis.linearise import Linearisation, Lineariser, linearise
from rollerrig.analysis.ramp import RampSettings, end_of_hunting, ramp_run
from rollerrig.analysis.readings import filtered, nadal_limit, prudhomme_limit, readings, statistics
from rollerrig.analysis.ride import accelerations, ride, weighted_rms
from rollerrig.analysis.signals import ending, growth_rate, half_waves
from rollerrig.analysis.stability import CriticalSpeed, linear_critical_speed, stability

__all__ = [
    "Assessment",
    "CriticalSpeed",
    "HuntingRun",
    "HuntingSettings",
    "Linearisation",
    "Lineariser",
    "NonlinearCriticalSpeed",
    "RampSettings",
    "Row",
    "accelerations",
    "assess",
    "end_of_hunting",
    "ending",
    "filtered",
    "growth_rate",
    "half_waves",
    "hunting_run",
    "hunting_runs",
    "hunting_table",
    "linear_critical_speed",
    "linearise",
    "nadal_limit",
    "nonlinear_critical_speed",
    "prudhomme_limit",
    "ramp_run",
    "readings",
    "ride",
    "stability",
    "statistics",
    "table",
    "weighted_rms",
]
