"""Writes data/creep_reference.csv: solutions of the exact theory at random points, which the table law is held against.

    python tests/validation/write_creep_reference.py

The solver runs on its full grid, finer than the one the table is made with. Reduced units: core/include/rollerrig/contact/
creep/rolling_reference.hpp.
"""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np

from rollerrig import _core

FILE = Path(__file__).with_name("data") / "creep_reference.csv"
POINTS = 500
COLUMNS = ("a_over_b", "poisson_ratio", "xi", "eta", "chi", "longitudinal", "lateral", "spin_moment")


def random_case(random: np.random.Generator, poisson_ratio: float = 0.28) -> tuple[float, np.ndarray]:
    """a/b and reduced creepages: ln(a/b) uniform; direction uniform; size so that all states from stick to slip are met."""
    a_over_b = float(np.exp(random.uniform(-np.log(10), np.log(10))))
    c11, c22, c23, c33 = _core.kalker_coefficients(a_over_b, poisson_ratio)
    unit = np.array([c11, c22, np.hypot(c23, c33)])
    direction = random.normal(size=3)
    r = random.uniform(0, 1) ** (1 / 3)
    return a_over_b, direction / np.linalg.norm(direction) * 1.5 * r / (1 - min(r, 0.995)) / unit


def main() -> None:
    """Solve and write."""
    random = np.random.default_rng(20)
    with FILE.open("w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(COLUMNS)
        for _ in range(POINTS):
            a_over_b, creepage = random_case(random)
            answer = _core.RollingReference(a_over_b, 0.28, 1.0).solve(creepage[None])[0]
            if not answer[5]:
                print("no solution:", a_over_b, creepage)
                continue
            writer.writerow([f"{x:.9g}" for x in (a_over_b, 0.28, *creepage, *answer[:3])])


if __name__ == "__main__":
    main()
