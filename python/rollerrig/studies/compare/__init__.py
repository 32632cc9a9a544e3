"""What does the rig change? One vehicle on several supports, side by side.

vehicle, supports -> [cases] -> [compute] -> CompareResults -> [page, figures, write] -> one report, tables, summary.json
"""

from rollerrig.studies.compare.cases import compared_cases
from rollerrig.studies.compare.compute import ComparePlan, CompareResults, compute
from rollerrig.studies.compare.write import write_comparison

__all__ = ["ComparePlan", "CompareResults", "compared_cases", "compute", "write_comparison"]
