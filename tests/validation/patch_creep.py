"""Creep forces on patches that are no ellipses, by the exact theory: the exact solver of rolling contact on the half-space's
pressures, taken as rows along rolling. Left wheel; mm, N, rad/mm.

    pose -> half-space -> [patch_rows] -> rows -> exact solver -> forces over creepages: data/patch_creep.csv
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from rollerrig import _core
from validation.half_space import Grid, Pose, Surfaces, pressures
from validation.poses import LoadedPose, pressed
from validation.reference import POISSON_RATIO, SHEAR_MODULUS
from validation.write_half_space_poses import exact_on, grid_on

Array = NDArray[np.float64]

FILE = "patch_creep.csv"
FRICTION = 0.3
ROWS, ELEMENTS = 22, 18
SHIFTS = (-5.0, -2.0, -0.5, 0.0, 0.25, 0.5, 0.75, 1.0, 1.5, 3.0, 4.5)
FORCES = (1e4, 5e4, 1e5)
DIRECTIONS, SIZES = 8, (0.3, 0.8, 2.0)
WHEEL_RADIUS = 460.0
COLUMNS = (
    "roller_radius",
    "y",
    "force",
    "centre_y",
    "centre_z",
    "area",
    "eps_x",
    "eps_y",
    "eps_sp",
    "t_x",
    "t_y",
    "moment",
)


@dataclass(frozen=True)
class RowPatch:
    """Rows: y and x of the middle about the centre of the pressures, half-length, load; `spacing` of the rows."""

    rows: Array
    spacing: float
    centre: Array
    normal: Array
    area: float

    def solver(self) -> _core.RollingReference:
        return _core.RollingReference.on_rows(np.ascontiguousarray(self.rows), self.spacing, POISSON_RATIO, ELEMENTS)

    def exact(self, solver: _core.RollingReference, creepage: Array, force: float) -> Array:
        """T_x, T_y over mu N, M over mu N [mm] and whether the solver converged; creepages at the centre, spin per mm."""
        scale = SHEAR_MODULUS * 1e-6 / (FRICTION * force)
        return solver.solve(scale * creepage[None])[0][[0, 1, 2, 5]]


def poses() -> list[LoadedPose]:
    return [LoadedPose("creep", radius, 0.0, y, 0.0, 0.0, n) for radius, n, y in product((0.0, 500.0), FORCES, SHIFTS)]


def patch_rows(surfaces: Surfaces, pose: LoadedPose, height: float, grid: Grid, count: int = ROWS) -> RowPatch:
    """A row's length is that of the semi-ellipse with the second moment of its pressures. Grid: the patch and a margin."""
    depth = surfaces.interpenetration(
        Pose(pose.y, height, pose.yaw, pose.roll, pose.roller_radius or None, pose.x), grid
    )
    loaded = (pressures(depth, grid.spacing) > 0).any(axis=0).sum()
    grid = Grid(grid.point, grid.normal, grid.half, (grid.count[0], round(grid.count[1] * count / loaded)))
    depth = surfaces.interpenetration(
        Pose(pose.y, height, pose.yaw, pose.roll, pose.roller_radius or None, pose.x), grid
    )
    p = pressures(depth, grid.spacing)
    if (p[[0, -1]] > 0).any() or (p[:, [0, -1]] > 0).any():
        raise ValueError("the grid is too small")
    dx, dy = grid.spacing
    x, y = (-half + (np.arange(n) + 0.5) * d for half, n, d in zip(grid.half, grid.count, grid.spacing, strict=True))
    centre = np.tensordot(p / p.sum(), grid.places(), 2)
    middle = (p.sum(axis=1) @ x / p.sum(), p.sum(axis=0) @ y / p.sum())
    rows = []
    for column, across in zip(p.T, y, strict=True):
        if (column > 0).sum() < 3:
            continue
        at = column @ x / column.sum()
        half = 2 * np.sqrt(column @ (x - at) ** 2 / column.sum())
        rows.append((across - middle[1], at - middle[0], half, column.sum() * dx * dy))
    return RowPatch(np.array(rows), dy, centre, grid.normal, float((p > 0).sum() * dx * dy))


def patch_of(surfaces: Surfaces, pose: LoadedPose) -> RowPatch:
    """At the height where the half-space carries the force."""
    wheel = pressed(pose)
    for grown in (1.0, 1.3, 1.7, 2.2):
        grid = grid_on(wheel, grown)
        grid = Grid(grid.point, grid.normal, grid.half, (112, 80))
        try:
            height, _ = exact_on(surfaces, pose, grid, wheel.height)
            return patch_rows(surfaces, pose, height, grid)
        except ValueError:
            continue
    raise RuntimeError(f"no grid is large enough: {pose}")


def creepages(patch: RowPatch, pose: LoadedPose) -> Array:
    """Directions and sizes from stick to sliding, with the spin of a wheel that rolls on its contact angle. (24, 3)"""
    curvature = 1 / WHEEL_RADIUS + (1 / pose.roller_radius if pose.roller_radius else 0.0)
    spin = patch.normal[1] * curvature
    unit = np.pi * FRICTION * pose.force / (SHEAR_MODULUS * 1e-6 * patch.area)
    angle = 2 * np.pi * (np.arange(DIRECTIONS) + 0.3) / DIRECTIONS
    return np.array(
        [(size * unit * np.cos(a) / 4.0, size * unit * np.sin(a) / 3.2, spin) for a in angle for size in SIZES]
    )
