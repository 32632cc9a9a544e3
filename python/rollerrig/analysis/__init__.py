"""Stability of rolling: modes over speed, critical speeds, limit cycles; and what engineers read off a run.

Case -> [linearise -> modes -> speed map -> critical, stability]   small motions, exact derivatives
     -> [hunting, ramp -> signals]          runs from a disturbance
     -> [limit cycle runs -> limit cycle]   what is left at each speed, stepped up and down
run  -> [wheel_rail_forces, ride -> filters]         wheel forces, Y/Q, wear number, accelerations, as EN 14363 assesses them
"""

from rollerrig.analysis.assessment import Assessment, Row, assess, table
from rollerrig.analysis.critical_speed import (
    CriticalSpeedByDisturbance,
    LinearCriticalSpeed,
    critical_speeds_by_disturbance,
    linear_critical_speed,
    linear_critical_speeds,
)
from rollerrig.analysis.crossings import Crossing, zero_crossings
from rollerrig.analysis.hunting import HuntingRun, HuntingSettings, hunting_run, hunting_table
from rollerrig.analysis.limit_cycle import CyclePoint, Diagram
from rollerrig.analysis.limit_cycle_runs import LimitCycleSettings, limit_cycle_table, limit_cycles
from rollerrig.analysis.linearise import Linearisation, Lineariser, linearise
from rollerrig.analysis.mode_table import stability
from rollerrig.analysis.ramp import RampSettings, end_of_hunting, ramp_run
from rollerrig.analysis.ride import accelerations, ride, weighted_rms
from rollerrig.analysis.signals import final_motion, growth_rate, half_waves
from rollerrig.analysis.wheel_rail_forces import filtered, prudhomme_limit, statistics, wheel_forces

__all__ = [
    "Assessment",
    "CriticalSpeedByDisturbance",
    "Crossing",
    "CyclePoint",
    "Diagram",
    "HuntingRun",
    "HuntingSettings",
    "LimitCycleSettings",
    "LinearCriticalSpeed",
    "Linearisation",
    "Lineariser",
    "RampSettings",
    "Row",
    "accelerations",
    "assess",
    "critical_speeds_by_disturbance",
    "end_of_hunting",
    "filtered",
    "final_motion",
    "growth_rate",
    "half_waves",
    "hunting_run",
    "hunting_table",
    "limit_cycle_table",
    "limit_cycles",
    "linear_critical_speed",
    "linear_critical_speeds",
    "linearise",
    "prudhomme_limit",
    "ramp_run",
    "ride",
    "stability",
    "statistics",
    "table",
    "weighted_rms",
    "wheel_forces",
    "zero_crossings",
]
