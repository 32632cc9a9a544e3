"""Rails from a measured file.

    CSV: one line of column names with units, rows of numbers -> [MeasuredTrack] -> [RailIrregularity]

Columns: `distance`, and either the displacements of both rails, `left_y`, `left_z`, `right_y`, `right_z`, or any of the
components `alignment`, `vertical`, `cross_level`, `gauge`; one that is not there is zero. A unit follows its name in
brackets or after an underscore: `distance [m]`, `vertical (mm)`, `left_y_mm`. The gauge is the deviation from the
nominal one, not the gauge itself.
"""

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from rollerrig.common.arrays import Array
from rollerrig.common.input_files import LARGEST_TABLE, read_input
from rollerrig.common.splines import quasi_interpolant
from rollerrig.irregularity.rails import (
    COMPONENTS,
    RAILS,
    IrregularityError,
    RailIrregularity,
    periodic_spline,
    rails_of,
)

UNITS = {"m": 1.0, "mm": 1e-3, "km": 1e3, "cm": 1e-2}
LARGEST = 0.2
"""Deviation beyond which a unit or a gauge in place of its deviation is suspected [m]."""
LARGEST_SPACING = 2.0
"""Spacing of samples beyond which the waves that shake a vehicle are missing [m]."""
FEWEST_ROWS = 8

_HEADING = re.compile(r"\s*([a-z_]+?)\s*(?:[\[(]\s*([a-z]+)\s*[\])]|_(mm|cm|km|m))?\s*")


@dataclass(frozen=True, eq=False)
class MeasuredTrack:
    """Samples of a measured track: ascending distance (n,) and displacements of the rails (n,) [m], by name of RAILS."""

    path: Path
    distance: Array
    rails: Mapping[str, Array]


def read_measured_track(path: Path) -> MeasuredTrack:
    """Read a file of measured rails.

    Raises:
        IrregularityError: the file is missing or malformed, or its numbers cannot be a track.
    """
    try:
        lines = read_input(path, LARGEST_TABLE).decode("utf-8-sig", errors="replace").splitlines()
    except OSError as error:
        raise IrregularityError(f"{path}: cannot be read: {error.strerror or error}") from None
    numbered = [(i, line.split("#", 1)[0].strip()) for i, line in enumerate(lines, 1)]
    numbered = [(i, line) for i, line in numbered if line]
    if not numbered:
        raise IrregularityError(f"{path}: the file is empty; it begins with a line of column names")
    scales = _heading(path, numbered[0][1])
    table = _numbers(path, numbered[1:], len(scales)) * list(scales.values())
    columns = dict(zip(scales, table.T, strict=True))
    distance = columns.pop("distance")
    _check_distance(path, distance)
    _check_size(path, columns)
    if RAILS[0] in columns:
        rails = columns
    else:
        nothing = np.zeros_like(distance)
        rails = rails_of({name: columns.get(name, nothing) for name in COMPONENTS})
    return MeasuredTrack(path, distance, rails)


def measured_irregularity(
    track: MeasuredTrack, *, start: float, needed: tuple[float, float], fade_in: float, scale: float = 1.0
) -> RailIrregularity:
    """The rails of a measured track where a run needs them.

    Args:
        track: the samples.
        start: distance of the file at which the run's distance 0 lies [m].
        needed: first and last distance of the run at which rails are needed [m]; elsewhere they mean nothing.
        fade_in: see RailIrregularity [m].
        scale: factor on all displacements.

    Raises:
        IrregularityError: the file does not reach that far.
    """
    first, last = track.distance[0], track.distance[-1]
    low, high = needed
    if first > start + low + 1e-6 or last < start + high - 1e-6:
        raise IrregularityError(
            f"{track.path}: shorter than the run: it reaches from {first:g} to {last:g} m, the wheels run from "
            f"{start + low:.6g} to {start + high:.6g} m of it; shorten the run, or give a longer file"
        )
    step = float(np.median(np.diff(track.distance)))
    margin = 3 * step  # beyond these the rails wrap around
    count = max(int(np.ceil((high - low + 2 * margin) / step)), FEWEST_ROWS)
    lowest = low - margin
    s = lowest + np.mod(np.arange(count) * step - lowest, count * step)
    from scipy.interpolate import CubicSpline

    coefficients = {}
    for rail in RAILS:
        values = scale * CubicSpline(track.distance, track.rails[rail])(np.clip(s + start, first, last))
        # local: the wrap has no effect elsewhere
        weights = quasi_interpolant(np.roll(values, 1), values, np.roll(values, -1))
        coefficients[rail] = periodic_spline(weights, step)
    return RailIrregularity(step, coefficients, fade_in)


def _heading(path: Path, line: str) -> dict[str, float]:
    """Names of the columns, and what turns each into metres."""
    allowed = f"distance, and {', '.join(RAILS)} or some of {', '.join(COMPONENTS)}"
    scales: dict[str, float] = {}
    for text in _cells(line):
        match = _HEADING.fullmatch(text.lower())
        name, unit = (match[1], match[2] or match[3]) if match else (text, None)
        if name not in ("distance", *RAILS, *COMPONENTS):
            raise IrregularityError(f"{path}: unknown column {text.strip()!r}; allowed: {allowed}")
        if unit not in UNITS:
            units = f"{', '.join(UNITS)}, as in '{name} [mm]'"
            raise IrregularityError(f"{path}: column {text.strip()!r}: no unit; allowed: {units}")
        if name in scales:
            raise IrregularityError(f"{path}: column {name} stands there twice")
        scales[name] = UNITS[unit]
    given = scales.keys() - {"distance"}
    complete = given == set(RAILS) or (given and given <= set(COMPONENTS))
    if "distance" not in scales or not complete:
        raise IrregularityError(f"{path}: columns {', '.join(scales)}; needed: {allowed}")
    return scales


def _cells(line: str) -> list[str]:
    for separator in (";", ",", "\t"):
        if separator in line:
            decimal = "," if separator == ";" else "."
            return [cell.strip().replace(decimal, ".") for cell in line.split(separator)]
    return line.split()


def _numbers(path: Path, lines: list[tuple[int, str]], columns: int) -> Array:
    rows = []
    for number, line in lines:
        cells = _cells(line)
        if len(cells) != columns:
            raise IrregularityError(f"{path}: line {number}: {len(cells)} numbers; the header names {columns} columns")
        try:
            rows.append([float(cell) for cell in cells])
        except ValueError:
            raise IrregularityError(f"{path}: line {number}: {line!r} is not a row of numbers") from None
        if not all(map(math.isfinite, rows[-1])):
            raise IrregularityError(f"{path}: line {number}: {line!r} is not finite; remove or repair the row")
    if len(rows) < FEWEST_ROWS:
        raise IrregularityError(f"{path}: {len(rows)} rows; a measured track has at least {FEWEST_ROWS}")
    return np.array(rows)


def _check_distance(path: Path, distance: Array) -> None:
    spacing = np.diff(distance)
    back = int(np.argmax(spacing <= 0))
    if spacing[back] <= 0:
        raise IrregularityError(
            f"{path}: the distance must grow: {distance[back + 1]:g} m follows {distance[back]:g} m"
        )
    widest = int(np.argmax(spacing))
    if spacing[widest] > LARGEST_SPACING:
        raise IrregularityError(
            f"{path}: a gap of {spacing[widest]:g} m after distance {distance[widest]:g} m; allowed {LARGEST_SPACING:g} m; "
            "samples every 0.25 m are usual; is the unit of the distance right?"
        )


def _check_size(path: Path, columns: Mapping[str, Array]) -> None:
    for name, values in columns.items():
        largest = float(np.abs(values).max())
        if largest > LARGEST:
            hint = "; a deviation from the nominal gauge is meant" if name == "gauge" else "; is its unit right?"
            raise IrregularityError(
                f"{path}: column {name}: a deviation of {1e3 * largest:g} mm; allowed {1e3 * LARGEST:g} mm{hint}"
            )
