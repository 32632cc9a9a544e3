"""Stability of rolling: modes over speed, critical speeds, limit cycles.

Case -> [linearise -> modes -> stability]   small motions, exact derivatives
     -> [hunting, ramp -> signals]          runs from a disturbance
"""

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
from rollerrig.analysis.signals import ending, growth_rate, half_waves
from rollerrig.analysis.stability import CriticalSpeed, linear_critical_speed, stability

__all__ = [
    "CriticalSpeed",
    "HuntingRun",
    "HuntingSettings",
    "Linearisation",
    "Lineariser",
    "NonlinearCriticalSpeed",
    "RampSettings",
    "end_of_hunting",
    "ending",
    "growth_rate",
    "half_waves",
    "hunting_run",
    "hunting_runs",
    "hunting_table",
    "linear_critical_speed",
    "linearise",
    "nonlinear_critical_speed",
    "ramp_run",
    "stability",
]
