"""The exact solver used again and again, as tables and comparisons use it."""

from __future__ import annotations

import numpy as np
import pytest

from rollerrig import _core

DIRECTIONS = [(1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 1, 0), (1, 0, 1), (0, 1, 1), (0, 1, -1), (1, 1, 1)]
SIZES = [0.01, 0.02, 0.05, 0.1, 0.2, 0.3, 0.5, 0.7, 1.0, 2.0, 5.0]


@pytest.mark.long
def test_a_solver_that_is_used_again_converges() -> None:
    """A long patch, from stick to full sliding and back: 4 of the 88 did not when only the last solution was started from."""
    creepage = np.array([np.array(way) * size for way in DIRECTIONS for size in SIZES], float)
    found = _core.RollingReference(5.0, 0.28, 1.0).solve(creepage)
    assert list(np.flatnonzero(found[:, 5] == 0)) == []
    assert np.hypot(found[:, 0], found[:, 1]).max() < 1.0 + 1e-6


ASPECTS = [0.05, 0.1, 0.3, 1.0, 3.0, 5.0, 10.0, 20.0]
SPINS = [0.0, 0.3, 1.0, 2.0, 4.0, 7.0, 10.0]
TRANSLATIONS = [(0, 0), (0.3, 0), (3, 0), (0, 0.3), (0, -3), (0.5, 0.5), (10, 10)]


def wide_range() -> np.ndarray:
    """Reduced creepages from none to far beyond full sliding, in an order of leaps: (case, xi eta chi)."""
    cases = np.array([(x, y, spin) for spin in SPINS for x, y in TRANSLATIONS if x or y or spin], float)
    return np.random.default_rng(7).permutation(cases)


@pytest.mark.parametrize(
    ("aspect", "fineness"),
    [(a, 0.5) for a in ASPECTS] + [pytest.param(a, 1.0, marks=pytest.mark.long) for a in ASPECTS],
)
def test_the_solver_converges_over_its_whole_range_within_friction(aspect: float, fineness: float) -> None:
    creepage = wide_range()
    found = _core.RollingReference(aspect, 0.28, fineness).solve(creepage)
    assert [tuple(row) for row in creepage[found[:, 5] == 0]] == []
    assert np.hypot(found[:, 0], found[:, 1]).max() < 1.0 + 1e-9
    # against the creepage: the friction does not drive the wheel
    assert ((found[:, 0] * creepage[:, 0] + found[:, 1] * creepage[:, 1] + found[:, 2] * creepage[:, 2]) < 1e-12).all()
    # Started afresh each case is the same, but that a coarse grid may have two divisions into stick and slip that both hold.
    apart = 0.015 if fineness < 1.0 else 0.006
    for row, solution in list(zip(creepage, found, strict=True))[::8]:
        fresh = _core.RollingReference(aspect, 0.28, fineness).solve(row[np.newaxis])[0]
        np.testing.assert_allclose(solution[:3], fresh[:3], atol=apart)


def test_mirrored_creepage_gives_mirrored_forces() -> None:
    """Lateral creepage and spin turned round: the lateral force and the moment turn round, the longitudinal force stays."""
    creepage = wide_range()
    mirror = np.array([1.0, -1.0, -1.0])
    found = _core.RollingReference(2.0, 0.28, 0.5).solve(creepage)
    mirrored = _core.RollingReference(2.0, 0.28, 0.5).solve(creepage * mirror)
    np.testing.assert_allclose(mirrored[:, :3], found[:, :3] * mirror, atol=0.015)


def ellipse_rows(a_over_b: float, count: int) -> tuple[np.ndarray, float]:
    """Rows of an ellipse as the solver cuts it, and their spacing."""
    a, b = np.sqrt(a_over_b), 1 / np.sqrt(a_over_b)
    spacing = 2 * b / (count + 0.2)
    across = -b + (np.arange(count) + 0.6) * spacing
    half = a * np.sqrt(1 - (across / b) ** 2)
    return np.column_stack([across, 0 * across, half, half**2]), spacing


def test_a_patch_given_by_rows() -> None:
    """An ellipse is itself; moved by (dx, dy) it meets other creepages at its middle, and turns the moment's arm."""
    rows, spacing = ellipse_rows(2.0, 12)
    xi, eta, chi, dx, dy = 0.5, 0.2, 0.4, 0.3, -0.7
    creepage = np.array([[xi, eta, chi]])
    solver = _core.RollingReference.on_rows(rows, spacing, 0.28, 16)
    force = solver.solve(creepage)[0]
    moved = _core.RollingReference.on_rows(rows + [dy, dx, 0, 0], spacing, 0.28, 16)
    same = moved.solve(np.array([[xi + chi * dy, eta - chi * dx, chi]]))[0]
    assert same[:2] == pytest.approx(force[:2], abs=1e-9)
    assert same[2] == pytest.approx(force[2] + dx * force[1] - dy * force[0], abs=1e-9)
    full = _core.RollingReference(2.0, 0.28, 1.0).solve(creepage)[0]
    assert force[:3] == pytest.approx(full[:3], abs=0.005)
