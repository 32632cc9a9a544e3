"""An envelope map as tables: a row per run, the largest torque that is reproduced, closed forms against runs.

Dataset of `envelope` -> [tables] -> rows of envelope.csv, tables of the report
"""

from __future__ import annotations

import math

import numpy as np
import xarray as xr

from rollerrig.analysis.envelope_borders import Border, borders, slides
from rollerrig.analysis.run_limits import NUMBERS, REGIONS
from rollerrig.study.envelope_points import torque_text
from rollerrig.study.report import Table
from rollerrig.wording import number


def run_rows(found: xr.Dataset) -> list[list[object]]:
    """envelope.csv: a row per run, header first."""
    texts, places = ("region", "limits", "status"), ("load", "axle_load", "torque", "adhesion")
    rows: list[list[object]] = [["load", "axle_load_n", "torque_nm", "adhesion", *texts, *NUMBERS]]
    for load, adhesion, torque in np.argwhere(found["region"].to_numpy() != ""):
        here = found.isel(load=load, adhesion=adhesion, torque=torque)
        rows.append([*(float(here[name]) for name in places), *(str(here[name].item()) for name in texts),
                     *(float(here[name]) for name in NUMBERS)])  # fmt: skip
    return rows


def reach_table(found: xr.Dataset) -> Table:
    """Largest reproduced torque over adhesion, a column per side and load."""
    rows = borders(found)
    columns = list(dict.fromkeys((row.side, row.load) for row in rows))
    cells = {(row.side, row.load, row.adhesion): f"{torque_text(row.reached)}; {REGIONS.get(row.limit, 'the whole map')}"
             for row in rows}  # fmt: skip
    table = [
        [number(adhesion), *(cells.get((side, load, adhesion), "–") for side, load in columns)]
        for adhesion in sorted({row.adhesion for row in rows})
    ]
    names = dict(zip(found["load"].to_numpy().tolist(), 1e-3 * found["axle_load"].to_numpy(), strict=True))
    header = ("adhesion", *(f"{side}, axle load {names[load]:.4g} kN" for side, load in columns))
    return Table(
        header, table, "largest torque on an axle up to which every run reproduces the rail, and the limit of the next"
    )


def deviations_table(found: xr.Dataset) -> Table:
    """Closed form against the two runs on either side of each border."""
    kinds = [(REGIONS.get(row.limit, ""), row) for row in borders(found)] + [
        ("slide, (V2)", row) for row in slides(found)
    ]
    rows = [
        [row.side, row.load, row.adhesion, name, f"{torque_text(row.reached)} … {torque_text(row.beyond)}", _compared(row),
         torque_text(row.predicted), "✔" if row.agrees else "✘"]
        for name, row in kinds if row.agrees is not None
    ]  # fmt: skip
    header = (
        "side",
        "load",
        "adhesion",
        "border of",
        "runs on either side",
        "left on the axles",
        "closed form",
        "agree",
    )
    return Table(header, rows)


def _compared(row: Border) -> str:
    """The torque left in the two runs, where that is what is compared."""
    return (
        ""
        if row.compared == (row.reached, row.beyond)
        else " … ".join(torque_text(t) if math.isfinite(t) else "–" for t in row.compared)
    )
