"""What a sweep computes of each case: one file per measure.

To add one: a table in `config/schema/plan.py`, a file here with QUANTITIES and `measure(case, options)`, and a line in _HOME.
"""

from __future__ import annotations

from importlib import import_module
from types import ModuleType

_HOME = {
    "run": "run",
    "stability": "stability",
    "critical_speed": "critical_speed",
    "contact": "contact",
    "adhesion": "adhesion",
    "creep": "creep",
}
"""Kind of a measure in a plan -> its module here: QUANTITIES, name -> (unit, meaning), and `measure`."""

KINDS = tuple(_HOME)


def module_of(kind: str) -> ModuleType:
    """The module of a measure, imported when first asked for."""
    return import_module(f"rollerrig.study.measures.{_HOME[kind]}")


def quantities_of(kind: str) -> dict[str, tuple[str, str]]:
    """Name -> unit and meaning of all numbers of a measure."""
    return dict(module_of(kind).QUANTITIES)
