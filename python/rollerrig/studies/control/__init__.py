"""Comparison of controllers of the roller drives: what breaks first, and where the loop begins to ring."""

from rollerrig.studies.control.compute import Study, chosen_families, compare_controllers, ranking, study_case
from rollerrig.studies.control.families import FAMILIES, Family
from rollerrig.studies.control.write import lead, write_control

__all__ = [
    "FAMILIES",
    "Family",
    "Study",
    "chosen_families",
    "compare_controllers",
    "lead",
    "ranking",
    "study_case",
    "write_control",
]
