"""The paper's two studies: critical speed of a bogie on rollers (figure 7) and traction (figure 8).

plan -> [compute] -> PaperResults -> [checks, text, page] -> report.html, figures, data, summary.json
"""

from rollerrig.studies.paper.compute import PaperResults, compute
from rollerrig.studies.paper.plan import FULL, QUICK, PaperPlan
from rollerrig.studies.paper.write import write_paper

__all__ = ["FULL", "QUICK", "PaperPlan", "PaperResults", "compute", "write_paper"]
