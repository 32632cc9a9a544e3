"""Modes are followed through crossings; names and shapes say what moves."""

from __future__ import annotations

import numpy as np
import pytest

from rollerrig.analysis.modes import Eigensystem, eigensystem, follow, track, unique_names


def oscillator_pair(s: float, coupling: float = 0.0) -> np.ndarray:
    """Two oscillators x'' + d x' + w^2 x = 0 whose frequencies cross at s = 0."""
    w1, w2, d1, d2 = 10.0 + 2.0 * s, 10.0 - 2.0 * s, 0.4, 0.6
    return np.array(
        [
            [0, 1, 0, 0],
            [-(w1**2), -d1, coupling, 0],
            [0, 0, 0, 1],
            [coupling, 0, -(w2**2), -d2],
        ]
    )


def test_modes_are_followed_through_a_crossing() -> None:
    steps = np.linspace(-1.0, 1.0, 11)  # one of them at the crossing itself
    systems = track([eigensystem(oscillator_pair(s)) for s in steps])
    for mode in range(4):
        frequency = np.array([abs(system.values[mode].imag) for system in systems])
        belongs_to_first = [np.linalg.norm(system.vectors[:2, mode]) > 0.5 for system in systems]
        assert len(set(belongs_to_first)) == 1, "the mode jumped to the other oscillator"
        d, slope = (0.4, 2.0) if belongs_to_first[0] else (0.6, -2.0)
        expected = np.sqrt((10.0 + slope * steps) ** 2 - (d / 2) ** 2)
        assert frequency == pytest.approx(expected, rel=1e-12)


def test_conjugates_stay_apart() -> None:
    systems = track([eigensystem(oscillator_pair(s)) for s in np.linspace(-1, 1, 7)])
    for mode in range(4):
        signs = {np.sign(system.values[mode].imag) for system in systems}
        assert len(signs) == 1


def test_following_undoes_any_order() -> None:
    system = eigensystem(oscillator_pair(0.7, coupling=3.0))
    order = np.array([2, 0, 3, 1])
    shuffled = Eigensystem(system.values[order], system.vectors[:, order])
    columns = follow(system, shuffled)
    assert shuffled.values[columns] == pytest.approx(system.values)


def test_names_are_made_different() -> None:
    assert unique_names(["a", "b", "a", "a"]) == ["a", "b", "a 2", "a 3"]
