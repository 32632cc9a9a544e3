"""Studies that know only the axles under test refuse a train with others."""

from __future__ import annotations

from rollerrig.config.errors import ConfigProblem
from rollerrig.config.schema.case import CaseTables


def simulated_axles(case: CaseTables, study: str) -> list[ConfigProblem]:
    """The problem that a case has axles which are only simulated; none if all axles of its train are under test."""
    axles = case.train.axles
    if axles is None or len(axles.positions) == len(axles.under_test):
        return []
    others = f"{len(axles.positions)} axles, {len(axles.under_test)} of them under test"
    allowed = f"allowed: all axles under test; {study} knows no others. Leave [train.axles] away"
    return [ConfigProblem(case.name, "train.axles", others, allowed)]
