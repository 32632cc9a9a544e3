"""How far the nonlinear critical speed depends on the model of normal contact, and on the rule by which patches merge.

cases by support -> [cases with each model -> runs from a disturbance, bracketed] -> numbers, table

The linear critical speed is that of the smooth piece of the profiles around the centre, where the merging rule hardly acts; a
motion of millimetres crosses the places where patches come and go, so the nonlinear one depends on the rule from its first step.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from rollerrig.analysis import CriticalSpeedByDisturbance
from rollerrig.config import Case
from rollerrig.study.interval import Interval
from rollerrig.study.quantities import Quantity
from rollerrig.study.report import Table

_PAPER = {"contact.creep": "kalker_saturated"}
OTHERS: Mapping[str, Mapping[str, object]] = {
    "strips": {"contact.normal": "strips", **_PAPER},
    "strips, table": {"contact.normal": "strips", "contact.creep": "table"},
}
"""Models beside `hertz` with the paper's creep law: name -> changes."""

PREFIX = "contact model"


def contact_models(criteria: Sequence[float]) -> dict[str, dict[str, object]]:
    """Name of each model -> changes to a case: `hertz` with each merging criterion, then OTHERS."""
    hertz: dict[str, dict[str, object]] = {
        f"hertz, {value:g}": {"contact.normal": {"kind": "hertz", "merging_criterion": value}, **_PAPER}
        for value in criteria
    }
    return hertz | {name: dict(changes) for name, changes in OTHERS.items()}


def sensitivity_cases(supports: Mapping[str, Case], criteria: Sequence[float]) -> dict[str, Case]:
    """Label of a run -> case: each support with each model.

    Args:
        supports: label of the support -> case.
        criteria: merging criteria.
    """
    return {
        _label(on, model): case.with_changes(changes)
        for on, case in supports.items()
        for model, changes in contact_models(criteria).items()
    }


def _label(on: str, model: str) -> str:
    return f"{PREFIX} {on}, {model}"


def _place(label: str) -> tuple[str, str]:
    """Support and model of a label."""
    on, _, model = label.removeprefix(f"{PREFIX} ").partition(", ")
    return on, model


Found = Mapping[str, CriticalSpeedByDisturbance]
"""Label of `sensitivity_cases` -> critical speed by disturbance; those that Ctrl-C cut off are missing."""


def sensitivity_quantities(prefix: str) -> list[Quantity]:
    """What is reported below a key: support, model, both ends of the bracket."""
    return [
        Quantity(f"{prefix}.*.*.decays_kmh", "per support and contact model: highest speed at which it decays", "km/h"),
        Quantity(f"{prefix}.*.*.persists_kmh", "lowest speed at which the motion persists", "km/h"),
    ]  # fmt: skip


def sensitivity_numbers(found: Found) -> dict[str, Any]:
    """Support -> model -> both ends of the bracket [km/h]."""
    numbers: dict[str, Any] = {}
    for label, one in found.items():
        on, model = _place(label)
        numbers.setdefault(on, {})[model] = {"decays_kmh": 3.6 * one.decays, "persists_kmh": 3.6 * one.persists}
    return numbers


def sensitivity_table(found: Found) -> Table:
    """A row per model, a column per support [km/h]."""
    offset = next(iter(found.values())).disturbance
    caption = (
        "Critical speed by disturbance with each model of normal contact: from where the motion decays to where it persists, "
        f"after {1e3 * offset:g} mm. The merging criterion acts on it throughout: the motion crosses the places where patches "
        "come and go."
    )
    supports = list(dict.fromkeys(_place(label)[0] for label in found))
    rows = []
    for model in dict.fromkeys(_place(label)[1] for label in found):
        normal, _, other = model.partition(", ")
        hertz = normal == "hertz"
        cells = [
            Interval.of_bracket(found[label]).text("km/h", 1)
            if (label := _label(on, model)) in found
            else "not computed"
            for on in supports
        ]
        law = other if other and not hertz else "kalker_saturated"
        rows.append([normal, other if hertz else "–", law.replace("_", " "), *cells])
    return Table(("normal", "merging criterion", "creep", *(f"on {on}" for on in supports)), rows, caption)
