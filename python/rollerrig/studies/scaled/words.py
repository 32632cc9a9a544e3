"""What a scaled rig violates, in lines and in a table."""

from __future__ import annotations

from collections.abc import Sequence

from rollerrig.config import Case
from rollerrig.report import number
from rollerrig.similitude import STRATEGIES, Requirement

HEADER = ("requirement", "quantity of the model", "needed", "is", "unit", "deviation", "what it does to results")


def lead(model: Case, found: Sequence[Requirement]) -> str:
    """The model and its violations in a few lines."""
    record = model.similitude
    assert record is not None
    strategy = STRATEGIES[record.strategy]
    kept = ", ".join(record.keep) or "nothing: ideal similitude"
    lines = [
        f"{model.name}: a 1:{record.length:g} model of {record.case}, {strategy.title} (keeps {strategy.keeps}); "
        f"speeds 1:{record.length / record.time:.4g}, times 1:{record.time:.4g}. Not scaled: {kept}."
    ]
    violated = [one for one in found if not one.met]
    lines += [f"violated: {one.name} ({percent(one.deviation)}): {one.effect}" for one in violated]
    if not violated:
        lines.append("All requirements of similitude are met.")
    return "\n".join(lines)


def percent(deviation: float) -> str:
    """A deviation with its sign; what full scale does not have is new."""
    return f"{100 * deviation:+.3g} %" if abs(deviation) < float("inf") else "new"


def rows(found: Sequence[Requirement]) -> list[list[object]]:
    """Rows of a table under HEADER."""
    return [
        [
            one.name,
            one.quantity,
            number(one.required),
            number(one.actual),
            one.unit,
            "met" if one.met else percent(one.deviation),
            "" if one.met else one.effect,
        ]
        for one in found
    ]
