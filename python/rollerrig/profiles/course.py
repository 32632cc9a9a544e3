"""Measured points in the order along the profile, and what makes a row of them unusable: folds, gaps, kinks.

    RawProfile, in the file's order -> [Course] -> checks, smoothing

A message about a point names its line, whatever has been left out, turned round or averaged since it was read.

All functions take points in our axes, ordered along the profile, in metres, and raise ProfileError.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from rollerrig.common.arrays import Array, Mask
from rollerrig.profiles.table import ProfileError

STRAY = 0.3e-3
"""A point farther than this from both neighbours, which lie together, is none of the profile [m]."""
LONGEST = 2.0
"""Largest length of the way along the points: more has a profile of which the points are not in order [m]."""
MOST_POINTS = 20_000
"""More are averaged: 15 um apart on the widest profile, they say the same."""


@dataclass(frozen=True, eq=False)
class Course:
    """Points along a profile."""

    file: Path  # where they come from
    points: Array  # (n, 2) abscissa and ordinate [m]
    weights: Array  # (n,) how much each counts in the smoothing [-]
    lines: NDArray[np.intp]  # (n,) line of the file, from 1

    def __len__(self) -> int:
        """Number of points."""
        return len(self.points)

    def part(self, chosen: slice | Sequence[int] | NDArray[np.intp] | Mask) -> "Course":
        """Some of the points, in the order of `chosen`."""
        return replace(self, points=self.points[chosen], weights=self.weights[chosen], lines=self.lines[chosen])

    def place(self, i: int) -> str:
        """Where point i is, for a message."""
        y, z = self.points[i] * 1e3
        return f"line {self.lines[i]}, ({y:.4g}, {z:.4g}) mm"

    def nearest(self, point: Array) -> str:
        """The place of the point nearest to another one (2,) [m]."""
        return self.place(int(np.argmin(np.hypot(*(self.points - point).T))))

    @property
    def spacing(self) -> Array:
        """(n - 1,) distances of neighbours [m]."""
        return np.asarray(np.hypot(*np.diff(self.points, axis=0).T))

    def averaged(self, count: int) -> "Course":
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
        raise ProfileError(
            f"{course.file}: {course.place(i)}: a stray point, {1e3 * off[i - 1]:.4g} mm off both neighbours, the worst of "
            f"{np.sum(stray)}; remove it, or put the points in order along the profile"
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
    return course.part(spaced(course.points, max(float(np.median(course.spacing)) / 20, 1e-12)))


def spaced(points: Array, least: float) -> list[int]:
    """Indices of points (n, 2) at least so far from the one kept before."""
    keep = [0]
    for i in range(1, len(points)):
        if math.hypot(*(points[i] - points[keep[-1]])) >= least:
            keep.append(i)
    return keep


FOLD = 0.3e-3  # [m] a return of the abscissa beyond measuring noise
LARGEST_GAP = 5e-3  # [m] between neighbours; a 13 mm corner would turn by 22 degrees unseen
LARGEST_KINK = 0.12  # [rad], 7 degrees; arcs meeting an arc give up to 0.06 in the estimate below
DIRECTION_NOISE = 0.02  # [rad] of one chord, a sixth of the kink to be found
KINK_WINDOW = 2.5e-3  # [m] on each side, over which the direction is extrapolated


def check_fold(course: Course, reference: int) -> None:
    """Refuse an abscissa that turns back before it continues outward, seen from an index.

    The back of a flange or the underside of a rail head turn back and stay there: those are merely not used.
    """
    for towards in (slice(reference, None), slice(reference, None, -1)):
        path = course.points[towards]
        outward = np.abs(path[:, 0] - path[0, 0]) * np.sign((path[:, 0] - path[0, 0]) * (path[-1, 0] - path[0, 0]))
        reached = np.maximum.accumulate(outward)
        returned = reached - outward > FOLD
        goes_on = np.maximum.accumulate(outward[::-1])[::-1] > reached + FOLD
        if np.any(returned & goes_on):
            where = course.part(towards).place(int(np.argmax(returned & goes_on)))
            raise ProfileError(
                f"{course.file}: the profile folds back near {where}: its abscissa must grow along the running surface; "
                "are the points in order along the profile?"
            )


def check_gaps(course: Course, low: float, high: float) -> None:
    """Refuse neighbours too far apart to know the shape between them, for abscissae in [low, high]."""
    middle = (course.points[1:, 0] + course.points[:-1, 0]) / 2
    distance = course.spacing * ((middle > low) & (middle < high))
    i = int(np.argmax(distance))
    if distance[i] > LARGEST_GAP:
        raise ProfileError(
            f"{course.file}: a gap of {distance[i] * 1e3:.4g} mm after {course.place(i)}; allowed "
            f"{LARGEST_GAP * 1e3:g} mm; points every 0.1 to 0.5 mm are usual"
        )


def averaged(course: Course, noise: float) -> Course:
    """Means of so many neighbours that the chords between them have a direction good to DIRECTION_NOISE; else the points.

    Their noise is a standard deviation [m].
    """
    spacing = float(np.median(course.spacing))
    count = max(1, int(np.ceil((np.sqrt(2.0) * noise / (DIRECTION_NOISE * spacing)) ** (2 / 3))))
    return course.averaged(min(count, len(course)))


def direction_jumps(points: Array) -> Array:
    """Jump of direction at every point [rad], positive where the profile turns upward; 0 near the two ends.

    From each side the direction at a point is extrapolated linearly along the arc length: exact on lines and arcs,
    so that a corner of any radius is no kink. At least three chords, and KINK_WINDOW, are taken per side.
    """
    chord = np.diff(points, axis=0)
    length = np.hypot(*chord.T)
    direction = np.unwrap(np.arctan2(chord[:, 1], chord[:, 0]))
    s = np.concatenate(([0.0], np.cumsum(length)))
    middle = (s[1:] + s[:-1]) / 2
    first = np.searchsorted(s, s - KINK_WINDOW)
    last = np.searchsorted(s, s + KINK_WINDOW, side="right") - 1
    jump = np.zeros(len(points))
    for i in range(3, len(points) - 3):
        left = slice(min(first[i], i - 3), i)
        right = slice(i, max(last[i], i + 3))
        after = _extrapolated(middle[right] - s[i], direction[right], length[right])
        before = _extrapolated(middle[left] - s[i], direction[left], length[left])
        jump[i] = after - before
    return jump


def check_kinks(course: Course, low: float, high: float) -> None:
    """Refuse a jump of direction, for abscissae in [low, high]; noisy points are to be `averaged` before."""
    points = course.points
    jump = np.abs(direction_jumps(points)) * ((points[:, 0] > low) & (points[:, 0] < high))
    worst = int(np.argmax(jump))
    if jump[worst] > LARGEST_KINK:
        raise ProfileError(
            f"{course.file}: not smooth: the direction jumps by {np.degrees(jump[worst]):.3g} degrees near "
            f"{course.place(worst)}; allowed {np.degrees(LARGEST_KINK):.2g}; a contact force needs a continuous "
            "curvature: round the edge off, or remove stray points"
        )


def _extrapolated(x: Array, value: Array, weight: Array) -> float:
    """Value at x = 0 of the weighted straight line through (x, value)."""
    total = weight.sum()
    mean_x, mean = weight @ x / total, weight @ value / total
    spread = weight @ (x - mean_x) ** 2
    return float(mean - mean_x * (weight @ ((x - mean_x) * (value - mean))) / spread)
