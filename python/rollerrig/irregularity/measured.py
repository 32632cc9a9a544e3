"""Rails from a measured file.

    CSV: one line of column names with units, rows of numbers -> [MeasuredTrack] -> [RailIrregularity]

Columns: `distance`, and either the displacements of both rails, `left_y`, `left_z`, `right_y`, `right_z`, or any of the
components `alignment`, `vertical`, `cross_level`, `gauge`; one that is not there is zero. A unit follows its name in
brackets: `distance [m]`. The gauge is the deviation from the nominal one, not the gauge itself.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from rollerrig.common.arrays import Array
from rollerrig.common.splines import quasi_interpolant
from rollerrig.common.text_table import name_and_unit, numbers, read_table
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
        columns = _columns(read_table(path))
    except OSError as error:
        raise IrregularityError(f"{path}: cannot be read: {error.strerror or error}") from None
    except ValueError as error:
        raise IrregularityError(f"{path}: {error}") from None
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


def _columns(table: Sequence[tuple[str, Sequence[str]]]) -> dict[str, Array]:
    """Values by the names of their columns [m]; ValueError: they are no track."""
    allowed = f"distance, and {', '.join(RAILS)} or some of {', '.join(COMPONENTS)}"
    columns: dict[str, Array] = {}
    for heading, cells in table:
        name, unit = name_and_unit(heading.lower())
        if name not in ("distance", *RAILS, *COMPONENTS):
            raise ValueError(f"unknown column {heading!r}; allowed: {allowed}")
        if unit not in UNITS:
            raise ValueError(f"column {heading!r}: no unit; allowed: {', '.join(UNITS)}, as in '{name} [mm]'")
        if name in columns:
            raise ValueError(f"column {name} stands there twice")
        columns[name] = UNITS[unit] * numbers(name, cells)
    given = columns.keys() - {"distance"}
    complete = given == set(RAILS) or (given and given <= set(COMPONENTS))
    if "distance" not in columns or not complete:
        raise ValueError(f"columns {', '.join(columns)}; needed: {allowed}")
    if (rows := len(columns["distance"])) < FEWEST_ROWS:
        raise ValueError(f"{rows} rows; a measured track has at least {FEWEST_ROWS}")
    return columns


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
