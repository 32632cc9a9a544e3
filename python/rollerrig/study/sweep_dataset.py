"""The numbers of all cases of a sweep as one Dataset, and as rows.

records of the cases -> [sweep_dataset] -> Dataset: a grid over its varied keys, other designs over `sample`
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr

from rollerrig import __version__
from rollerrig.config import WholePlan
from rollerrig.results import variable
from rollerrig.study.sweep_points import Axis, Points

FAILED = "failed"
SAMPLE = "sample"
Record = dict[str, Any]
"""Of a case: its changes, its numbers, why it failed."""


def sweep_dataset(
    whole: WholePlan, points: Points, records: Sequence[Record | None], units: Mapping[str, tuple[str, str]]
) -> xr.Dataset:
    """All cases; numbers of those that failed or were not reached are NaN.

    Args:
        whole: the plan.
        points: its cases.
        records: one per case; None: not reached.
        units: name of each number -> unit and meaning.

    Returns:
        The varied keys as coordinates in SI, each number with its unit, `failed` with the reason of each failed case; attributes
        cases, finished, failed, plan, case, design.
    """
    grid = points.design.kind == "grid"
    names = [axis.name for axis in points.axes]
    dims = tuple(names) if grid else (SAMPLE,)
    shape = points.shape if grid else (len(points),)
    coordinates: dict[str, Any] = {}
    for axis, column in zip(points.axes, points.columns, strict=True):
        values = list(axis.values) if grid else column
        coordinates[axis.name] = _coordinate(axis, values, axis.name if grid else SAMPLE)
    variables: dict[str, Any] = {}
    for name, (unit, meaning) in units.items():
        values = [math.nan if one is None else one["numbers"].get(name, math.nan) for one in records]
        variables[name] = variable(dims, np.array(values, dtype=np.float64).reshape(shape), unit, meaning)
    reasons = ["" if one is None else one[FAILED] for one in records]
    variables[FAILED] = variable(dims, np.array(reasons, dtype=object).reshape(shape), "", "why a case failed")
    failed = sum(bool(reason) for reason in reasons)
    done = sum(one is not None for one in records)
    return xr.Dataset(
        variables,
        coordinates,
        {
            "title": f"Sweep {whole.plan.name}",
            "plan": whole.plan.name,
            "case": whole.case.name,
            "design": points.design.kind,
            "cases": len(points),
            "finished": done - failed,
            "failed": failed,
            "config_toml": whole.case.to_toml(),
            "rollerrig_version": __version__,
        },
    )


def _coordinate(axis: Axis, values: Sequence[Any], dim: str) -> Any:
    kept = np.array(values, dtype=np.float64) if axis.is_number else np.array([_text(v) for v in values], dtype=object)
    return variable(dim, kept, axis.unit, axis.key)


def _text(value: Any) -> str:
    return ("true" if value else "false") if isinstance(value, bool) else str(value)


def sweep_rows(data: xr.Dataset, points: Points) -> list[list[object]]:
    """A row per case, header first: values of the varied keys in SI, numbers, reason of failure."""
    numbers = [name for name in map(str, data.data_vars) if name != FAILED]
    columns = [
        list(column) if axis.is_number else [_text(v) for v in column]
        for axis, column in zip(points.axes, points.columns, strict=True)
    ]
    columns += [data[name].to_numpy().ravel().tolist() for name in (*numbers, FAILED)]
    header: list[object] = [
        *(f"{axis.name} [{axis.unit}]" if axis.unit not in ("", "1") else axis.name for axis in points.axes),
        *(f"{name} [{u}]" if (u := data[name].attrs["units"]) not in ("", "1") else name for name in numbers),
        FAILED,
    ]
    return [header, *map(list, zip(*columns, strict=True))]
