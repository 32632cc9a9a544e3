"""Stability of rolling: modes over speed, critical speeds, limit cycles; and what engineers read off a run.

Case -> [Lineariser -> modes -> speed map -> critical, stability]   small motions, exact derivatives
     -> [hunting, ramp -> signals]          runs from a disturbance
     -> [limit cycle runs -> limit cycle]   what is left at each speed, stepped up and down
run  -> [wheel_rail_forces, ride -> filters]         wheel forces, Y/Q, wear number, accelerations, as EN 14363 assesses them

Names are loaded when first used, as those of `rollerrig`.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rollerrig.analysis.assessment import Assessment as Assessment
    from rollerrig.analysis.assessment import Row as Row
    from rollerrig.analysis.assessment import accelerations as accelerations
    from rollerrig.analysis.assessment import assess as assess
    from rollerrig.analysis.assessment import table as table
    from rollerrig.analysis.assessment import weighted_rms as weighted_rms
    from rollerrig.analysis.critical_speed import CriticalSpeedByDisturbance as CriticalSpeedByDisturbance
    from rollerrig.analysis.critical_speed import LinearCriticalSpeed as LinearCriticalSpeed
    from rollerrig.analysis.critical_speed import linear_critical_speed as linear_critical_speed
    from rollerrig.analysis.hunting import HuntingRun as HuntingRun
    from rollerrig.analysis.hunting import HuntingSettings as HuntingSettings
    from rollerrig.analysis.hunting import hunting_run as hunting_run
    from rollerrig.analysis.hunting import hunting_table as hunting_table
    from rollerrig.analysis.limit_cycle import CyclePoint as CyclePoint
    from rollerrig.analysis.limit_cycle import Diagram as Diagram
    from rollerrig.analysis.limit_cycle_runs import LimitCycleSettings as LimitCycleSettings
    from rollerrig.analysis.limit_cycle_runs import limit_cycle_table as limit_cycle_table
    from rollerrig.analysis.mode_table import Crossing as Crossing
    from rollerrig.analysis.mode_table import stability as stability
    from rollerrig.analysis.mode_table import zero_crossings as zero_crossings
    from rollerrig.analysis.modes import Linearisation as Linearisation
    from rollerrig.analysis.modes import Lineariser as Lineariser
    from rollerrig.analysis.ramp import RampSettings as RampSettings
    from rollerrig.analysis.ramp import end_of_hunting as end_of_hunting
    from rollerrig.analysis.ramp import ramp_run as ramp_run
    from rollerrig.analysis.signals import final_motion as final_motion
    from rollerrig.analysis.signals import growth_rate as growth_rate
    from rollerrig.analysis.signals import half_waves as half_waves
    from rollerrig.analysis.wheel_rail_forces import filtered as filtered
    from rollerrig.analysis.wheel_rail_forces import prudhomme_limit as prudhomme_limit
    from rollerrig.analysis.wheel_rail_forces import statistics as statistics
    from rollerrig.analysis.wheel_rail_forces import wheel_forces as wheel_forces

_NAMES = {
    "assessment": "Assessment Row accelerations assess table weighted_rms",
    "critical_speed": "CriticalSpeedByDisturbance LinearCriticalSpeed linear_critical_speed",
    "hunting": "HuntingRun HuntingSettings hunting_run hunting_table",
    "limit_cycle": "CyclePoint Diagram",
    "limit_cycle_runs": "LimitCycleSettings limit_cycle_table",
    "mode_table": "Crossing stability zero_crossings",
    "modes": "Linearisation Lineariser",
    "ramp": "RampSettings end_of_hunting ramp_run",
    "signals": "final_motion growth_rate half_waves",
    "wheel_rail_forces": "filtered prudhomme_limit statistics wheel_forces",
}
"""Module -> public names that it defines."""

_HOME = {name: module for module, names in _NAMES.items() for name in names.split()}

__all__ = [*_HOME]


def __getattr__(name: str) -> Any:
    """A public name, from the module that defines it."""
    if name not in _HOME:
        raise AttributeError(f"module 'rollerrig.analysis' has no attribute {name!r}")
    value = getattr(import_module(f"rollerrig.analysis.{_HOME[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    """Public names, for completion."""
    return sorted(__all__)
