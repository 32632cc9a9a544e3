"""The exact solver used again and again, as tables and comparisons use it."""

from __future__ import annotations

import numpy as np

from rollerrig import _core

DIRECTIONS = [(1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 1, 0), (1, 0, 1), (0, 1, 1), (0, 1, -1), (1, 1, 1)]
SIZES = [0.01, 0.02, 0.05, 0.1, 0.2, 0.3, 0.5, 0.7, 1.0, 2.0, 5.0]


def test_a_solver_that_is_used_again_converges() -> None:
    """A long patch, from stick to full sliding and back: 4 of the 88 did not when only the last solution was started from."""
    creepage = np.array([np.array(way) * size for way in DIRECTIONS for size in SIZES], float)
    found = _core.RollingReference(5.0, 0.28, 1.0).solve(creepage)
    assert list(np.flatnonzero(found[:, 5] == 0)) == []
    assert np.hypot(found[:, 0], found[:, 1]).max() < 1.0 + 1e-6
