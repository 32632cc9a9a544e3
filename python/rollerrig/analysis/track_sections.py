"""Sections of a run as EN 14363 assesses them: straights, transitions, circular curves by their radius.

    run -> [track_sections] -> which output times belong to which section

A vehicle is in a straight or a curve from where its last wheelset has come in until its first one leaves; between, it is in a
transition, where nothing is quasi-static.

Source: EN 14363:2016, test zones.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from rollerrig.results.run_info import RunInfo, TrackSegment

WHOLE_RUN = "whole run"

STEADY_SPEED = 0.05
"""Part of its mean by which the speed may range in a section with quasi-static values; EN 14363: 5 km/h either side."""

TEST_ZONES = ((600.0, 2), (400.0, 3), (250.0, 4))
"""Radius [m] and test zone of curves above it; of 400 and 250 m including it. Straights are zone 1."""


@dataclass(frozen=True)
class TrackSection:
    """A part of a run.

    Attributes:
        name: number in the order of the run and what it is; unique.
        constant: whether curvature, cant and speed are constant there, so that it has quasi-static values.
        within: which output times belong to it, shape (time,).
    """

    name: str
    constant: bool
    within: NDArray[np.bool_]


def track_sections(run: xr.Dataset) -> list[TrackSection]:
    """The sections that a run has come through, in their order; the whole run is the only one without curves and on a rig.

    Args:
        run: results of `simulate` or `load_run`.
    """
    info = RunInfo.of(run)
    speed, distance = run["speed"].to_numpy(), run["distance"].to_numpy()
    if len(info.segments) < 2:
        everywhere = np.ones(run.sizes["time"], dtype=bool)
        name = "rollers" if info.support == "rig" else in_words(info.segments[0]) if info.segments else "straight"
        return [TrackSection(name, _steady(speed), everywhere)]
    constant = [segment for segment in info.segments if segment.kind != "transition"]
    numbers = _numbers(info, constant, distance)
    found: list[TrackSection] = []
    for number in np.unique(numbers).tolist():
        within = numbers == number
        segment = constant[number // 2] if number % 2 == 0 else None
        name = f"{len(found) + 1} {in_words(segment) if segment else 'transition'}"
        found.append(TrackSection(name, segment is not None and _steady(speed[within]), within))
    return found


def section_names(run: xr.Dataset) -> NDArray[np.str_]:
    """Name of the section at every output time, shape (time,)."""
    names = np.full(run.sizes["time"], "", dtype=object)
    for section in track_sections(run):
        names[section.within] = section.name
    return names.astype(str)


def _numbers(info: RunInfo, constant: Sequence[TrackSegment], distance: NDArray[np.float64]) -> NDArray[np.int_]:
    """2 k where the vehicle is wholly in the constant segment k, 2 k + 1 on its way from there to the next, -1 before all."""
    places = [body.position[0] for body in info.wheelsets]
    rear, front = distance + min(places), distance + max(places)
    ends = [math.inf if segment is info.segments[-1] else segment.end for segment in constant]
    left = np.searchsorted(ends, front, side="left")
    numbers = 2 * left - 1
    for k, segment in enumerate(constant):
        come = (rear >= segment.start) | (segment is info.segments[0])
        numbers = np.where(come & (left == k), 2 * k, numbers)
    return np.asarray(numbers)


def in_words(segment: TrackSegment) -> str:
    """`straight`, or a curve with its radius, direction and test zone."""
    if segment.curvature == 0.0:
        return "straight"
    radius = 1.0 / abs(segment.curvature)
    side = "left" if segment.curvature > 0 else "right"
    zone = test_zone(radius)
    return f"curve R {radius:.0f} m {side}" + (f", test zone {zone}" if zone else "")


def test_zone(radius: float) -> int | None:
    """Test zone of EN 14363 of curves of a radius [m]; None below 250 m."""
    large = TEST_ZONES[0]
    if radius > large[0] * (1.0 + 1e-9):
        return large[1]
    return next((zone for least, zone in TEST_ZONES[1:] if radius >= least * (1.0 - 1e-9)), None)


def _steady(speed: NDArray[np.float64]) -> bool:
    return not len(speed) or float(np.ptp(speed)) <= STEADY_SPEED * abs(float(speed.mean()))


def curved(run: xr.Dataset) -> bool:
    """Whether the run met a curve or cant."""
    return "curvature" in run and bool((run["curvature"] != 0.0).any() or (run["cant"] != 0.0).any())


def irregular(run: xr.Dataset) -> bool:
    """Whether rails or rollers were irregular."""
    return "rail_lateral" in run and bool((run["rail_lateral"] != 0.0).any() or (run["rail_vertical"] != 0.0).any())
