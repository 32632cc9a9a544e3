"""What a scaled model violates: in lines and as a table.

Case of a model, requirements of similitude -> [model_summary, violations_table]
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from rollerrig.config import Case
from rollerrig.similitude import STRATEGIES, Requirement
from rollerrig.study.report import Table, number

VIOLATION = {
    "name": "of the requirement", "quantity": "of the model", "unit": "of what follows", "required": "for similitude",
    "actual": "of the model", "deviation": "actual over required, less 1; null: nothing of the kind exists at full scale",
    "met": "whether it is met", "effect": "of the violation on results",
}  # fmt: skip
"""Attribute of a requirement -> meaning."""

HEADER = ("requirement", "quantity of the model", "needed", "is", "unit", "deviation", "effect on results")


def deviation(value: float) -> str:
    """A deviation with its sign; what full scale does not have is new."""
    return f"{100 * value:+.3g} %" if math.isfinite(value) else "new"


def model_summary(model: Case, found: Sequence[Requirement]) -> list[str]:
    """The model and its violations, a line each."""
    record = model.similitude
    assert record is not None
    strategy = STRATEGIES[record.strategy]
    kept = ", ".join(record.keep) or "nothing: ideal similitude"
    violated = [one for one in found if not one.met]
    return [
        f"{model.name}: a 1:{record.length:g} model of {record.case}, {strategy.title} (keeps {strategy.keeps}); "
        f"speeds 1:{record.length / record.time:.4g}, times 1:{record.time:.4g}. Not scaled: {kept}.",
        *(f"violated: {one.name} ({deviation(one.deviation)}): {one.effect}" for one in violated),
        *(["All requirements of similitude are met."] if not violated else []),
    ]


def violations_table(found: Sequence[Requirement]) -> Table:
    """All requirements, met or violated."""
    rows = [
        [one.name, one.quantity, number(one.required), number(one.actual), one.unit,
         "met" if one.met else deviation(one.deviation), "" if one.met else one.effect]
        for one in found
    ]  # fmt: skip
    return Table(HEADER, rows, "requirements, met or violated")
