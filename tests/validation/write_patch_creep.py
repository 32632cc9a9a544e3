"""Writes data/patch_creep.csv: exact creep forces on patches that are no ellipses (validation/patch_creep.py). Ten minutes.

python tests/validation/write_patch_creep.py
"""

from __future__ import annotations

import csv
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]
sys.path[:0] = [str(ROOT / "tests")]

from validation.half_space import Surfaces  # noqa: E402
from validation.patch_creep import COLUMNS, FILE, creepages, patch_of, poses  # noqa: E402
from validation.reference import DATA  # noqa: E402


def main() -> None:
    """Solve and write."""
    surfaces = Surfaces()
    with (DATA / FILE).open("w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(COLUMNS)
        for pose in poses():
            patch = patch_of(surfaces, pose)
            solver = patch.solver()
            for creepage in creepages(patch, pose):
                *answer, converged = patch.exact(solver, creepage, pose.force)
                if not converged:
                    print("no solution:", pose, creepage)
                    continue
                numbers = [*patch.centre[1:], patch.area, *creepage, *answer]
                writer.writerow([pose.roller_radius, pose.y, pose.force, *(f"{number:.7g}" for number in numbers)])
            file.flush()


if __name__ == "__main__":
    main()
