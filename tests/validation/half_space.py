"""Exact normal contact of two elastic half-spaces, for poses that the reference tables do not have.

The undeformed gap between wheel and rail is taken on a grid of the tangent plane, along the normal, from the profiles' splines
and the surfaces of revolution themselves; the pressures follow from Boussinesq's solution on rectangles (Love 1929) by the
conjugate gradients of Polonsky and Keer (Wear 231, 1999), convolutions by FFT. Nothing here uses the core's contact geometry
but for a contact point to put the grid at. Left wheel; mm, N, N/mm2.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rollerrig.profiles import ProfileTable, profile_from_spec
from validation.reference import POISSON_RATIO, SHEAR_MODULUS, rail_origin

Array = NDArray[np.float64]
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
class Solution:
    """Pressures on the grid and what follows from them."""

    force: float
    pressure: float  # largest
    area: float
    approach: float  # largest interpenetration
    length: float  # along the rolling direction
    width: float  # across it
    centre: tuple[float, float, float]  # of the pressures, on the tangent plane


@dataclass(frozen=True)
class Grid:
    """Tangent plane at a point: `half` sizes along and across, `count` of rectangles."""

    point: Array
    normal: Array  # out of the roller
    half: tuple[float, float]
    count: tuple[int, int] = (128, 96)

    @property
    def spacing(self) -> tuple[float, float]:
        return 2 * self.half[0] / self.count[0], 2 * self.half[1] / self.count[1]

    def places(self) -> Array:
        along = np.cross([0.0, 1.0, 0.0], self.normal)
        along /= np.linalg.norm(along)
        across = np.cross(self.normal, along)
        u, v = (
            -half + (np.arange(n) + 0.5) * d for half, n, d in zip(self.half, self.count, self.spacing, strict=True)
        )
        return np.asarray(self.point + u[:, None, None] * along + v[None, :, None] * across)


class Surfaces:
    """S1002 above UIC60 1:40 of the contact benchmark."""

    def __init__(self) -> None:
        self.wheel, self.rail = profile_from_spec("s1002", "wheel"), profile_from_spec("uic60_benchmark_1_40", "rail")
        self.origin = 1e3 * rail_origin(self.rail)

    def interpenetration(self, pose: Pose, grid: Grid) -> Array:
        """Of the undeformed surfaces along the grid's normal."""
        places = grid.places()

        def above_rail(q: Array) -> tuple[Array, Array]:
            height, slope = value_and_slope(self.rail, q[..., 1] - self.origin)
            radius = pose.roller_radius
            if radius is None:
                return q[..., 2] - height, np.stack([0 * slope, -slope, 1 + 0 * slope], -1)
            far = np.hypot(q[..., 0], q[..., 2] + radius)
            return far - radius - height, np.stack([q[..., 0] / far, -slope, (q[..., 2] + radius) / far], -1)

        def inside_wheel(q: Array) -> tuple[Array, Array]:
            local = (q - pose.centre) @ pose.rotation
            rise, slope = value_and_slope(self.wheel, local[..., 1] - TAPE_CIRCLE)
            far = np.hypot(local[..., 0], local[..., 2])
            gradient = np.stack([-local[..., 0] / far, slope, -local[..., 2] / far], -1)
            return WHEEL_RADIUS + rise - far, gradient @ pose.rotation.T

        return along_normal(above_rail, places, grid.normal) - along_normal(inside_wheel, places, grid.normal)


def value_and_slope(table: ProfileTable, abscissa: Array) -> tuple[Array, Array]:
    """Of a profile at an abscissa [mm]."""
    at = 1e-3 * np.asarray(abscissa)
    piece = np.clip(np.floor((at - table.start) / table.step).astype(int), 0, len(table.coefficients) - 1)
    t = at - (table.start + table.step * piece)
    c = np.moveaxis(table.coefficients[piece], -1, 0)
    return 1e3 * (c[0] + t * (c[1] + t * (c[2] + t * c[3]))), c[1] + t * (2 * c[2] + t * 3 * c[3])


def along_normal(surface, places: Array, normal: Array) -> Array:  # type: ignore[no-untyped-def]
    """Distance along the normal from each place to a surface given by its value and gradient: Newton."""
    distance = np.zeros(places.shape[:-1])
    for _ in range(20):
        value, gradient = surface(places + distance[..., None] * normal)
        distance -= np.clip(value / (gradient @ normal), -1.0, 1.0)
    return distance


def pressures(depth: Array, spacing: tuple[float, float]) -> Array:
    """Pressures of two half-spaces that are pressed together so that they would overlap by `depth`."""
    n, m = depth.shape
    x, y = (np.arange(-k, k) * d for k, d in zip((n, m), spacing, strict=True))
    influence = np.zeros((2 * n, 2 * m))
    for i in (-1, 1):
        for j in (-1, 1):
            px, py = np.meshgrid(x + 0.5 * i * spacing[0], y + 0.5 * j * spacing[1], indexing="ij")
            influence += i * j * (px * np.arcsinh(py / np.abs(px)) + py * np.arcsinh(px / np.abs(py)))
    spectrum = np.fft.rfft2(np.roll(COMPLIANCE * influence, (-n, -m), (0, 1)))

    def deflection(p: Array) -> Array:
        return np.asarray(np.fft.irfft2(np.fft.rfft2(p, (2 * n, 2 * m)) * spectrum, (2 * n, 2 * m))[:n, :m])

    p = np.where(depth > 0, 1.0, 0.0)
    p *= (p * depth).sum() / (p * deflection(p)).sum()
    direction, last, conjugate = np.zeros_like(p), 1.0, 0.0
    for _ in range(1000):
        residual, loaded = deflection(p) - depth, p > 0
        square = (residual[loaded] ** 2).sum()
        direction = np.where(loaded, residual + conjugate * square / last * direction, 0.0)
        last = square
        step = (residual * direction)[loaded].sum() / (direction * deflection(direction))[loaded].sum()
        new = np.maximum(p - step * direction, 0.0)
        overlapping = (new == 0) & (residual < 0)
        new[overlapping] -= step * residual[overlapping]
        conjugate = 0.0 if overlapping.any() else 1.0
        change, p = np.abs(new - p).sum() / new.sum(), new
        if change < 1e-7:
            return p
    raise RuntimeError("half-space contact did not converge")


def solve(surfaces: Surfaces, pose: Pose, grid: Grid) -> Solution:
    """One pose; the grid must hold the whole patch."""
    depth = surfaces.interpenetration(pose, grid)
    if not (depth > 0).any():
        return Solution(0.0, 0.0, 0.0, float(depth.max()), 0.0, 0.0, (np.nan,) * 3)
    p = pressures(depth, grid.spacing)
    loaded = p > 0
    if loaded[[0, -1]].any() or loaded[:, [0, -1]].any():
        raise ValueError("the grid is too small")
    cell = grid.spacing[0] * grid.spacing[1]
    x, y, z = np.tensordot(p / p.sum(), grid.places(), 2)
    return Solution(
        float(p.sum() * cell),
        float(p.max()),
        float(loaded.sum() * cell),
        float(depth.max()),
        float(loaded.any(axis=1).sum() * grid.spacing[0]),
        float(loaded.any(axis=0).sum() * grid.spacing[1]),
        (float(x), float(y), float(z)),
    )
