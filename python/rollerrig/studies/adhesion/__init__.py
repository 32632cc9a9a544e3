"""The same brake or traction test on degraded track and on the dry rig that reproduces it."""

from rollerrig.studies.adhesion.compute import Comparison, compare_adhesion, fidelity, track_case
from rollerrig.studies.adhesion.write import lead, write_adhesion

__all__ = ["Comparison", "compare_adhesion", "fidelity", "lead", "track_case", "write_adhesion"]
