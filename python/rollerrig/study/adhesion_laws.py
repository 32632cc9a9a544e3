"""What the creep law changes: the same test on track and rig with each of the laws, beside the one of the case.

Case of a rig -> [law_cases] -> cases by name -> ensembles -> [law_numbers] -> distance and ventings by law, table of the report

The friction of the rail is the same in all; the laws differ in how the force rises to it with slip.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from rollerrig.analysis.slide_statistics import TestRecord
from rollerrig.config import Case
from rollerrig.study.adhesion_variants import track_case
from rollerrig.study.ensemble import Estimate, distances, estimate, measure, relative
from rollerrig.study.quantities import Numbers, Quantity
from rollerrig.study.report import Table
from rollerrig.wording import number

LAWS: Mapping[str, dict[str, Any]] = {
    "kalker_saturated": {"kind": "kalker_saturated"},
    "fastsim": {"kind": "fastsim"},
    "table": {"kind": "table"},
    "polach": {"kind": "polach", "k_A": 1.0, "k_S": 1.0},
}
TITLES = {
    "kalker_saturated": "the paper's law",
    "fastsim": "FASTSIM",
    "table": "exact theory, table",
    "polach": "Polach",
}
SUPPORTS = ("track", "rig")

LAW_QUANTITIES = (
    Quantity("creep_laws.*.*.mean", "by kind of the creep law: distance [m] and ventings on track and rig; mean of its starts"),
    Quantity("creep_laws.*.*.standard_error", "of it"),
    Quantity("creep_laws.*.*_difference.mean", "rig over track, less 1", "1"),
    Quantity("creep_laws.*.*_difference.standard_error", "of it", "1"),
)  # fmt: skip


def law_names(case: Case) -> tuple[str, ...]:
    """Names of the ensembles beside those of the case's own law."""
    own = case.contact.creep.kind
    return tuple(_name(kind, support) for kind in LAWS if kind != own for support in SUPPORTS)


def law_case(case: Case, name: str) -> Case | None:
    """The case of one of `law_names`; None: another name."""
    for kind, law in LAWS.items():
        if name in (found := [_name(kind, support) for support in SUPPORTS]):
            changed = case.with_changes({"contact.creep": law})
            return track_case(changed) if name == found[0] else changed
    return None


def law_numbers(case: Case, records: Mapping[str, Sequence[TestRecord]]) -> dict[str, Any]:
    """By kind of the law, of those whose ensembles on track and rig are there; empty where only the case's own is."""
    own, found = case.contact.creep.kind, {}
    for kind in dict.fromkeys((own, *LAWS)):
        names = SUPPORTS if kind == own else [_name(kind, support) for support in SUPPORTS]
        track, rig = (records.get(name, ()) for name in names)
        if track and rig:
            on_track, on_rig = (estimate(values) for values in distances((track, rig)))
            vented = measure(track, "dump_cycles"), measure(rig, "dump_cycles")
            found[kind] = {**_pair("distance_m", on_track, on_rig), **_pair("dump_cycles", *vented)}
    return found if len(found) > 1 else {}


def law_table(numbers: Numbers) -> Table:
    """A line for each law."""
    header = (
        "creep law",
        "distance on track [m]",
        "on the rig [m]",
        "difference",
        "ventings on track",
        "on the rig",
        "difference",
    )
    rows = [
        (TITLES.get(kind, kind), *(cell for key in ("distance_m", "dump_cycles") for cell in _cells(one, key)))
        for kind, one in numbers.items()
    ]
    return Table(header, rows, "The same test with each creep law; the first is that of the case. ± standard error.")


def _name(kind: str, support: str) -> str:
    return f"{support}, creep law {kind}"


def _pair(key: str, track: Estimate, rig: Estimate) -> dict[str, Any]:
    values = {f"{key}_track": track, f"{key}_rig": rig, f"{key}_difference": relative(rig, track)}
    return {name: one.as_dict() for name, one in values.items()}


def _cells(one: Numbers, key: str) -> tuple[str, str, str]:
    found = [_text(one[f"{key}_{where}"], 1.0, 4) for where in SUPPORTS]
    difference = _text(one[f"{key}_difference"], 100.0, 2)
    return found[0], found[1], "–" if difference == "–" else f"{difference} %"


def _text(one: Numbers, factor: float, digits: int) -> str:
    if one["mean"] is None or one["mean"] != one["mean"]:
        return "–"
    text, error = number(factor * one["mean"], digits), one["standard_error"]
    return text if error is None or error != error else f"{text} ± {number(factor * error, 1)}"
