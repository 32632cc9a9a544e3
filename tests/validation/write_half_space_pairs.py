"""Writes data/half_space_pairs.csv: the exact half-space in random poses (validation/half_space_pairs.py). Seven minutes.

python tests/validation/write_half_space_pairs.py
"""

from __future__ import annotations

import csv
import sys
from collections.abc import Iterator
from dataclasses import replace
from itertools import chain, product
from pathlib import Path

import numpy as np

ROOT = Path(__file__).parents[2]
sys.path[:0] = [str(ROOT / "tests")]

from validation.free_patches import lowered, touch  # noqa: E402
from validation.half_space import Pose, Surfaces  # noqa: E402
from validation.half_space_pairs import (  # noqa: E402
    CATEGORIES,
    FILE,
    PAIRS,
    ExactWheel,
    PairPose,
    columns,
    exact,
    row_of,
    surfaces_of,
)
from validation.reference import DATA  # noqa: E402

EACH = 15
SEED = 5
ROLLERS = (0.0, 300.0, 725.0)
#: Loads [N]; contact angles of flange root and flange [rad]; share of the lighter of two contacts.
LOADS, ANGLES, BALANCED = (5e3, 150e3), (0.2, 1.0), 0.1

#: Between tread and flange, where a contact of strips was once wrong by 5 % to a factor of 400: radius of the roller, x, y,
#: height, yaw and roll of S1002 on UIC60 1:40.
TRANSITION = (
    (0, 0, 5.73219, 0.4194906, 0.0446819, -0.000357733),
    (725, 0, 5.161389, -0.316382, 0.0193924, 0.000606255),
    (0, 0, 5.718364, 1.12162, 0.0151863, -0.00127803),
    (725, -2.186, 5.026523, -0.0947888, 0.0499682, -0.000561018),
    (0, 0, 5.047566, 0.1140108, -0.0114904, 4.27073e-05),
    (725, -0.2193, 4.828125, -0.9072321, -0.0385934, 0.00113278),
    (0, 0, 6.698755, 0.9809635, 0.00831085, -0.000201891),
    (725, 0, 6.578991, 0.7644001, -0.00925452, 1.64166e-05),
    (0, 0, 6.619913, 0.7840076, -0.0177845, -9.25006e-05),
    (725, 0, 6.473091, 0.6365433, -0.0349094, -0.000456041),
    (0, 0, 6.823343, 1.10831, 0.00721795, -0.000355572),
    (0, 0, 4.871662, -0.1213798, -0.0132709, 0.000378902),
)


def random_pose(rng: np.random.Generator, roller_radius: float) -> Pose:
    """On rollers, half of the wheels with a longitudinal offset."""
    x = rng.uniform(-4.0, 4.0) if roller_radius and rng.random() < 0.5 else 0.0
    y, yaw, roll = rng.uniform(-6.0, 9.0), rng.uniform(-0.05, 0.05), rng.uniform(-2e-3, 2e-3)
    return Pose(float(y), 0.0, float(yaw), float(roll), roller_radius or None, float(x))


def random_load(rng: np.random.Generator) -> float:
    return float(np.exp(rng.uniform(*np.log(LOADS))))


def between_two(surfaces: Surfaces, pose: Pose) -> Pose | None:
    """At the shift where the rigid wheel touches in two places at once: its first touch jumps there."""
    low, high = pose.y, 8.0

    def across(y: float) -> float:
        return float(touch(surfaces, replace(pose, y=y))[1][1])

    first, last = across(low), across(high)
    for _ in range(12):
        middle = 0.5 * (low + high)
        if abs((at := across(middle)) - first) < abs(at - last):
            low, first = middle, at
        else:
            high, last = middle, at
    return replace(pose, y=0.5 * (low + high)) if abs(first - last) > 3.0 else None


def category_of(theirs: ExactWheel) -> str:
    """Of two contacts, the heavier says it unless they are balanced."""
    if len(theirs.forces) > 1 and sorted(theirs.forces)[-2] > BALANCED * theirs.force:
        return "two contacts"
    angle = np.arccos(theirs.normals_z[int(np.argmax(theirs.forces))])
    return CATEGORIES[int(np.searchsorted(ANGLES, angle))]


def loaded(surfaces: Surfaces, wanted: str, roller_radius: float, rng: np.random.Generator) -> Pose | None:
    """A random pose in which the rigid wheel touches where it is wanted; the flange root also just beyond two contacts, where
    some pairs touch only under load."""
    pose: Pose | None = random_pose(rng, roller_radius)
    beyond = wanted == "flange root" and rng.random() < 0.3
    if wanted == "two contacts" or beyond:
        pose = between_two(surfaces, replace(pose, y=float(rng.uniform(-6.0, 6.0))))
        if pose is not None and beyond:
            pose = replace(pose, y=pose.y + float(rng.uniform(0.0, 0.6)))
    elif wanted != CATEGORIES[int(np.searchsorted(ANGLES, np.arccos(touch(surfaces, pose)[2][2])))]:
        return None
    if pose is None:
        return None
    pose = lowered(surfaces, pose, random_load(rng))
    return replace(pose, height=round(pose.height, 6))


def random_poses(rng: np.random.Generator) -> Iterator[tuple[PairPose, ExactWheel]]:
    """As many of each pair and category."""
    for pair, wanted, i in product(PAIRS, CATEGORIES[:4], range(EACH)):
        radius = ROLLERS[i % len(ROLLERS)]
        for _ in range(400):
            pose = loaded(surfaces_of(pair), wanted, radius, rng)
            if pose is None:
                continue
            at = PairPose(pair, wanted, radius, pose.x, pose.y, pose.height, pose.yaw, pose.roll)
            theirs = exact(at)
            if category_of(theirs) == wanted and 0.8 * LOADS[0] < theirs.force < 1.2 * LOADS[1]:
                yield at, theirs
                break
        else:
            print("no pose:", pair, wanted, radius)


def main() -> None:
    """Solve and write."""
    known = (PairPose(PAIRS[0], CATEGORIES[4], *place) for place in TRANSITION)
    with (DATA / FILE).open("w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(columns())
        for at, theirs in chain(random_poses(np.random.default_rng(SEED)), ((at, exact(at)) for at in known)):
            writer.writerow(row_of(at, theirs))
            file.flush()


if __name__ == "__main__":
    main()
