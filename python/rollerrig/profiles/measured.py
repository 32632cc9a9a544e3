"""Profiles from measured points: orientation, checks, smoothing, table.

    RawProfile -> our axes -> checks (folds, gaps, kinks) -> smooth curve -> usable branch -> ProfileTable

Signs   as in table.py: abscissa outward; value is the height of a rail, or the radius increase of a wheel.
Source  smoothing: Reinsch (1967), cut-off wavelength as for surface filters; the rest is ours.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import numpy as np

from rollerrig.common.arrays import Array
from rollerrig.profiles.course import (
    LARGEST_KINK,
    MOST_POINTS,
    Course,
    averaged,
    check_fold,
    check_gaps,
    check_kinks,
    direction_jumps,
    without_crowds,
)
from rollerrig.profiles.point_file import FEWEST_POINTS, FileFormat, LengthUnit, read_point_file
from rollerrig.profiles.table import DEFAULT_STEP, STEEPEST_SLOPE, ProfileError, ProfileKind, ProfileTable, tabulate

if TYPE_CHECKING:
    from scipy.interpolate import BSpline

Side = Literal["auto", "negative", "positive"]
Direction = Literal["auto", "up", "down"]

#: Noise that the smoothed curvature may keep [1/m]: a tenth of that of the flattest arc of a rail head, R300.
CURVATURE_NOISE = 0.3
LONGEST_CUT_OFF = 10e-3  # [m] a longer one would round off the 13 mm corners
RAIL_DEPTH = 25e-3  # [m] below the top: what lies deeper (underside of the head, web, foot) is left out
FLANGE_HEIGHT = 15e-3  # [m] a flange stands at least this far above the tape circle; new ones 26 to 30 mm
RUN_OUT = 40e-3  # [m] beyond this abscissa an edge of a wheel is its outer chamfer, where the profile ends
LEAST_REACH = 10e-3  # [m] of the usable stretch to either side of the tape circle or the highest point
SAMPLE = 0.02e-3  # [m] spacing of the samples on which the smooth curve is cut and inverted


def profile_from_file(
    path: str,
    format: FileFormat = "auto",  # noqa: A002 - the key users write in the configuration
    units: LengthUnit = "auto",
    inner_side: Side = "auto",
    z_positive: Direction = "auto",
    tape_circle: float = 0.0,
    inclination: float = 0.0,
    smoothing: float | Literal["auto"] = "auto",
    require_flange: bool = True,
    step: float = DEFAULT_STEP,
    *,
    kind: ProfileKind,
) -> ProfileTable:
    """Build a profile from measured points.

    Args:
        path: the file.
        format: "two_column", "simpack", or "auto".
        units: of a two-column file: "mm", "m", or "auto".
        inner_side: sign of the file's abscissa on the flange or gauge side; "auto" looks for the flange, and for a
            rail takes it to be negative.
        z_positive: whether the file's ordinate grows "up" or "down" (as mounted: a wheel's radius grows downward);
            "auto" looks at the flange, or at the flanks of the rail.
        tape_circle: abscissa of the tape circle in the file's axes [m]; 0.07 with the sign of the file where it
            counts from the flange back. Wheels only.
        inclination: further lean of the rail towards the track centre [-]; 0 where the file is already inclined.
        smoothing: cut-off wavelength [m] of the smoothing, or "auto": the shortest that leaves a curvature noise of
            CURVATURE_NOISE.
        require_flange: refuse a wheel without a flange.
        step: knot spacing of the table [m].
        kind: what the profile is for.

    Returns:
        The table: of a wheel with value 0 at the tape circle, of a rail with its highest point at the origin.
    """
    file = Path(path)
    if smoothing != "auto" and (isinstance(smoothing, str | bool) or not 0 < smoothing <= 0.05):
        raise ProfileError(f"{file}: smoothing: {smoothing!r}; allowed 'auto', or a length above 0 and up to 0.05 m")
    raw = read_point_file(file, format, units)
    if raw.declared not in (None, kind):
        raise ProfileError(f"{file}: the file says it is a {raw.declared}; it is used as a {kind}")

    course = _oriented(raw.course, kind, inner_side, z_positive, tape_circle)
    if kind == "wheel":
        _check_wheel(course, require_flange)
    else:
        lean = math.atan(inclination)
        turn = np.array([[math.cos(lean), -math.sin(lean)], [math.sin(lean), math.cos(lean)]])  # R, leaning inward
        course = replace(course, points=course.points @ turn.T)
    return _smoothed_table(course, raw.comment, kind, smoothing, step)


def _smoothed_table(
    course: Course,
    comment: str,
    kind: ProfileKind,
    smoothing: float | Literal["auto"],
    step: float,
) -> ProfileTable:
    """The table of a smooth curve through points in our axes."""
    file, read = course.file, len(course)
    each = math.ceil(read / MOST_POINTS)
    measured = course.points
    course = without_crowds(course.averaged(each))
    _check_count(course, "different")
    noise = _noise(course.points)
    course = _relevant(course, kind, noise)
    _check_count(course, "on the running surface")
    check_fold(course, _reference(course.points, kind))
    curve = _smooth(course.points, course.weights, noise, smoothing)
    branch = _usable_branch(course, curve, kind)
    low, high = curve.points[branch.start, 0], curve.points[branch.stop - 1, 0]
    check_gaps(course, low, high)
    check_kinks(averaged(course, noise), low, high)
    origin = curve.origin(branch, kind)
    thinned = f"{read} points averaged by {each}" if each > 1 else ""
    used_cut_off = f"smoothed at {curve.cut_off * 1e3:.2g} mm"
    table = tabulate(
        lambda y: curve.height(y + origin[0], branch) - origin[1],
        float(low - origin[0]),
        float(high - origin[0]),
        name=file.stem,
        kind=kind,
        source=", ".join(part for part in (file.name, comment, thinned, used_cut_off) if part),
        step=step,
        outline=curve.points[::5] - origin,
    )
    return replace(table, measured=measured - origin)


@dataclass(frozen=True, eq=False)
class SmoothCurve:
    """Twice continuously differentiable curve y(s), z(s) through noisy points [m], and samples at steps of about SAMPLE."""

    y: BSpline
    z: BSpline
    cut_off: float  # wavelength [m] whose amplitude the smoothing halves
    s: Array  # (n,) arc length of the samples [m]

    @cached_property
    def points(self) -> Array:
        """(n, 2) abscissa and value of the samples [m]."""
        return np.column_stack([self.y(self.s), self.z(self.s)])

    def height(self, y: Array, branch: slice) -> Array:
        """Value [m] at abscissae [m] on a branch where y(s) increases."""
        s = np.interp(y, self.points[branch, 0], self.s[branch])
        for _ in range(4):  # Newton; the start is good to 1e-9 m
            s = s - (self.y(s) - y) / self.y(s, 1)
        return np.asarray(self.z(s))

    def origin(self, branch: slice, kind: ProfileKind) -> Array:
        """The point that becomes (0, 0) [m]: on the tape circle of a wheel, on top of a rail."""
        if kind == "wheel":
            return np.array([0.0, self.height(np.zeros(1), branch)[0]])
        top = branch.start + int(np.argmax(self.points[branch, 1]))
        before, s, after = (self.s[min(max(k, 0), len(self.s) - 1)] for k in (top - 1, top, top + 1))
        if self.z(before, 1) > 0 > self.z(after, 1):
            from scipy.optimize import brentq

            s = brentq(lambda s: float(self.z(s, 1)), before, after)
        return np.array([float(self.y(s)), float(self.z(s))])


def _oriented(course: Course, kind: ProfileKind, inner_side: Side, z_positive: Direction, tape_circle: float) -> Course:
    """The points with the abscissa outward, the value as our tables want it, and in the order of the abscissa."""
    y, z = course.points[:, 0].copy(), course.points[:, 1].copy()
    if kind == "wheel":
        y -= tape_circle
    farthest = int(np.argmax(np.abs(z - np.median(z))))  # tip of a wheel's flange; foot of a rail's flank
    if inner_side == "auto":
        positive = kind == "wheel" and y[farthest] > 0
        inner_side = "positive" if positive else "negative"
    if z_positive == "auto":
        # Both the flange tip of a wheel and the flank of a rail lie below the running surface.
        z_positive = "down" if z[farthest] > np.median(z) else "up"
    if inner_side == "positive":
        y = -y
    if (kind == "wheel") == (z_positive == "up"):
        z = -z
    points = np.column_stack([y, z])
    order = slice(None, None, -1 if y[-1] < y[0] else 1)
    return replace(course, points=points).part(order)


def _check_count(course: Course, which: str) -> None:
    if len(course) < FEWEST_POINTS:
        where = f", near {course.place(0)}" if len(course) else ""
        raise ProfileError(
            f"{course.file}: {len(course)} points are {which}{where}; a profile has at least {FEWEST_POINTS}; are the points in "
            "order along the profile, and z_positive and inner_side right?"
        )


def _check_wheel(course: Course, require_flange: bool) -> None:
    file, (y, z) = course.file, course.points.T
    if not y.min() < 0 < y.max():
        raise ProfileError(
            f"{file}: the tape circle (abscissa 0) is not in the profile, which spans {y.min() * 1e3:.4g} to "
            f"{y.max() * 1e3:.4g} mm; set tape_circle to its abscissa in the file"
        )
    height = float(np.max(z[y < 0]) - z[np.argmin(np.abs(y))]) + 0.0
    if require_flange and height < FLANGE_HEIGHT:
        raise ProfileError(
            f"{file}: no flange: the radius rises {height * 1e3:.4g} mm towards the inner side; at least "
            f"{FLANGE_HEIGHT * 1e3:g} mm expected; check inner_side and z_positive, or set require_flange = false"
        )


def _reference(points: Array, kind: ProfileKind) -> int:
    """Index of the point that the usable branch grows from: tape circle or highest point."""
    return int(np.argmin(np.abs(points[:, 0])) if kind == "wheel" else np.argmax(points[:, 1]))


def _relevant(course: Course, kind: ProfileKind, noise: float) -> Course:
    """The stretch around the running surface: without a rail's web and foot, or a wheel's outer chamfer."""
    points = course.points
    first, last = 0, len(points)
    if kind == "wheel":
        means = averaged(course, noise).points
        edge = (means[:, 0] > RUN_OUT) & (np.abs(direction_jumps(means)) > LARGEST_KINK)
        if np.any(edge):
            last = int(np.argmax(points[:, 0] >= means[np.argmax(edge), 0]))
    else:
        top = int(np.argmax(points[:, 1]))
        deep = np.flatnonzero(points[:, 1] < points[top, 1] - RAIL_DEPTH)
        first = max((int(i) + 1 for i in deep if i < top), default=first)
        last = min((int(i) for i in deep if i > top), default=last)
    return course.part(slice(first, last))


def _smooth(points: Array, weights: Array, noise: float, smoothing: float | Literal["auto"]) -> SmoothCurve:
    """Smoothing splines y(s) and z(s) over the chord length s.

    Each minimises  integral (p - f)^2 ds + lambda integral f''^2 ds,  a low-pass of gain 1/(1 + (k/k_c)^4) in
    the wave number k, with lambda = k_c^-4 and the cut-off wavelength 2 pi/k_c.
    """
    chord = np.hypot(*np.diff(points, axis=0).T)
    s = np.concatenate(([0.0], np.cumsum(chord)))
    share = np.gradient(s)  # what each point stands for along the curve [m]
    spacing = float(s[-1]) / (len(s) - 1)
    if smoothing == "auto":
        # White noise at this spacing leaves, after the low-pass, a curvature noise of
        #   var = noise^2 spacing k_c^5 /(2 pi) * integral u^4/(1+u^4)^2 du = 0.0884 noise^2 spacing k_c^5.
        k_c = (CURVATURE_NOISE**2 / (0.0884 * max(noise, 1e-12) ** 2 * spacing)) ** 0.2
        cut_off = float(np.clip(2 * math.pi / k_c, spacing, LONGEST_CUT_OFF))
    else:
        cut_off = smoothing
    k_c = 2 * math.pi / cut_off
    unit = 1e-3  # in millimetres the equations are far better conditioned
    w = share * weights / spacing
    lam = (k_c * unit) ** -4 / (spacing / unit)
    from scipy.interpolate import make_smoothing_spline

    y, z = (make_smoothing_spline(s / unit, p / unit, w=np.maximum(w, 1e-9), lam=lam) for p in points.T)
    y, z = (type(one)(one.t * unit, one.c * unit, one.k) for one in (y, z))
    return SmoothCurve(y, z, cut_off, np.linspace(0.0, s[-1], max(2, math.ceil(s[-1] / SAMPLE)) + 1))


def _noise(points: Array) -> float:
    """Standard deviation of the points across the curve [m], from fourth divided differences.

    Those of a smooth curve vanish; the median makes corners and single outliers count little.
    """
    s = np.concatenate(([0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))))
    n = len(s) - 4
    nodes = np.stack([s[k : k + n] for k in range(5)])
    factors = np.stack([1 / np.prod([nodes[k] - nodes[j] for j in range(5) if j != k], axis=0) for k in range(5)])
    factors = factors / np.sqrt(np.sum(factors**2, axis=0))
    deviations = sum(factors[k][:, None] * points[k : k + n] for k in range(5))
    return float(1.4826 * np.median(np.hypot(*np.asarray(deviations).T)))  # 1.4826: median to standard deviation


def _usable_branch(course: Course, curve: SmoothCurve, kind: ProfileKind) -> slice:
    """The stretch around the tape circle or the highest point where the slope is at most STEEPEST_SLOPE.

    Raises:
        ProfileError: it does not reach LEAST_REACH to both sides.
    """
    points, dy, dz = curve.points, curve.y(curve.s, 1), curve.z(curve.s, 1)
    bad = np.flatnonzero((dy <= 0) | (np.abs(dz) > STEEPEST_SLOPE * dy))
    centre = _reference(points, kind)
    start = int(max(bad[bad < centre], default=-1)) + 1
    stop = int(min(bad[bad >= centre], default=len(dy)))
    last = max(stop - 1, start)
    middle = 0.0 if kind == "wheel" else points[centre, 0]
    reaches = ((start, middle - points[start, 0]), (last, points[last, 0] - middle))
    short = [end for end, reach in reaches if reach <= LEAST_REACH]
    if stop - start >= 2 and not short:
        return slice(start, stop)
    end = points[short[0] if short else centre]
    middle_place = course.nearest(np.array([middle, points[centre, 1]]))
    raise ProfileError(
        f"{course.file}: the profile ends, turns back, or is steeper than {STEEPEST_SLOPE:g} at {course.nearest(end)}; needed: "
        f"{1e3 * LEAST_REACH:g} mm on each side of the {'tape circle' if kind == 'wheel' else 'highest point'}, "
        f"{middle_place}; is there a step or a stray point, are the points not in order along the profile, or those of a closed "
        "curve, of which only the running surface is needed?"
    )
