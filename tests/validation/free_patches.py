"""Exact normal contact of one wheel that nobody told where its patches are.

    surfaces, pose -> [overlaps] -> regions -> [framed] a plane and a grid each -> [half-space, coupled] -> patches

The overlaps are found on the surfaces themselves: for each point of the rail's profile, the place of its generator (on a
roller: of its circle) that is deepest inside the wheel. Nothing here comes from the core. Left wheel; mm, N, N/mm2.

Several patches push each other back: a load F moves a place at a distance r by F (1 - nu) / (pi G r), of which the share along
the other plane's normal counts, the cosine between the two.

What a half-space in one plane leaves out where the surfaces turn within the patch (flange root on gauge corner): the pressures'
directions, distances along the surface, interpenetration across. `unrolled` has them, on the rail's own curved surface. Over the
227 poses of data/half_space_pairs.csv with one patch, by `spread`, the root mean square of the angle between the surfaces'
normals and the plane's, weighted with pressure (largest differences of force and of peak pressure):

    spread [rad]    poses    plane of the deepest point     curved surface
                             instead of the mean normal's   instead of the plane
    0    - 0.02      161          0.0 %    0.1 %                0.2 %    0.9 %
    0.02 - 0.05       31          0.0 %    0.1 %                0.3 %    0.9 %
    0.05 - 0.1        26          0.3 %    1.7 %                0.5 %    2.2 %
    0.1  - 0.2         3          0.6 %    2.9 %                1.8 %    6.3 %
    0.2  - 0.38        6          5.7 %   22.8 %                9.1 %   19.7 %
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import product

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from rollerrig.profiles import ProfileTable
from validation.half_space import (
    COMPLIANCE,
    Grid,
    Patch,
    Pose,
    Surfaces,
    along_normal,
    plane_axes,
    pressures,
    unit,
    value_and_slope,
)

Array = NDArray[np.float64]

#: Distance of the points on the rail's profile; the first search along rolling: reach and step.
ARC, REACH, STEP = 0.05, 110.0, 5.0
#: Overlaps are one region if their normals differ by less and the gap between them is less than their mean width.
ONE_PLANE = np.radians(20.0)


@dataclass(frozen=True)
class Region:
    """One overlap: points of the rail around it, the same along the rail and along its profile, its deepest place and the
    normal there, its end points across the rail, and the rail's abscissae between which it is looked for."""

    cloud: Array
    flat: Array
    deepest: Array
    normal: Array
    ends: tuple[Array, Array]
    between: tuple[float, float]

    def holds(self, y: float) -> bool:
        return self.between[0] <= y <= self.between[1]


@lru_cache(maxsize=64)
def profile_points(rail: ProfileTable) -> tuple[Array, Array]:
    """Abscissae at equal distances along the profile, and heights."""
    y = np.linspace(*rail.domain, 20001)
    z = rail.evaluate(y)
    arc = np.concatenate([[0.0], np.cumsum(np.hypot(np.diff(y), np.diff(z)))])
    at = np.interp(np.arange(0.0, arc[-1], 1e-3 * ARC), arc, y)
    return 1e3 * at, 1e3 * rail.evaluate(at)


def on_rail(surfaces: Surfaces, pose: Pose, x: Array, y: Array, height: Array) -> Array:
    """Places over points of the profile; x along the rail or, from its top, along the roller's circle."""
    across, radius = y + surfaces.origin, pose.roller_radius
    if radius is None:
        return np.stack(np.broadcast_arrays(x, across, height), -1)
    far = radius + height
    return np.stack(np.broadcast_arrays(far * np.sin(x / radius), across, far * np.cos(x / radius) - radius), -1)


def valley(surfaces: Surfaces, pose: Pose) -> tuple[Array, Array, Array]:
    """Of each point of the rail's profile: where along the rail it is deepest inside the wheel, how deep (in the wheel's
    radial direction), and the half-length of the overlap there."""

    y, height = profile_points(surfaces.rail)

    def inside(x: Array) -> Array:
        q = on_rail(surfaces, pose, x, y, height)
        return np.where(surfaces.on_wheel(pose, q), surfaces.inside_wheel(pose, q)[0], -1e3)

    scan = np.array([inside(x + 0 * y) for x in np.arange(-REACH, REACH + STEP, STEP)])
    x = -REACH + STEP * np.clip(scan.argmax(axis=0), 1, len(scan) - 2)
    for step in (STEP, 1.0, 0.2):
        before, here, after = inside(x - step), inside(x), inside(x + step)
        second = np.minimum((before - 2 * here + after) / step**2, -1e-4)
        x = x + np.clip((before - after) / (2 * step * second), -2 * step, 2 * step)
    depth = inside(x)
    return x, depth, np.sqrt(np.maximum(-2 * depth / second, 0.0))


def regions(surfaces: Surfaces, pose: Pose) -> list[Region]:
    """All overlaps of the pose."""
    y, height = profile_points(surfaces.rail)
    x, depth, half = valley(surfaces, pose)
    along = x + np.array([0.0, -1.0, -0.5, 0.5, 1.0])[:, None] * half
    lines = on_rail(surfaces, pose, along, y, height)
    flat = np.stack(np.broadcast_arrays(along, ARC * np.arange(len(y))), -1)

    def region(span: slice) -> Region:
        deepest = lines[0, span][depth[span].argmax()]
        outward, inward = surfaces.above_rail(pose, deepest)[1], surfaces.inside_wheel(pose, deepest)[1]
        normal = unit(unit(outward) + unit(inward))
        ends = (lines[0, span.start], lines[0, span.stop - 1])
        cloud, unrolled = (points[:, span][:, depth[span] > 0] for points in (lines, flat))
        return Region(
            cloud.reshape(-1, 3), unrolled.reshape(-1, 2), deepest, normal, ends, (y[span.start], y[span.stop - 1])
        )

    edges = np.flatnonzero(np.diff(np.concatenate([[False], depth > 0, [False]]).astype(int))).reshape(-1, 2)
    found: list[tuple[slice, Region]] = []
    for first, end in edges:
        span = slice(first, end)
        if found and one_plane(found[-1][1], region(span)):
            span = slice(found.pop()[0].start, end)
        found.append((span, region(span)))
    alone = [one for _, one in found]
    between = [0.5 * (a.between[1] + b.between[0]) for a, b in zip(alone, alone[1:], strict=False)]
    limits = [-np.inf, *between, np.inf]
    return [replace(one, between=(limits[i], limits[i + 1])) for i, one in enumerate(alone)]


def one_plane(a: Region, b: Region) -> bool:
    """Whether two neighbours are pressed in a common plane."""
    gap = np.linalg.norm(b.ends[0] - a.ends[1])
    width = 0.5 * (np.linalg.norm(a.ends[1] - a.ends[0]) + np.linalg.norm(b.ends[1] - b.ends[0]))
    return bool(gap < width and a.normal @ b.normal > np.cos(ONE_PLANE))


def around(cloud: Array, normal: Array, count: tuple[int, int], margin: float) -> Grid:
    """The smallest grid in the direction of the points' principal axes."""
    (xx, xy), (_, yy) = np.cov(plane_axes(normal) @ cloud.T)
    turn = 0.5 * float(np.arctan2(2 * xy, xx - yy) if xx > yy else np.arctan2(-2 * xy, yy - xx))
    axes = Grid(cloud[0], normal, (1.0, 1.0), turn=turn).axes
    low, high = (cloud @ axes.T).min(axis=0), (cloud @ axes.T).max(axis=0)
    point = cloud[0] + (0.5 * (low + high) - cloud[0] @ axes.T) @ axes
    half = 0.5 * (high - low) * (1 + margin) + 1e-3
    return Grid(point, normal, (float(half[0]), float(half[1])), count, turn)


def press(surfaces: Surfaces, pose: Pose, region: Region, grid: Grid, others: list[Patch], tolerance: float) -> Patch:
    """One region alone, pushed back by the other patches' loads."""
    depth, normals, y = surfaces.overlap(pose, grid)
    depth = np.where((y >= region.between[0]) & (y <= region.between[1]), depth, -1.0)
    undeformed = depth
    for other in others:
        depth = depth - pushed_back(grid.places(), grid.normal, other)
    p = pressures(depth, grid.spacing, tolerance) if (depth > 0).any() else np.zeros_like(depth)
    return Patch(grid, p, undeformed, normals)


def pushed_back(places: Array, normals: Array, other: Patch, blocks: int = 6) -> Array:
    """By another patch's pressures, as some loads on a half-space, and of that the share in the direction of the normals."""
    total = np.zeros(places.shape[:2])
    rows, columns = (np.array_split(np.arange(n), blocks) for n in other.grid.count)
    sources = other.grid.places()
    for i, j in product(rows, columns):
        p = other.pressures[np.ix_(i, j)]
        if p.any():
            source = np.tensordot(p / p.sum(), sources[np.ix_(i, j)], 2)
            total += p.sum() * other.cell / np.linalg.norm(places - source, axis=-1)
    return np.asarray(COMPLIANCE * np.maximum(normals @ other.grid.normal, 0.0) * total)


def framed(surfaces: Surfaces, pose: Pose, region: Region, cells: int, others: list[Patch], tolerance: float) -> Patch:
    """In the plane of the deepest point, then in that of the mean normal; the grid as small as the patch."""
    grid = around(region.cloud, region.normal, (cells, cells), 0.05)
    for margin in (0.1, 0.1):
        patch = press(surfaces, pose, region, grid, others, 1e-2)
        if not patch.force:
            return patch
        held = patch.pressures > 0
        if held.sum() < 4:  # a patch that the others nearly lift off: of so few cells the extent is not known
            held = ndimage.binary_dilation(held)
        loaded = patch.grid.places()[held]
        grid = around(loaded, patch.mean_normal, (cells, cells), margin + 2.5 / np.sqrt(len(loaded)))
    return press(surfaces, pose, region, grid, others, tolerance)


def unrolled(
    surfaces: Surfaces, pose: Pose, region: Region, others: list[Patch], cells: int = 56, tolerance: float = 1e-5
) -> tuple[Array, float]:
    """Force vector and largest pressure of a region on the rail's own curved surface: interpenetration along its normals,
    distances along rail and profile, of a deflection the share in the direction of the other place's normal."""
    y, _ = profile_points(surfaces.rail)
    arc, radius = ARC * np.arange(len(y)), pose.roller_radius
    scale = np.array([1.0 + region.deepest[2] / radius if radius else 1.0, 1.0])
    grid = around(np.pad(region.flat * scale, [(0, 0), (0, 1)]), np.array([0.0, 0.0, 1.0]), (cells, cells), 0.05)
    for accuracy in (1e-2, 1e-2, tolerance):
        flat = grid.places()[..., :2] / scale
        at = np.interp(flat[..., 1], arc, y)
        q = on_rail(surfaces, pose, flat[..., 0], at, value_and_slope(surfaces.rail, at)[0])
        normals = unit(surfaces.above_rail(pose, q)[1])
        down, _ = along_normal(lambda at: surfaces.inside_wheel(pose, at), q, normals)
        known = surfaces.on_wheel(pose, q + down[..., None] * normals) & (flat[..., 1] > 0) & (flat[..., 1] < arc[-1])
        known &= (at >= region.between[0]) & (at <= region.between[1])
        depth = np.where(known, -down, -1.0) - sum(pushed_back(q, normals, other) for other in others)
        if not (depth > 0).any():
            return np.zeros(3), 0.0
        p = pressures(depth, grid.spacing, accuracy, normals)
        force = np.tensordot(p, normals, 2) * grid.spacing[0] * grid.spacing[1]
        loaded = grid.places()[p > 0]
        grid = around(loaded, grid.normal, grid.count, 0.1 + 2.5 / np.sqrt(len(loaded)))
    return force, float(p.max())


def patches(surfaces: Surfaces, pose: Pose, cells: int = 56, tolerance: float = 1e-5) -> list[Patch]:
    """All patches of the wheel that carry load."""
    found = regions(surfaces, pose)
    pressed = [framed(surfaces, pose, region, cells, [], tolerance) for region in found]
    for again in range(4 if len(found) > 1 else 0):
        for i, region in enumerate(found):
            others = [one for one in pressed[:i] + pressed[i + 1 :] if one.force]
            if again < 2:
                pressed[i] = framed(surfaces, pose, region, cells, others, tolerance)
            elif pressed[i].force:
                pressed[i] = press(surfaces, pose, region, pressed[i].grid, others, tolerance)
    return [patch for patch in pressed if patch.force]


def curved(surfaces: Surfaces, pose: Pose, pressed: list[Patch], cells: int = 56) -> tuple[float, float]:
    """Force and largest pressure of the patches on the rail's curved surface."""
    answers = [
        unrolled(
            surfaces, pose, region, [one for one in pressed if not region.holds(one.centre[1] - surfaces.origin)], cells
        )
        for region in regions(surfaces, pose)
    ]
    return float(sum(np.linalg.norm(force) for force, _ in answers)), max(peak for _, peak in answers)


def touch(surfaces: Surfaces, pose: Pose) -> tuple[Pose, Array, Array]:
    """The pose at the height where the rigid surfaces touch; the place on the rail and the normal there."""
    y, height = profile_points(surfaces.rail)
    for _ in range(8):
        x, depth, _ = valley(surfaces, pose)
        place = on_rail(surfaces, pose, x, y, height)[depth.argmax()]
        rise = depth.max() / surfaces.inside_wheel(pose, place)[1][2]
        pose = replace(pose, height=float(pose.height + rise))
        if abs(rise) < 1e-5:
            break
    return pose, place, unit(surfaces.above_rail(pose, place)[1])


def lowered(surfaces: Surfaces, pose: Pose, force: float, error: float = 0.1) -> Pose:
    """The pose at the height where its patches carry about a force, as if it went with the depth to the power 3/2."""
    pose, _, _ = touch(surfaces, pose)
    top, depth = pose.height, 0.03 * (force / 1e4) ** (2 / 3)
    for _ in range(12):
        pose = replace(pose, height=top - depth)
        carried = sum(patch.force for patch in patches(surfaces, pose, 24, 1e-3))
        if abs(carried / force - 1) < error:
            break
        depth *= float(np.clip((force / max(carried, 1e-3)) ** (2 / 3), 0.3, 3.0))
    return pose
