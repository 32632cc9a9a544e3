"""How far the rig reaches on each rail of an envelope map, and whether the closed forms agree.

Dataset of `envelope` -> [borders] -> one row per side, load and adhesion
"""

import itertools
import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import xarray as xr

from rollerrig.analysis.rig_limits import REPRODUCED


@dataclass(frozen=True)
class Border:
    """Where limits begin on one rail, as magnitudes of the axle torque [N m]."""

    side: str  # 'brake' or 'traction'
    load: float  # axle load over the case's own [-]
    adhesion: float  # of the rail [-]
    reproduced_up_to_nm: float  # largest torque up to which every run reproduces the rail; 0: none
    beyond_nm: float  # the next torque that was run; NaN: the map ends before a limit is reached
    limit: str  # region there, or ""
    predicted_nm: float  # where the closed forms put the border, NaN where they do not say
    # the torques of the runs on either side, which the prediction is compared with; of a recovery the torque that was left on
    # the axles there over what (V6) asks for, of which 0 is the prediction
    compared_low_nm: float
    compared_high_nm: float
    cell_nm: float  # distance of torques on the map

    @property
    def agrees(self) -> bool | None:
        """Whether the predicted torque lies between the runs on either side, give or take a cell of torque.

        None: no limit was reached on the map, and none is predicted on it. A limit of which the closed forms say nothing, and a
        predicted one that does not come, do not agree.
        """
        cell, at = self.cell_nm, self.predicted_nm
        if not self.limit:
            return None if not at < self.reproduced_up_to_nm - cell else False
        return bool(self.compared_low_nm - cell <= at <= self.compared_high_nm + cell)


def borders(found: xr.Dataset) -> list[Border]:
    """Borders between runs without and with a limit along each row of a map."""
    rows = []
    for side, load, adhesion in _rows(found):
        runs = _along(found, side, load, adhesion)
        good = next((k for k, (_, region) in enumerate(runs) if region not in REPRODUCED), len(runs))
        reached = runs[good - 1][0] if good else 0.0
        beyond, limit = runs[good] if good < len(runs) else (math.nan, "")
        at, compared = predicted(found, side, load, adhesion), (reached, beyond)
        if limit == "drive_recovery":
            at = 0.0
            compared = (_margin(found, side, load, adhesion, beyond), _margin(found, side, load, adhesion, reached))
        ends = min(compared), max(compared)
        rows.append(Border(side, load, adhesion, reached, beyond, limit, at, *ends, _cell(runs, good)))
    return rows


def slides(found: xr.Dataset) -> list[Border]:
    """Borders between gripping and sliding virtual wheels, where no limit lies between: against (V2)."""
    rows = []
    for side, load, adhesion in _rows(found):
        runs = _along(found, side, load, adhesion)
        first = next((k for k, (_, region) in enumerate(runs) if region != "grip"), len(runs))
        if 0 < first < len(runs) and runs[first][1] == "slide":
            (low, _), (high, _), line = runs[first - 1], runs[first], _line(found, "line_grip", side, load, adhesion)
            rows.append(Border(side, load, adhesion, low, high, "slide", line, low, high, _cell(runs, first)))
    return rows


def predicted(found: xr.Dataset, side: str, load: float, adhesion: float) -> float:
    """The least torque at which a closed form predicts a limit [N m].

    While wheels grip: (V3), (V4). Where they slide: (V5), or at once where (V5) lies below (V2). What (V6) says depends on the
    torque that the protection leaves, see `borders`.
    """
    names = ("line_contact", "line_drive_grip", "line_drive_slide")
    *gripping, slide = (_line(found, name, side, load, adhesion) for name in names)
    sliding = slide if math.isfinite(slide) else _line(found, "line_grip", side, load, adhesion)
    return min([*filter(math.isfinite, gripping), sliding])


def _cell(runs: list[tuple[float, str]], place: int) -> float:
    """Distance of the torques on either side of a place in a row, or of the last two."""
    torques = [torque for torque, _ in runs]
    k = min(max(place, 1), len(torques) - 1)
    return torques[k] - torques[k - 1] if k > 0 else torques[0]


def _margin(found: xr.Dataset, side: str, load: float, adhesion: float, torque: float) -> float:
    """Least torque over what (V6) asks for in a run [N m]; infinite where no wheel comes out of a slide."""
    if not torque > 0.0:
        return math.inf
    signed = -torque if side == "brake" else torque
    margin = float(found["recovery_margin_nm"].sel(load=load, adhesion=adhesion, torque=signed))
    return margin if math.isfinite(margin) else math.inf


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


def _line(found: xr.Dataset, name: str, side: str, load: float, adhesion: float) -> float:
    line = found[name].sel(side=side, load=load)
    return float(np.interp(adhesion, found["line_adhesion"].to_numpy(), line.to_numpy()))
