"""Exact normal contact of two elastic half-spaces, for poses that the reference tables do not have.

The undeformed gap between wheel and rail is taken on a grid of the tangent plane, along the normal, from the profiles' splines
and the surfaces of revolution themselves; the pressures follow from Boussinesq's solution on rectangles (Love 1929) by the
conjugate gradients of Polonsky and Keer (Wear 231, 1999), convolutions by FFT. Nothing here uses the core's contact geometry
but for a contact point to put the grid at. Left wheel; mm, N, N/mm2.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property, lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy import fft

from catalogued import profile_table
from rollerrig.profiles import ProfileTable
from validation.reference import POISSON_RATIO, SHEAR_MODULUS, rail_origin

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]
Surface = Callable[[Array], tuple[Array, Array]]
WHEEL_RADIUS, TAPE_CIRCLE = 460.0, 750.0
COMPLIANCE = (1.0 - POISSON_RATIO) / (np.pi * SHEAR_MODULUS * 1e-6)


@dataclass(frozen=True)
class Pose:
    """Wheelset on rails or rollers: centre at (x, y, height + 460), in the frame of the crown or the rail's top."""

    y: float
    height: float
    yaw: float
    roll: float = 0.0
    roller_radius: float | None = None
    x: float = 0.0

    @property
    def centre(self) -> Array:
        return np.array([self.x, self.y, WHEEL_RADIUS + self.height])

    @property
    def rotation(self) -> Array:
        c, s = np.cos(self.yaw), np.sin(self.yaw)
        u, v = np.cos(self.roll), np.sin(self.roll)
        return np.array([[c, -s * u, s * v], [s, c * u, -c * v], [0.0, v, u]])


@dataclass(frozen=True)
class Grid:
    """Tangent plane at a point: `half` sizes along and across, `count` of rectangles, turned by an angle from rolling."""

    point: Array
    normal: Array  # out of the roller
    half: tuple[float, float]
    count: tuple[int, int] = (128, 96)
    turn: float = 0.0

    @property
    def spacing(self) -> tuple[float, float]:
        return 2 * self.half[0] / self.count[0], 2 * self.half[1] / self.count[1]

    @property
    def axes(self) -> Array:
        """Of the rectangles, in rows."""
        c, s = np.cos(self.turn), np.sin(self.turn)
        return np.array([[c, s], [-s, c]]) @ plane_axes(self.normal)

    def places(self) -> Array:
        along, across = self.axes
        u, v = (
            -half + (np.arange(n) + 0.5) * d for half, n, d in zip(self.half, self.count, self.spacing, strict=True)
        )
        return np.asarray(self.point + u[:, None, None] * along + v[None, :, None] * across)


def plane_axes(normal: Array) -> Array:
    """Rolling direction in a plane and the one across it, in rows."""
    along = np.cross([0.0, 1.0, 0.0], normal)
    along /= np.linalg.norm(along)
    return np.array([along, np.cross(normal, along)])


@dataclass(frozen=True)
class Solution:
    """What follows from the pressures."""

    force: float
    pressure: float  # largest
    area: float
    approach: float  # largest interpenetration
    length: float  # along the rolling direction
    width: float  # across it
    centre: tuple[float, float, float]  # of the pressures, on the tangent plane


@dataclass(frozen=True)
class Patch:
    """One plane's pressures: interpenetration less what other patches push the surfaces back, normals of the surfaces."""

    grid: Grid
    pressures: Array
    depth: Array
    normals: Array

    @property
    def cell(self) -> float:
        return self.grid.spacing[0] * self.grid.spacing[1]

    @property
    def force(self) -> float:
        return float(self.pressures.sum() * self.cell)

    @property
    def centre(self) -> Array:
        return np.tensordot(self.pressures / self.pressures.sum(), self.grid.places(), 2)

    @property
    def mean_normal(self) -> Array:
        """Of the surfaces, weighted with pressure."""
        return unit(np.tensordot(self.pressures, self.normals, 2))

    @property
    def spread(self) -> float:
        """Angle between the surfaces' normals and the plane's: root mean square, weighted with pressure [rad]."""
        cosine = np.clip(self.normals @ self.grid.normal, -1.0, 1.0)
        return float(np.sqrt((self.pressures * np.arccos(cosine) ** 2).sum() / self.pressures.sum()))

    def solution(self) -> Solution:
        loaded = self.pressures > 0
        places = self.grid.places()[loaded] @ plane_axes(self.grid.normal).T
        length, width = np.ptp(places, axis=0) + np.abs(self.grid.spacing @ turned(self.grid.turn))
        x, y, z = (float(c) for c in self.centre)
        return Solution(
            self.force, float(self.pressures.max()), float(loaded.sum() * self.cell), float(self.depth.max()),
            float(length), float(width), (x, y, z),
        )  # fmt: skip


def unit(v: Array) -> Array:
    return np.asarray(v / np.linalg.norm(v, axis=-1, keepdims=True))


def turned(angle: float) -> Array:
    return np.abs([[np.cos(angle), np.sin(angle)], [np.sin(angle), np.cos(angle)]])


@dataclass(frozen=True, eq=False)
class Surfaces:
    """A wheel above a rail or roller; S1002 above UIC60 1:40 of the contact benchmark if nothing else is said."""

    wheel: ProfileTable = field(default_factory=lambda: profile_table("s1002", "wheel"))
    rail: ProfileTable = field(default_factory=lambda: profile_table("uic60_benchmark_1_40", "rail"))
    place: float | None = None  # of the rail's origin across [m]; by default for the gauge

    @cached_property
    def origin(self) -> float:
        return 1e3 * (rail_origin(self.rail) if self.place is None else self.place)

    def above_rail(self, pose: Pose, q: Array) -> tuple[Array, Array]:
        """Height above the rail or the roller's surface (positive outside) and its gradient."""
        height, slope = value_and_slope(self.rail, q[..., 1] - self.origin)
        radius = pose.roller_radius
        if radius is None:
            return q[..., 2] - height, np.stack([0 * slope, -slope, 1 + 0 * slope], -1)
        far = np.hypot(q[..., 0], q[..., 2] + radius)
        return far - radius - height, np.stack([q[..., 0] / far, -slope, (q[..., 2] + radius) / far], -1)

    def inside_wheel(self, pose: Pose, q: Array) -> tuple[Array, Array]:
        """How far inside the wheel (positive), in its radial direction, and the gradient."""
        local = (q - pose.centre) @ pose.rotation
        rise, slope = value_and_slope(self.wheel, local[..., 1] - TAPE_CIRCLE)
        far = np.hypot(local[..., 0], local[..., 2])
        gradient = np.stack([-local[..., 0] / far, slope, -local[..., 2] / far], -1)
        return WHEEL_RADIUS + rise - far, gradient @ pose.rotation.T

    def on_wheel(self, pose: Pose, q: Array) -> Flags:
        """Whether the wheel's profile says what is there."""
        return within(self.wheel, ((q - pose.centre) @ pose.rotation)[..., 1] - TAPE_CIRCLE)

    def interpenetration(self, pose: Pose, grid: Grid) -> Array:
        """Of the undeformed surfaces along the grid's normal."""
        return self.overlap(pose, grid)[0]

    def on_rail(self, pose: Pose, place: Array, normal: Array) -> Array:
        """Point of the rail or the roller on a line of action."""
        distance, _ = along_normal(lambda q: self.above_rail(pose, q), place, normal)
        return np.asarray(place + distance[..., None] * normal)

    def overlap(self, pose: Pose, grid: Grid) -> tuple[Array, Array, Array]:
        """Interpenetration, mean of the surfaces' normals, abscissa on the rail; -1 beyond the profiles' ends."""
        places = grid.places()
        up, rail_normal = along_normal(lambda q: self.above_rail(pose, q), places, grid.normal)
        down, wheel_normal = along_normal(lambda q: self.inside_wheel(pose, q), places, grid.normal)
        y = (places + up[..., None] * grid.normal)[..., 1] - self.origin
        known = within(self.rail, y) & self.on_wheel(pose, places + down[..., None] * grid.normal)
        return np.where(known, up - down, -1.0), unit(unit(rail_normal) + unit(wheel_normal)), y


def within(table: ProfileTable, abscissa: Array) -> Flags:
    low, high = table.domain
    return np.asarray((abscissa >= 1e3 * low) & (abscissa <= 1e3 * high))


def value_and_slope(table: ProfileTable, abscissa: Array) -> tuple[Array, Array]:
    """Of a profile at an abscissa [mm]."""
    at = 1e-3 * np.asarray(abscissa)
    piece = np.clip(np.floor((at - table.start) / table.step).astype(int), 0, len(table.coefficients) - 1)
    t = at - (table.start + table.step * piece)
    c = np.moveaxis(table.coefficients[piece], -1, 0)
    return 1e3 * (c[0] + t * (c[1] + t * (c[2] + t * c[3]))), c[1] + t * (2 * c[2] + t * 3 * c[3])


def along_normal(surface: Surface, places: Array, normal: Array) -> tuple[Array, Array]:
    """Distance along the normal from each place to a surface given by its value and gradient, and the gradient: Newton."""
    distance = np.zeros(places.shape[:-1])
    for _ in range(20):
        value, gradient = surface(places + distance[..., None] * normal)
        step = np.clip(value / (gradient * normal).sum(-1), -1.0, 1.0)
        distance -= step
        if np.abs(step).max() < 1e-7:  # the next would be its square over millimetres
            break
    return distance, np.asarray(gradient)


@lru_cache(maxsize=64)
def spectrum(n: int, m: int, ratio: float) -> Array:
    """Of the deflections of rectangles 1 by `ratio` under a pressure of 1 (Love), without the compliance."""
    x, y = np.arange(-n, n), np.arange(-m, m) * ratio
    influence = np.zeros((2 * n, 2 * m))
    for i in (-1, 1):
        for j in (-1, 1):
            px, py = np.meshgrid(x + 0.5 * i, y + 0.5 * j * ratio, indexing="ij")
            influence += i * j * (px * np.arcsinh(py / np.abs(px)) + py * np.arcsinh(px / np.abs(py)))
    return np.asarray(fft.rfft2(np.roll(influence, (-n, -m), (0, 1))))


def pressures(
    depth: Array, spacing: tuple[float, float], tolerance: float = 1e-7, normals: Array | None = None
) -> Array:
    """Pressures of two half-spaces that are pressed together so that they would overlap by `depth`.

    With `normals` of a curved surface, of which a load's share in the direction of another place's normal deflects it.
    """
    n, m = depth.shape
    influence = COMPLIANCE * spacing[0] * spectrum(n, m, spacing[1] / spacing[0])
    shares = [np.ones_like(depth)] if normals is None else [c for c in np.moveaxis(normals, -1, 0) if c.any()]

    def deflection(p: Array) -> Array:
        return np.asarray(
            sum(c * fft.irfft2(fft.rfft2(c * p, (2 * n, 2 * m)) * influence, (2 * n, 2 * m))[:n, :m] for c in shares)
        )

    p = np.where(depth > 0, 1.0, 0.0)
    p *= (p * depth).sum() / (p * deflection(p)).sum()
    direction, last, conjugate = np.zeros_like(p), 1.0, 0.0
    for _ in range(1000):
        residual, loaded = deflection(p) - depth, p > 0
        square = (residual[loaded] ** 2).sum()
        if square == 0.0:  # a single cell
            return p
        direction = np.where(loaded, residual + conjugate * square / last * direction, 0.0)
        last = square
        step = (residual * direction)[loaded].sum() / (direction * deflection(direction))[loaded].sum()
        new = np.maximum(p - step * direction, 0.0)
        overlapping = (new == 0) & (residual < 0)
        new[overlapping] -= step * residual[overlapping]
        conjugate = 0.0 if overlapping.any() else 1.0
        change, p = np.abs(new - p).sum() / new.sum(), new
        if change < tolerance:
            return p
    raise RuntimeError("half-space contact did not converge")


def solve(surfaces: Surfaces, pose: Pose, grid: Grid) -> Solution:
    """One pose; the grid must hold the whole patch."""
    depth, normals, _ = surfaces.overlap(pose, grid)
    if not (depth > 0).any():
        return Solution(0.0, 0.0, 0.0, float(depth.max()), 0.0, 0.0, (np.nan,) * 3)
    patch = Patch(grid, pressures(depth, grid.spacing), depth, normals)
    loaded = patch.pressures > 0
    if loaded[[0, -1]].any() or loaded[:, [0, -1]].any():
        raise ValueError("the grid is too small")
    return patch.solution()
