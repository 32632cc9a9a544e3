"""Writes data/half_space_poses.csv: the exact half-space in every pose of validation/poses.py, each at the height where it
carries the pose's force. Twenty minutes.

    python tests/validation/write_half_space_poses.py
"""

from __future__ import annotations

import csv
import sys
from dataclasses import astuple
from pathlib import Path

import numpy as np

ROOT = Path(__file__).parents[2]
sys.path[:0] = [str(ROOT / "tests")]

from validation.half_space import Grid, Pose, Solution, Surfaces, solve  # noqa: E402
from validation.poses import FILE, SOLUTION, LoadedPose, all_poses, columns, pressed  # noqa: E402
from validation.pressed_wheel import PressedWheel  # noqa: E402
from validation.reference import DATA, mm  # noqa: E402

CELLS = (180, 144)


def grid_on(wheel: PressedWheel, grown: float) -> Grid:
    """Where the strips' patches are, with a margin: they only say where to look."""
    along = np.cross([0.0, 1.0, 0.0], wheel.direction)
    along /= np.linalg.norm(along)
    axes = np.array([along, np.cross(wheel.direction, along)])
    middles = [axes @ (np.array(patch.point) / mm - wheel.point) for patch in wheel.patches]
    halves = [np.array([patch.length, patch.width]) / (2 * mm) for patch in wheel.patches]
    low = np.min([m - h for m, h in zip(middles, halves, strict=True)], axis=0)
    high = np.max([m + h for m, h in zip(middles, halves, strict=True)], axis=0)
    half = grown * (1.15 * 0.5 * (high - low) + 0.1)
    return Grid(wheel.point + 0.5 * (low + high) @ axes, wheel.direction, tuple(half), CELLS)


def exact(surfaces: Surfaces, pose: LoadedPose) -> tuple[float, Solution]:
    """Height [mm] and solution."""
    wheel = pressed(pose)
    for grown in (1.0, 1.25, 1.6, 2.0):
        try:
            return exact_on(surfaces, pose, grid_on(wheel, grown), wheel.height)
        except ValueError:  # the grid is too small
            continue
    raise RuntimeError(f"no grid is large enough: {pose}")


def exact_on(surfaces: Surfaces, pose: LoadedPose, grid: Grid, height: float) -> tuple[float, Solution]:
    """By the secant method from a height; the first step as if the force went with the approach to the power 3/2."""
    rate, last = 0.0, (np.nan, np.nan)
    for _ in range(15):
        at = Pose(pose.y, height, pose.yaw, pose.roll, pose.roller_radius or None, pose.x)
        found = solve(surfaces, at, grid)
        if abs(found.force / pose.force - 1) < 2e-5:
            return height, found
        rate = (
            (found.force - last[1]) / (height - last[0])
            if rate
            else -1.5 * found.force * grid.normal[2] / found.approach
        )
        last = (height, found.force)
        height -= (found.force - pose.force) / rate
    raise RuntimeError(f"no height found: {pose}")


def main() -> None:
    """Solve and write."""
    surfaces = Surfaces()
    with (DATA / FILE).open("w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(columns())
        for pose in all_poses():
            height, found = exact(surfaces, pose)
            numbers = [height, *(getattr(found, name) for name in SOLUTION), *found.centre]
            writer.writerow([*astuple(pose), *(f"{number:.7g}" for number in numbers)])
            file.flush()


if __name__ == "__main__":
    main()
