"""Creep forces of bent patches by the exact theory: half-space pressures on the rail's curved surface, in rows along rolling,
each with the rigid slip and the spin of its own place and normal. Left wheel; mm, N, rad/mm.

    pose -> curved half-space -> [bent_rows] -> rows -> [exact_wrench] exact solver -> wrench over motions: data/bent_creep.csv

The surfaces are those of a half-space rolled out along the rail: what bending does to their elasticity is left out, what it
does to slip, spin and the directions of forces is exact.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rollerrig import _core
from validation.free_patches import ARC, Region, on_rail, patches, profile_points, pushed_back, regions
from validation.half_space import Patch, Pose, Surfaces, along_normal, pressures, unit, value_and_slope
from validation.half_space_pairs import PairPose, read, surfaces_of
from validation.reference import POISSON_RATIO, SHEAR_MODULUS

Array = NDArray[np.float64]

FILE = "bent_creep.csv"
FRICTION = 0.3
ROWS, CELLS, ELEMENTS = 22, 72, 18
#: Poses of half_space_pairs.csv with so much spread, and every so manieth of the others.
BENT, EVERY = 0.045, 12
#: Of the creepage that demands mu N: along and across at the centre, in so many directions; and rolling at the pose's own yaw.
SIZES, DIRECTIONS, YAWED = (0.3, 0.8, 2.0), 4, (-0.8, 0.0, 0.8)
STIFFNESS = SHEAR_MODULUS * 1e-6
COLUMNS = ("pose", "spread", "load", "yawed", "length", *(f"{v}_{c}" for v in ("c", "v", "w", "f", "m") for c in "xyz"))


@dataclass(frozen=True)
class BentRows:
    """Per row: place along the arc and along rolling, half-length, load, point on the rail, normal there; `spacing` of rows."""

    rows: Array
    spacing: float

    @property
    def loads(self) -> Array:
        return self.rows[:, 3]

    @property
    def points(self) -> Array:
        return self.rows[:, 4:7]

    @property
    def normals(self) -> Array:
        return self.rows[:, 7:10]

    @property
    def area(self) -> float:
        return float(2 * self.rows[:, 2].sum() * self.spacing * np.pi / 4)

    @property
    def centre(self) -> Array:
        return np.asarray(self.loads @ self.points / self.loads.sum())


@dataclass(frozen=True)
class Motion:
    """Velocity of the wheel against the rail or roller over the rolling speed, at a place, and its angular velocity over that."""

    place: Array
    slip: Array
    turning: Array
    yawed: bool = False


def axes(normal: Array) -> tuple[Array, Array]:
    """Rolling direction in the plane of a normal, and to its left."""
    t = unit(np.stack([0 * normal[..., 0], normal[..., 2], -normal[..., 1]], -1))
    return np.cross(t, normal), t


def bent_rows(surfaces: Surfaces, pose: Pose, region: Region, others: list[Patch]) -> BentRows:
    """Pressures along the surface of the rail or roller, in columns of equal width along its profile."""
    y, _ = profile_points(surfaces.rail)
    arc, radius = ARC * np.arange(len(y)), pose.roller_radius
    scale = np.array([1.0 + region.deepest[2] / radius if radius else 1.0, 1.0])
    low, high = (region.flat * scale).min(axis=0), (region.flat * scale).max(axis=0)
    for tolerance, columns in ((1e-2, CELLS), (1e-2, CELLS), (1e-5, ROWS + 4)):
        half = 0.5 * (high - low) * np.array([1.2, 1.2 if tolerance > 1e-3 else (ROWS + 4) / ROWS]) + 1e-3
        count = np.array([CELLS, columns])
        d = 2 * half / count
        u, s = (m - h + (np.arange(n) + 0.5) * e for m, h, n, e in zip(0.5 * (low + high), half, count, d, strict=True))
        along, across = np.meshgrid(u, s, indexing="ij")
        at = np.interp(across, arc, y)
        q = on_rail(surfaces, pose, along / scale[0], at, value_and_slope(surfaces.rail, at)[0])
        normals = unit(surfaces.above_rail(pose, q)[1])
        down = along_normal(lambda place: surfaces.inside_wheel(pose, place), q, normals)[0]
        known = surfaces.on_wheel(pose, q + down[..., None] * normals) & (across > 0) & (across < arc[-1])
        known &= (at >= region.between[0]) & (at <= region.between[1])
        depth = np.where(known, -down, -1.0) - sum(pushed_back(q, normals, other) for other in others)
        p = pressures(depth, (float(d[0]), float(d[1])), tolerance, normals)
        loaded = p > 0
        low = np.array([along[loaded].min(), across[loaded].min()]) - 0.5 * d
        high = np.array([along[loaded].max(), across[loaded].max()]) + 0.5 * d
    if loaded[[0, -1]].any() or loaded[:, [0, -1]].any():
        raise ValueError("the grid is too small")
    rows = []
    for column, place, height in zip(p.T, s, np.interp(s, arc, y), strict=True):
        if (column > 0).sum() < 3:
            continue
        middle = column @ u / column.sum()
        half_length = 2 * np.sqrt(column @ (u - middle) ** 2 / column.sum())
        on_top = np.array(height)
        point = on_rail(surfaces, pose, np.array(middle / scale[0]), on_top, value_and_slope(surfaces.rail, on_top)[0])
        normal = unit(surfaces.above_rail(pose, point)[1])
        rows.append([place, middle, half_length, column.sum() * d[0] * d[1], *point, *normal])
    return BentRows(np.array(rows), float(d[1]))


def wheel_rows(surfaces: Surfaces, pose: Pose) -> list[BentRows]:
    """Of all patches of the wheel that carry a hundredth of the load or more."""
    pressed = patches(surfaces, pose)
    total = sum(patch.force for patch in pressed)
    heavy = [patch for patch in pressed if patch.force > 0.01 * total]
    of_patch = []
    for region in regions(surfaces, pose):
        own = [patch for patch in heavy if region.holds(patch.centre[1] - surfaces.origin)]
        if own:
            others = [patch for patch in pressed if all(patch is not one for one in own)]
            of_patch.append(bent_rows(surfaces, pose, region, others))
    return of_patch


def exact_wrench(patch: BentRows, solver: _core.RollingReference, motion: Motion) -> Array:
    """Force over mu N and moment about the motion's place over mu N; whether the solver converged. Shape (7,)"""
    i, t = axes(patch.normals)
    velocity = motion.slip + np.cross(motion.turning, patch.points - motion.place)
    spin = patch.normals @ motion.turning
    ahead = patch.rows[:, 1] - patch.loads @ patch.rows[:, 1] / patch.loads.sum()
    creepage = np.column_stack([(velocity * i).sum(axis=1), (velocity * t).sum(axis=1) - spin * ahead, spin])
    scale = STIFFNESS / (FRICTION * patch.loads.sum())
    along, across, moment, converged = solver.solve_rows(np.ascontiguousarray(scale * creepage)).T
    force = along[:, None] * i + across[:, None] * t
    arm = patch.points - ahead[:, None] * i - motion.place
    turning = np.cross(arm, force) + moment[:, None] * patch.normals
    return np.array([*force.sum(axis=0), *turning.sum(axis=0), converged.min()])


def solver_of(patch: BentRows) -> _core.RollingReference:
    loads = patch.loads / patch.loads.sum()
    rows = np.column_stack([patch.rows[:, :2] - loads @ patch.rows[:, :2], patch.rows[:, 2:4]])
    return _core.RollingReference.on_rows(np.ascontiguousarray(rows), patch.spacing, POISSON_RATIO, ELEMENTS)


def motions(pose: Pose, heaviest: BentRows) -> list[Motion]:
    """Slip in the plane of the heaviest patch from stick to sliding; and rolling at the pose's yaw, with more or less pull."""
    c = heaviest.centre
    i, t = axes(unit(heaviest.loads @ heaviest.normals))
    axle = pose.rotation[:, 1]
    wheel = axle / np.linalg.norm(np.cross(axle, c - pose.centre))
    under, rail = np.zeros(3), np.array([-1.0, 0.0, 0.0])
    if pose.roller_radius:
        under = np.array([0.0, -1.0 / np.hypot(c[0], c[2] + pose.roller_radius), 0.0])
        rail = np.cross(under, c - [0.0, c[1], -pose.roller_radius])
    own = np.cross(wheel, c - pose.centre) - rail
    demand = np.pi * FRICTION * heaviest.loads.sum() / (STIFFNESS * heaviest.area)
    angle = 2 * np.pi * (np.arange(DIRECTIONS) + 0.3) / DIRECTIONS
    slips = [size * demand * (np.cos(a) / 4.0 * i + np.sin(a) / 3.2 * t) for a in angle for size in SIZES]
    rolling = [own + (pull * demand / 4.0 - own @ i) * i for pull in YAWED]
    turning = wheel - under
    return [Motion(c, slip, turning) for slip in slips] + [Motion(c, slip, turning, True) for slip in rolling]


def poses() -> list[tuple[int, PairPose, float]]:
    """Number in half_space_pairs.csv, pose, spread."""
    table = [(number, at, exact.spread) for number, (at, exact) in enumerate(read())]
    flat = [one for one in table if one[2] < BENT]
    return sorted([one for one in table if one[2] >= BENT] + flat[::EVERY], key=lambda one: one[0])


def exact_rows(number: int, at: PairPose, spread: float) -> list[list[float]]:
    """Rows of the file, one for each motion: the wrench of all patches over mu times all their load."""
    of_patch = wheel_rows(surfaces_of(at.pair), at.pose)
    solvers = [solver_of(patch) for patch in of_patch]
    load = sum(patch.loads.sum() for patch in of_patch)
    heaviest = max(of_patch, key=lambda patch: float(patch.loads.sum()))
    length = float(np.sqrt(heaviest.area / np.pi))
    lines = []
    for motion in motions(at.pose, heaviest):
        wrenches = np.array([exact_wrench(p, s, motion) for p, s in zip(of_patch, solvers, strict=True)])
        if wrenches[:, 6].min() < 1:
            continue
        share = np.array([patch.loads.sum() for patch in of_patch]) / load
        force = share @ wrenches[:, :6]
        lines.append([number, spread, load, motion.yawed, length, *motion.place, *motion.slip, *motion.turning, *force])
    return lines
