"""The force of the strips grows smoothly while a wheel is lowered in steps of 0.1 um, in 2 000 random poses of new and worn
pairs, with --long in 100 000 (two minutes). No reference is needed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from validation.half_space_pairs import PAIRS, contact_of
from validation.reference import mm
from validation.write_half_space_pairs import ROLLERS, random_pose

POSES, TESTS, SEED = 2000, 50, 12
#: How far below its first touch a wheel is, at least and at most; the poses of a line below that [mm].
SHALLOW, DEEP = 0.005, 1.0
LINE = 1e-4 * np.arange(4)
#: Of the load, 1 kN or more: the largest second difference, as of a jump, and the largest fall in one step.
JUMP, FALL = 0.01, 0.003
#: d ln F / d ln depth: 1.5 of a Hertzian contact, up to 4.4 where the flange comes to a wheel that carries little, and 6.5 in one
#: of 10^5 poses where a contact is solved again.
STEEPEST = 8.0


@pytest.mark.parametrize("test", [0, *(pytest.param(k, marks=pytest.mark.long) for k in range(1, TESTS))])
def test_the_force_grows_smoothly_while_a_wheel_is_lowered(test: int) -> None:
    rng = np.random.default_rng((SEED, test))
    found = []
    for i in range(POSES):
        pair, radius = PAIRS[i % len(PAIRS)], ROLLERS[i // len(PAIRS) % len(ROLLERS)]
        contact, pose = contact_of(pair, radius, "strips"), random_pose(rng, radius)
        if i % 2:  # hardly any yaw, as in running
            pose = replace(pose, yaw=0.05 * pose.yaw)
        place, turned = (pose.x * mm, pose.y * mm), (pose.yaw, pose.roll, False)
        touch = contact.touch_height(*place, *turned) / mm
        depth = LINE + float(np.exp(rng.uniform(*np.log([SHALLOW, DEEP]))))
        force = np.array([sum(p.normal for p in contact.patches(*place, (touch - d) * mm, *turned)) for d in depth])
        load = np.maximum(force.min(), 1e3)
        jump, step = np.abs(np.diff(force, 2)).max() / load, np.diff(force) / load
        power = np.max(np.diff(np.log(force)) / np.diff(np.log(depth)))
        worst = max(jump / JUMP, -step.min() / FALL, power / STEEPEST)
        found.append((worst, f"{force} N at {depth} mm: {pair}, {replace(pose, height=touch)}"))
    worst, where = max(found)
    assert worst < 1.0, where
