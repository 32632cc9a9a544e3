"""Statistics of the numbers of a sweep: range, quantiles, which key they follow, Sobol indices.

Dataset of a sweep -> [statistics] -> Statistics of each number

A tornado compares means at both ends of what is varied: of a grid at its lowest and highest value, of samples in the lowest and
highest fifth of them. Sobol indices are those of SALib (Saltelli 2010, Jansen), for samples of the design `saltelli`; a sample of
which one case failed is left out as a whole.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from rollerrig.study.sweep_dataset import FAILED
from rollerrig.study.sweep_points import Points

Array = NDArray[np.float64]
QUANTILES = (0.05, 0.25, 0.5, 0.75, 0.95)
FIFTH = 0.2
LEAST_SAMPLES = 8
"""Fewer whole samples give no Sobol index."""


@dataclass(frozen=True)
class Statistics:
    """Of one number.

    Attributes:
        values: of all cases in their order; NaN where there is none.
        tornado: varied key -> mean at its low and at its high end.
        quantiles: of samples, each equally likely; empty for a grid or list.
        sobol: varied key -> first, first_confidence, total, total_confidence.
    """

    values: Array
    tornado: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    quantiles: Mapping[str, float] = field(default_factory=dict)
    sobol: Mapping[str, Mapping[str, float]] = field(default_factory=dict)

    def as_dict(self) -> dict[str, Any]:
        """For summary.json."""
        known = self.values[np.isfinite(self.values)]
        least, median, most = (float(f(known)) if known.size else math.nan for f in (np.min, np.median, np.max))
        ends = {key: {"low": low, "high": high} for key, (low, high) in self.tornado.items()}
        found: dict[str, Any] = {"least": least, "median": median, "largest": most, "tornado": ends}
        if self.quantiles:
            found["quantiles"] = dict(self.quantiles)
        if self.sobol:
            found["sobol"] = {key: dict(one) for key, one in self.sobol.items()}
        return found


def statistics(data: xr.Dataset, points: Points) -> dict[str, Statistics]:
    """Statistics of every number of a sweep."""
    columns = {
        axis.name: np.asarray(column, dtype=np.float64)
        for axis, column in zip(points.axes, points.columns, strict=True)
        if axis.is_number
    }
    found = {}
    for name in (str(name) for name in data.data_vars if name != FAILED):
        values = data[name].to_numpy().ravel()
        sampled = points.design.kind not in ("grid", "list")
        known = values[np.isfinite(values)]
        quantiles = (
            {f"{100 * q:g} %": float(np.quantile(known, q)) for q in QUANTILES} if sampled and known.size else {}
        )
        tornado = {key: _ends(column, values, sampled=sampled) for key, column in columns.items()}
        sobol = sobol_indices(values, [axis.name for axis in points.axes]) if points.design.kind == "saltelli" else {}
        found[name] = Statistics(values, tornado, quantiles, sobol)
    return found


def _ends(column: Array, values: Array, *, sampled: bool) -> tuple[float, float]:
    """Mean of a number where a varied key is low, and where it is high."""
    known = np.isfinite(values)
    if not known.any():
        return math.nan, math.nan
    low, high = np.quantile(column, (FIFTH, 1.0 - FIFTH)) if sampled else (column.min(), column.max())
    lower, upper = known & (column <= low), known & (column >= high)
    return tuple(float(values[part].mean()) if part.any() else math.nan for part in (lower, upper))  # type: ignore[return-value]


def sobol_indices(values: Array, names: list[str], seed: int = 1) -> dict[str, dict[str, float]]:
    """First-order and total Sobol indices with half of their intervals of 95 %.

    Args:
        values: of the cases of a design `saltelli`, in its order, shape (samples * (names + 2),); NaN where one failed.
        names: of what is varied.
        seed: of the bootstrap.

    Returns:
        Name -> first, first_confidence, total, total_confidence; nothing where SALib is not installed, the number does not vary,
        or fewer than LEAST_SAMPLES samples are whole.
    """
    try:
        from SALib.analyze import sobol
    except ImportError:
        return {}
    blocks = values.reshape(-1, len(names) + 2)
    whole = blocks[np.isfinite(blocks).all(axis=1)]
    if len(whole) < LEAST_SAMPLES or not np.ptp(whole) > 0.0:
        return {}
    problem = {"num_vars": len(names), "names": names, "bounds": [[0.0, 1.0]] * len(names)}
    found = sobol.analyze(problem, whole.ravel(), calc_second_order=False, seed=seed)
    keys = {"first": "S1", "first_confidence": "S1_conf", "total": "ST", "total_confidence": "ST_conf"}
    return {name: {key: float(found[own][k]) for key, own in keys.items()} for k, name in enumerate(names)}
