"""Where a rig can reproduce a degraded rail at all, and what limits it: regions over axle torque, adhesion and load."""

from rollerrig.studies.envelope.compute import envelope, run_plan
from rollerrig.studies.envelope.plan import Plan, make_plan

__all__ = ["Plan", "envelope", "make_plan", "run_plan"]
