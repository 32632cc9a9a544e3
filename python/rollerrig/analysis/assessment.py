"""A run's wheel-rail forces and accelerations as a table: every quantity with its statistics, its filter and its limit.

    run -> [accelerations] -> at the centre of each body and over what carries it -> [ride] -> filtered
    run -> wheel-rail forces, accelerations -> [assessment] -> rows -> running_safety.csv, summary.json, report

A point ρ of a rigid body with the centre's acceleration a_C, angular velocity ω and acceleration α is accelerated by

    a = a_C + α × ρ + ω × (ω × ρ)                                                  (R4)

and an accelerometer fixed to the body feels R^T (a + g e_z), of which the g at rest is taken off. What the centre feels and
ω, α along the body's axes are recorded as sensors there would show them: in curves with the uncompensated part, and with the
turning of the track under the body, of its plan and of its cant (W11).

Source: EN 14363:2016.
"""

import math
from dataclasses import dataclass

import numpy as np
import xarray as xr

from rollerrig.analysis.signals import away_from_ends, band_pass, low_pass
from rollerrig.analysis.wheel_rail_forces import (
    INSTABILITY_LENGTH,
    QUOTIENT_LIMIT,
    STATISTICS,
    WHOLE_RUN,
    TrackSection,
    at_output_times,
    filtered,
    statistics,
    track_sections,
    wheel_forces,
)
from rollerrig.common.arrays import Array
from rollerrig.results.run_info import RunInfo
from rollerrig.results.summary import resolved

DIRECTIONS = ("lateral", "vertical")

RIDE_BAND = (0.4, 10.0)  # band pass of accelerations in the car body [Hz]
FRAME_CUTOFF = 10.0  # low pass of accelerations of a bogie frame [Hz]


def accelerations(run: xr.Dataset, *, floor_height: float | None = None) -> xr.Dataset:
    """Accelerations at the centre of every free body above the wheelsets, and over each body that carries it.

    A car body rests on frames, a frame by wheelsets: joined by elements that carry load, and higher.

    Args:
        run: results of `simulate` or `load_run`.
        floor_height: height above the rails of the points over what carries the car body [m]; None: where its springs
            act on it. On a frame the points lie as high as its centre.

    Returns:
        acceleration [m/s^2] over time, point and direction (lateral, vertical), unfiltered, as an accelerometer fixed to
        the body feels it: lateral with gravity's part in a roll, vertical less g at rest. The body of each point is the
        coordinate `of_body`, and `on_wheelsets` says whether wheelsets carry it. No points if all bodies above the
        wheelsets are fixed.
    """
    info = RunInfo.of(run)
    names, bodies, framed, rows = [], [], [], []
    for body in info.sprung:
        x, _, z = body.position
        on_wheelsets = info.on_wheelsets(body)
        motion = run.sel(body=body.name)
        points = {f"{body.name}, centre": (0.0, 0.0, 0.0)}
        for below in body.lower_bodies:
            level = below.height if floor_height is None else floor_height
            arm = (info.body(below.body).position[0] - x, 0.0, 0.0 if on_wheelsets else level - z)
            points[f"{body.name} over {below.body}"] = arm
        for name, arm in points.items():
            names.append(name)
            bodies.append(body.name)
            framed.append(on_wheelsets)
            rows.append(_at_point(motion, np.array(arm), info.gravity))
    values = np.stack(rows, axis=1) if rows else np.zeros((run.sizes["time"], 0, len(DIRECTIONS)))
    coordinates = {
        "time": run["time"],
        "point": np.array(names, dtype=str),
        "direction": list(DIRECTIONS),
        "of_body": ("point", np.array(bodies, dtype=str)),
        "on_wheelsets": ("point", np.array(framed, dtype=bool)),
    }
    attributes = {"units": "m/s^2", "long_name": "acceleration"}
    return xr.Dataset(
        {"acceleration": (("time", "point", "direction"), values, attributes)},
        coordinates,
        {"title": run.attrs["title"], "case": run.attrs["case"]},
    )


def _at_point(motion: xr.Dataset, arm: Array, gravity: float) -> Array:
    """Specific force, lateral and vertical, less that of gravity, at a point fixed to a body (R4), shape (time, 2) [m/s^2]."""
    turn, spin_up = (
        np.stack([motion[f"inertial_{axis}_{kind}"] for axis in ("roll", "pitch", "yaw")], axis=1)
        for kind in ("rate", "acceleration")
    )
    relative = np.cross(spin_up, arm) + np.cross(turn, np.cross(turn, arm))
    at_centre = np.stack([motion[f"{direction}_specific_force"] for direction in DIRECTIONS], axis=1)
    return np.asarray(at_centre - [0.0, gravity] + relative[:, 1:])


def ride(points: xr.Dataset) -> xr.Dataset:
    """What `accelerations` returns in the bands of EN 14363: frames below 10 Hz, the car body from 0.4 to 10 Hz.

    What was done to each point is the coordinate `filter`. NaN within 0.1 s of both ends.

    A ValueError says that the run's output_step is too coarse, or the run too short.
    """
    values = points["acceleration"]
    framed = points["on_wheelsets"].to_numpy()
    out = values.copy(deep=True)
    if framed.any():
        out[:, framed] = low_pass(values[:, framed], FRAME_CUTOFF)
    if (~framed).any():
        out[:, ~framed] = band_pass(values[:, ~framed], *RIDE_BAND)
    bands = np.where(framed, f"{FRAME_CUTOFF:g} Hz", "{:g} to {:g} Hz".format(*RIDE_BAND))
    return points.assign(acceleration=away_from_ends(out, FRAME_CUTOFF)).assign_coords(filter=("point", bands))


QUANTITIES = (
    "guiding_force",
    "wheel_load",
    "derailment_quotient",
    "wheel_unloading",
    "guiding_force_sum",
    "guiding_force_sum_rms",
    "wear_number",
)
"""Quantities of wheels and wheelsets, in the order of the tables."""

UNFILTERED, STATIC = "none", list(STATISTICS).index("quasi_static")


@dataclass(frozen=True)
class Assessment:
    """What was read off a run."""

    forces: xr.Dataset  # what `wheel_forces` returns
    assessed: xr.Dataset  # what `filtered` makes of it, or the unfiltered forces where the run cannot be filtered
    points: xr.Dataset  # accelerations at points of the bodies, filtered where the run can be
    unfiltered: xr.Dataset  # the same, unfiltered
    sections: tuple[TrackSection, ...]  # of the run, in their order
    notes: tuple[str, ...]  # why something is not filtered, a sentence each


@dataclass(frozen=True)
class Row:
    """One quantity at one place, in a section of the run or in all of it."""

    quantity: str  # name of the variable; accelerations with their direction
    place: str  # wheel, wheelset or point
    section: str  # name of the section, or WHOLE_RUN where a run has several
    unit: str  # of the statistics and the limit
    filter: str  # what was done to the signal before
    # by STATISTICS; NaN where none exists, as the quasi-static value of what is not constant
    statistics: dict[str, float]
    limit: float = math.nan  # of the quantity's magnitude; NaN if there is none

    @property
    def part_of_limit(self) -> float:
        """The larger of the two outer percentiles' magnitudes over the limit [-]; NaN without a limit."""
        outer = [abs(self.statistics[name]) for name in ("percentile_0_15", "percentile_99_85")]
        return max(outer) / self.limit


def assess(run: xr.Dataset) -> Assessment:
    """Read a run off, filtered as EN 14363 does where the run's output_step and length allow."""
    notes: list[str] = []
    read, unfiltered = wheel_forces(run), accelerations(run)
    points, assessed = unfiltered, at_output_times(read)
    try:
        assessed = filtered(read)
        if "guiding_force_sum_rms" not in assessed:
            notes.append(
                f"The instability criterion, an r.m.s. of ΣY over {INSTABILITY_LENGTH:g} m, is not assessed: the run has "
                f"{float(np.ptp(read['distance'].to_numpy())):.0f} m."
            )
    except ValueError as cause:
        notes.append(f"Wheel forces are not filtered: {cause}.")
    if unfiltered.sizes["point"]:
        try:
            points = ride(unfiltered)
        except ValueError as cause:
            notes.append(f"Accelerations are not filtered: {cause}.")
    return Assessment(read, assessed, points, unfiltered, tuple(track_sections(run)), tuple(notes))


def table(assessment: Assessment) -> list[Row]:
    """All rows, section by section; of each wheels first, then wheelsets, then points of the bodies.

    A run of several sections comes first as a whole.
    """
    sections = list(assessment.sections)
    if len(sections) > 1:
        everywhere = np.ones(assessment.assessed.sizes["time"], dtype=bool)
        sections.insert(0, TrackSection(WHOLE_RUN, False, everywhere))
    return [row for section in sections for row in _rows(assessment, section)]


def _rows(assessment: Assessment, section: TrackSection) -> list[Row]:
    """Rows of a section; a band pass takes the quasi-static value away, so that of an acceleration is the unfiltered signal's."""
    assessed, rows = assessment.assessed, list[Row]()
    signals = [(name, assessed[name], assessed[name]) for name in QUANTITIES if name in assessed]
    for direction in DIRECTIONS:
        both = (assessment.points, assessment.unfiltered)
        one, raw = (points["acceleration"].sel(direction=direction, drop=True) for points in both)
        signals.append((f"{direction}_acceleration", one, raw))
    for name, values, unfiltered in signals:
        unit, limit = str(values.attrs["units"]), limits(assessed, name)
        numbers, before = (resolved(statistics(one.isel(time=section.within)), unit) for one in (values, unfiltered))
        numbers[:, STATIC] = before[:, STATIC] if section.constant else math.nan
        (dim,) = (d for d in values.dims if d != "time")
        own = values.coords.get("filter")
        done = [str(values.attrs.get("filter", UNFILTERED))] * len(numbers) if own is None else own.to_numpy().tolist()
        for place, what, row in zip(map(str, values[dim].to_numpy()), done, numbers.tolist(), strict=True):
            found = dict(zip(STATISTICS, row, strict=True))
            rows.append(Row(name, place, section.name, unit, what, found, limit.get(place, math.nan)))
    return rows


def limits(assessed: xr.Dataset, name: str) -> dict[str, float]:
    """Limit of a quantity by wheel or wheelset; nothing where it has none.

    Of Y/Q the lower one of Nadal's and EN 14363's 0.8; of the r.m.s. of ΣY half of that of ΣY.
    """
    if name in ("guiding_force_sum", "guiding_force_sum_rms"):
        part = 0.5 if name.endswith("rms") else 1.0
        by_wheelset = zip(assessed["wheelset"].to_numpy(), assessed["guiding_force_sum_limit"].to_numpy(), strict=True)
        return {str(wheelset): part * float(limit) for wheelset, limit in by_wheelset}
    if name == "derailment_quotient":
        lowest = float(np.fmin(assessed["nadal_limit"], QUOTIENT_LIMIT))
        return {str(w): lowest for w in assessed["wheel"].to_numpy()}
    return {}
