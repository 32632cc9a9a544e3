"""Measured points in the order along the profile, each with its line of the file.

    RawProfile, in the file's order -> [Course] -> checks, smoothing

A message about a point names its line, whatever has been left out, turned round or averaged since it was read.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from .errors import ProfileError
from .table import FloatArray

STRAY = 0.3e-3
"""A point farther than this from both neighbours, which lie together, is none of the profile [m]."""
LONGEST = 2.0
"""Largest length of the way along the points: more has a profile of which the points are not in order [m]."""
MOST_POINTS = 20_000
"""More are averaged: 15 um apart on the widest profile, they say the same."""


@dataclass(frozen=True, eq=False)
class Course:
    """Points along a profile.

    Attributes:
        file: where they come from.
        points: (n, 2) abscissa and ordinate [m].
        weights: (n,) how much each counts in the smoothing [-].
        lines: (n,) line of the file, from 1.
    """

    file: Path
    points: FloatArray
    weights: FloatArray
    lines: NDArray[np.intp]

    def __len__(self) -> int:
        """Number of points."""
        return len(self.points)

    def part(self, chosen: slice | Sequence[int] | NDArray[np.intp] | NDArray[np.bool_]) -> Course:
        """Some of the points, in the order of `chosen`."""
        return replace(self, points=self.points[chosen], weights=self.weights[chosen], lines=self.lines[chosen])

    def place(self, i: int) -> str:
        """Where point i is, for a message."""
        y, z = self.points[i] * 1e3
        return f"line {self.lines[i]}, ({y:.4g}, {z:.4g}) mm"

    def nearest(self, point: FloatArray) -> str:
        """The place of the point nearest to another one (2,) [m]."""
        return self.place(int(np.argmin(np.hypot(*(self.points - point).T))))

    @property
    def spacing(self) -> FloatArray:
        """(n - 1,) distances of neighbours [m]."""
        return np.asarray(np.hypot(*np.diff(self.points, axis=0).T))

    @property
    def closed(self) -> bool:
        """Whether the last point comes back to the first."""
        return bool(np.hypot(*(self.points[-1] - self.points[0])) <= 3 * np.median(self.spacing))

    def averaged(self, count: int) -> Course:
        """Means of `count` neighbours, with the line of the first of them; what is left over at the end is dropped."""
        if count <= 1:
            return self
        groups = len(self) // count
        kept = groups * count
        points = self.points[:kept].reshape(groups, count, 2).mean(axis=1)
        weights = self.weights[:kept].reshape(groups, count).mean(axis=1)
        return replace(self, points=points, weights=weights, lines=self.lines[:kept:count])


def check_stray(course: Course) -> None:
    """Refuse a point that stands off two neighbours which lie together."""
    step = course.spacing
    across = np.hypot(*(course.points[2:] - course.points[:-2]).T)
    off = np.minimum(step[1:], step[:-1])
    stray = (off > STRAY) & (off > 5 * across)
    if np.any(stray):
        i = int(np.argmax(off * stray)) + 1
        if (count := int(np.sum(stray))) > 3 + len(course) // 50:
            raise ProfileError(
                f"{course.file}: {count} points jump away from their neighbours and back, the farthest by "
                f"{1e3 * off[i - 1]:.4g} mm at {course.place(i)}: the points must be in order along the profile"
            )
        raise ProfileError(
            f"{course.file}: {course.place(i)}: a stray point, {1e3 * off[i - 1]:.4g} mm off both neighbours; remove it"
        )


def check_order(course: Course) -> None:
    """Refuse points that jump to and fro: whatever goes through them is no profile."""
    way = float(np.sum(course.spacing))
    if way > LONGEST:
        i = int(np.argmax(course.spacing))
        raise ProfileError(
            f"{course.file}: {way:.4g} m along the points, allowed {LONGEST:g} m: they must be in order along the profile; the "
            f"longest step, {1e3 * course.spacing[i]:.4g} mm, follows {course.place(i)}"
        )


def without_crowds(course: Course) -> Course:
    """Without points that crowd closer than a twentieth of the usual spacing: they say nothing about direction."""
    least = float(np.median(course.spacing)) / 20
    points = course.points
    keep = [0]
    for i in range(1, len(points)):
        if math.hypot(*(points[i] - points[keep[-1]])) > least:
            keep.append(i)
    return course.part(keep)
