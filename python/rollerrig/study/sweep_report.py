"""The report of a sweep: maps or scatter pictures, tornado, quantiles and Sobol indices of each number.

Dataset and statistics -> [sections_of] -> sections of the page
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import xarray as xr

from rollerrig.plot import sweep as figures
from rollerrig.study.report import Block, Picture, Section, Table, Text
from rollerrig.study.sweep_points import Points
from rollerrig.study.sweep_statistics import Statistics

_INDICES = ("first", "first_confidence", "total", "total_confidence")
MOST_PICTURED = 12
"""Numbers that have pictures of their own; all are in the tables and files."""


def sections_of(data: xr.Dataset, found: Mapping[str, Statistics], points: Points) -> list[Section]:
    """Of the report, but for its ends."""
    rows = [[axis.name.replace("_", " "), axis.key, axis.unit if axis.unit != "1" else "", *_range(points, k)]
            for k, axis in enumerate(points.axes)]  # fmt: skip
    varied = Table(("varied", "key of the case", "unit", "from", "to", "values"), rows)
    how = f"Design: {points.design.kind.replace('_', ' ')}, {len(points)} cases" + (
        f", seed {points.design.seed}." if points.design.samples else "."
    )
    sections = [Section("Overview", [Text(how), varied, *_overview(data, found)])]
    pictured = [name for name, one in found.items() if np.isfinite(one.values).any()]
    sections += [_of_number(data, name, found[name], points) for name in pictured[:MOST_PICTURED]]
    if pictured[MOST_PICTURED:]:
        sections.append(Section("Further numbers", [Text(f"Without pictures: {', '.join(pictured[MOST_PICTURED:])}.")]))
    return sections


def _range(points: Points, k: int) -> list[object]:
    axis, column = points.axes[k], points.columns[k]
    if not axis.is_number:
        return ["", "", len(axis.values)]
    return [min(column), max(column), len(axis.values) or ""]


def _overview(data: xr.Dataset, found: Mapping[str, Statistics]) -> list[Block]:
    rows: list[list[object]] = []
    for name, one in found.items():
        numbers, unit = one.as_dict(), data[name].attrs["units"]
        rows.append([name.replace("_", " "), unit if unit != "1" else "", *(
            "–" if not np.isfinite(numbers[key]) else numbers[key] for key in ("least", "median", "largest")
        )])  # fmt: skip
    return [Table(("number", "unit", "least", "median", "largest"), rows, "Of all finished cases.")]


def _of_number(data: xr.Dataset, name: str, one: Statistics, points: Points) -> Section:
    """Pictures and tables of one number."""
    meaning, title = data[name].attrs["long_name"], name.replace("_", " ")
    blocks: list[Block] = [Text(f"{meaning[:1].upper()}{meaning[1:]}.")]
    if points.design.kind == "grid":
        blocks.append(Picture(f"map_{name}", figures.grid_map(data, name), f"{title} over what is varied."))
    else:
        blocks.append(
            Picture(f"scatter_{name}", figures.scatter(data, name), f"{title} of each case over each varied key.")
        )
    ends = {key: ends for key, ends in one.tornado.items() if np.isfinite(ends).all()}
    if len(ends) > 1:
        what = "lowest and highest value" if not points.design.samples else "lowest and highest fifth of values"
        picture = figures.tornado(ends, data[name].attrs, float(np.nanmean(one.values)))
        blocks.append(Picture(f"tornado_{name}", picture, f"Mean of {title} at the {what} of each varied key."))
    if one.quantiles:
        blocks.append(Table(("of the samples are below", title), list(one.quantiles.items()), "Quantiles."))
    if one.sobol:
        rows = [[key.replace("_", " "), *(float(f"{values[k]:.3g}") for k in _INDICES)]
                for key, values in one.sobol.items()]  # fmt: skip
        blocks.append(
            Table(("varied", "first order", "±", "total", "±"), rows, "Sobol indices with their intervals of 95 %.")
        )
        blocks.append(
            Picture(f"sobol_{name}", figures.sobol_bars(one.sobol), f"Sobol indices of {title}, intervals of 95 %.")
        )
    return Section(title[:1].upper() + title[1:], blocks)
