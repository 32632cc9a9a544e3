"""A scaled model as texts and tables: what it violates, its factors, its contact at rest, speeds beside full scale."""

from __future__ import annotations

import math
from collections.abc import Sequence

import xarray as xr

from rollerrig.analysis.scaled_model import at_times_of
from rollerrig.config import Case
from rollerrig.similitude import FACTORS, STRATEGIES, ContactAtRest, Requirement, factors_of
from rollerrig.study.report import Table
from rollerrig.wording import number, percent

VIOLATION = {
    "name": "of the requirement", "quantity": "of the model", "unit": "of what follows", "required": "for similitude",
    "actual": "of the model", "deviation": "actual over required, less 1; null: nothing of the kind exists at full scale",
    "met": "whether it is met", "effect": "of the violation on results",
}  # fmt: skip
"""Attribute of a requirement -> meaning."""

HEADER = ("requirement", "quantity of the model", "needed", "is", "unit", "deviation", "effect on results")


def deviation(value: float) -> str:
    """A deviation with its sign; what full scale does not have is new."""
    return percent(value, 3, signed=True) if math.isfinite(value) else "new"


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


def factors_table(model: Case) -> Table:
    """Scale factors of every quantity."""
    factors, record = factors_of(model), model.similitude
    assert record is not None
    table = [[name, number(factors.factor(unit)), unit] for name, unit in FACTORS]
    return Table(("quantity", "full scale over model", "unit"), table, STRATEGIES[record.strategy].title)


def contact_at_rest_table(model: Case, at_full_scale: ContactAtRest, own: ContactAtRest) -> Table:
    """The contact of the first wheel of both, and what the model's stands for at full scale.

    Args:
        model: case of the model.
        at_full_scale: of the full-scale case.
        own: of the model, at its own scale.
    """
    factors = factors_of(model)
    lines = (
        ("wheel load [N]", 1.0, "wheel_load", factors.force),
        ("semi-axis of the largest patch [mm]", 1e3, "semi_axis", factors.length),
        ("largest pressure [MPa]", 1e-6, "pressure", factors.pressure),
        ("semi-axis over the roller's radius [%]", 100.0, "roller_share", 1.0),
    )
    rows = []
    for name, unit, key, factor in lines:
        a, b = (unit * getattr(contact, key) for contact in (at_full_scale, own))
        rows.append([name, number(a), number(b), number(b * factor), deviation(b * factor / a - 1.0)])
    header = ("first wheel, steady running", "full scale", "model", "model, mapped back", "deviation")
    return Table(header, rows, "where several patches share a load, sizes follow it less closely than one patch would")


def axle_rows(full: xr.Dataset, mapped: xr.Dataset) -> list[list[object]]:
    """axles.csv: speeds at full scale, the model's at the same times; header first."""
    other = at_times_of(full, mapped)
    run = full.isel(time=slice(0, other.sizes["time"]))
    columns = {
        "time_s": run["time"],
        "train_speed_full_mps": run["train_speed"],
        "train_speed_model_mps": other["train_speed"],
    }
    for axle in run["axle"].to_numpy():
        for label, one in (("full", run), ("model", other)):
            columns[f"axle_speed_{axle}_{label}_rad_per_s"] = one["axle_speed"].sel(axle=axle)
    values = [column.to_numpy().tolist() for column in columns.values()]
    return [list(columns), *(list(row) for row in zip(*values, strict=True))]
