"""How far the rig reaches on each rail of an envelope map, and whether the closed forms agree.

Dataset of `envelope` -> [borders] -> one row per side, load and adhesion
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import xarray as xr

from rollerrig.analysis.run_limits import REPRODUCED

PREDICTED = ("contact", "drive_grip", "drive_slide")
"""Regions whose border the closed forms give; that of a recovery depends on the torque which the protection leaves."""


@dataclass(frozen=True)
class Border:
    """Where limits begin on one rail, as magnitudes of the axle torque [N m].

    Attributes:
        side: 'brake' or 'traction'.
        load: axle load over the case's own [-].
        adhesion: of the rail [-].
        reached: largest torque up to which every run reproduces the rail; 0: none.
        beyond: the next torque that was run; NaN: the map ends before a limit is reached.
        limit: region there, or "".
        predicted: where the closed forms put the border, NaN where they do not say.
        predicted_near: least and largest prediction within a cell of adhesion.
    """

    side: str
    load: float
    adhesion: float
    reached: float
    beyond: float
    limit: str
    predicted: float
    predicted_near: tuple[float, float]

    @property
    def agrees(self) -> bool | None:
        """Whether the closed form passes the border within a cell of torque or adhesion; None: not to be compared."""
        if self.limit not in PREDICTED or not math.isfinite(self.predicted) or not self.reached > 0.0:
            return None
        cell = self.beyond - self.reached
        low, high = self.predicted_near
        return low <= self.beyond + cell and self.reached - cell <= high


def borders(found: xr.Dataset) -> list[Border]:
    """Borders between runs without and with a limit along each row of a map."""
    rows = []
    for side, load, adhesion in _rows(found):
        runs = _along(found, side, load, adhesion)
        good = next((k for k, (_, region) in enumerate(runs) if region not in REPRODUCED), len(runs))
        reached = runs[good - 1][0] if good else 0.0
        beyond, limit = runs[good] if good < len(runs) else (math.nan, "")
        at, *near = (predicted(found, side, load, a) for a in (adhesion, *_neighbours(found, adhesion)))
        rows.append(Border(side, load, adhesion, reached, beyond, limit, at, (min(at, *near), max(at, *near))))
    return rows


def slides(found: xr.Dataset) -> list[Border]:
    """Borders between gripping and sliding virtual wheels, where no limit lies between: against (V2)."""
    rows = []
    for side, load, adhesion in _rows(found):
        runs = _along(found, side, load, adhesion)
        first = next((k for k, (_, region) in enumerate(runs) if region != "grip"), len(runs))
        if 0 < first < len(runs) and runs[first][1] == "slide":
            (low, _), (high, _), line = runs[first - 1], runs[first], _line(found, "line_grip", side, load, adhesion)
            rows.append(Border(side, load, adhesion, low, high, "drive_slide", line, (line, line)))
    return rows


def predicted(found: xr.Dataset, side: str, load: float, adhesion: float) -> float:
    """The least torque at which a closed form predicts a limit [N m].

    While wheels grip: (V3), (V4). Where they slide: (V5), or at once where (V5) lies below (V2).
    """
    names = ("line_contact", "line_drive_grip", "line_drive_slide")
    *gripping, slide = (_line(found, name, side, load, adhesion) for name in names)
    sliding = slide if math.isfinite(slide) else _line(found, "line_grip", side, load, adhesion)
    return min([*filter(math.isfinite, gripping), sliding])


def _rows(found: xr.Dataset) -> Iterator[tuple[str, float, float]]:
    """Rows of the first grid; all of them unless runs are missing."""
    step = 2 ** int(found.attrs["refine"])
    names = found["side"].to_numpy(), found["load"].to_numpy(), found["adhesion"].to_numpy()[::step]
    for side, load, adhesion in itertools.product(*names):
        if (found["region"].sel(load=load, adhesion=adhesion).to_numpy()[::step] != "").all():
            yield str(side), float(load), float(adhesion)


def _along(found: xr.Dataset, side: str, load: float, adhesion: float) -> list[tuple[float, str]]:
    """Magnitude of torque and region of the runs on one rail, from little to much torque."""
    row = found["region"].sel(load=load, adhesion=adhesion)
    sign = -1.0 if side == "brake" else 1.0
    runs = [(sign * float(t), str(r)) for t, r in zip(row["torque"].to_numpy(), row.to_numpy(), strict=True) if r]
    return sorted((torque, region) for torque, region in runs if torque > 0.0)


def _neighbours(found: xr.Dataset, adhesion: float) -> tuple[float, float]:
    """Adhesions of the first grid on either side, or the same at the map's edge."""
    own = found["adhesion"].to_numpy()[:: 2 ** int(found.attrs["refine"])]
    place = int(np.argmin(np.abs(own - adhesion)))
    return float(own[max(0, place - 1)]), float(own[min(len(own) - 1, place + 1)])


def _line(found: xr.Dataset, name: str, side: str, load: float, adhesion: float) -> float:
    line = found[name].sel(side=side, load=load)
    return float(np.interp(adhesion, found["line_adhesion"].to_numpy(), line.to_numpy()))
