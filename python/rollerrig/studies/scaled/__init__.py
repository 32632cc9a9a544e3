"""The same test on a full-scale rig and on a scaled one, mapped back."""

from rollerrig.studies.scaled.compute import ScaledComparison, compare_scaled, numbers, plan_scaled
from rollerrig.studies.scaled.words import lead
from rollerrig.studies.scaled.write import verdict, write_scaled

__all__ = ["ScaledComparison", "compare_scaled", "lead", "numbers", "plan_scaled", "verdict", "write_scaled"]
