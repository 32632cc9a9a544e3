"""Modes are followed through crossings; names and shapes say what moves."""

from __future__ import annotations

import numpy as np
import pytest

from rollerrig.analysis.mode_names import Roles, Shapes, mode_names, unique_names
from rollerrig.analysis.modes import eigensystem, follow, follow_modes, modal_assurance, predicted

A, B = 0.4, 0.6
"""Damping 2 Re of the two oscillators."""


def oscillator_pair(s: float, coupling: float = 0.0) -> np.ndarray:
    """Two oscillators x'' + d x' + w^2 x = 0 whose frequencies cross at s = 0."""
    w1, w2 = 10.0 + 2.0 * s, 10.0 - 2.0 * s
    return np.array(
        [
            [0, 1, 0, 0],
            [-(w1**2), -A, coupling, 0],
            [0, 0, 0, 1],
            [coupling, 0, -(w2**2), -B],
        ]
    )


@pytest.mark.parametrize("count", [2, 3, 11])  # of 11 one is the crossing itself; 2 are the ends alone
def test_modes_are_followed_through_a_crossing(count: int) -> None:
    steps = np.linspace(-1.0, 1.0, count)
    followed = follow_modes(oscillator_pair, steps)
    steps = followed.parameters
    for mode in range(4):
        frequency = np.abs(followed.values()[:, mode].imag)
        belongs_to_first = [np.linalg.norm(system.vectors[:2, mode]) > 0.5 for system in followed.systems]
        assert len(set(belongs_to_first)) == 1, "the mode jumped to the other oscillator"
        d, slope = (A, 2.0) if belongs_to_first[0] else (B, -2.0)
        expected = np.sqrt((10.0 + slope * steps) ** 2 - (d / 2) ** 2)
        assert frequency == pytest.approx(expected, rel=1e-12)
    assert not followed.unclear


def skewed(s: float) -> np.ndarray:
    """The same seen in coordinates in which all modes look alike: their right eigenvectors are nearly parallel."""
    mixing = np.ones((4, 4)) + 0.02 * np.array([[1, 2, 0, 1], [0, 1, 3, 0], [2, 0, 1, 1], [1, 0, 0, 4]])
    return np.asarray(mixing @ oscillator_pair(s) @ np.linalg.inv(mixing))


def test_modes_that_look_alike_are_told_apart() -> None:
    system = eigensystem(skewed(-1.0))
    plain = np.abs(system.vectors.conj().T @ system.vectors) ** 2
    assert plain.min() > 0.9, "the modes should look alike"
    assert modal_assurance(system, system) == pytest.approx(np.eye(4), abs=1e-9)
    values = follow_modes(skewed, [-1.0, 1.0]).values()
    for start, end in zip(values[0], values[-1], strict=True):
        assert end.real == pytest.approx(start.real, abs=1e-8)  # -A/2 or -B/2 all along
        assert abs(end.imag) != pytest.approx(abs(start.imag), abs=1.0)  # 8 becomes 12 and the other way round


def test_modes_that_part_before_they_cross_exchange_their_shapes_and_keep_their_order() -> None:
    """Coupled oscillators never cross: the upper frequency stays the upper one.

    They part within |s| < 0.2. Who steps over all of that sees a crossing; one value within is enough, and steps are added.
    """
    coarse = follow_modes(lambda s: oscillator_pair(s, coupling=8.0), [-1.0, 0.02, 1.0])
    fine = follow_modes(lambda s: oscillator_pair(s, coupling=8.0), np.linspace(-1, 1, 201))
    assert len(coarse.parameters) > 3, "the step should have been divided"
    for followed in (coarse, fine):
        first, last = followed.values()[0].imag, followed.values()[-1].imag
        assert np.argsort(first).tolist() == np.argsort(last).tolist()


def test_conjugates_stay_apart() -> None:
    followed = follow_modes(oscillator_pair, np.linspace(-1, 1, 7))
    assert np.all(np.sign(followed.values().imag) == np.sign(followed.values()[0].imag))


def test_a_mode_that_is_overdamped_for_a_while_comes_back_with_its_sign() -> None:
    def matrix(s: float) -> np.ndarray:  # damping rises beyond critical and falls again
        return np.array([[0.0, 1.0], [-100.0, -2.0 * (25.0 - s**2)]])

    values = follow_modes(matrix, np.linspace(-4.5, 4.5, 31)).values()
    assert np.any(values.imag == 0.0)
    assert np.all(np.sign(values[0].imag) == np.sign(values[-1].imag))


@pytest.mark.parametrize("seed", range(12))
def test_which_column_of_a_pair_goes_on_as_which_real_eigenvalue_is_no_matter_of_round_off(seed: int) -> None:
    """-1 and -3 become a pair and cease to be one: the column of positive frequency is -1 before and after."""
    chance = np.random.default_rng(seed)
    turned = np.linalg.qr(chance.standard_normal((3, 3)))[0]

    def matrix(s: float) -> np.ndarray:
        own = np.array([[-1.0, 1.0, 0.0], [-2.0 + 2.0 * s * s, -3.0, 0.0], [0.0, 0.0, -9.0]])
        return turned @ own @ turned.T * (1.0 + 1e-13 * chance.standard_normal((3, 3)))

    values = follow_modes(matrix, np.linspace(-1.0, 1.0, 8)).values()
    (upper,) = np.flatnonzero(values[3].imag > 0.0)
    (lower,) = np.flatnonzero(values[3].imag < 0.0)
    assert values[[0, -1]][:, [upper, lower]] == pytest.approx(np.array([[-1.0, -3.0], [-1.0, -3.0]]), abs=1e-9)


def test_following_undoes_any_order() -> None:
    system = eigensystem(oscillator_pair(0.7, coupling=3.0))
    shuffled = system.reordered(np.array([2, 0, 3, 1]))
    columns, clear = follow(system, shuffled)
    assert clear
    assert shuffled.values[columns] == pytest.approx(system.values)


def test_prediction_is_of_first_order() -> None:
    start = eigensystem(oscillator_pair(0.5, coupling=3.0))
    errors = []
    for step in (0.1, 0.05):
        change = oscillator_pair(0.5 + step, coupling=3.0) - oscillator_pair(0.5, coupling=3.0)
        found = eigensystem(oscillator_pair(0.5 + step, coupling=3.0))
        error = [np.min(np.abs(found.values - value)) for value in predicted(start, change)]
        errors.append(max(error))
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.15)  # what is left out is of second order


# ---------------------------------------------------------------------------------------------------- names

ROLES = Roles(("body",), ("f1", "f2"), ("wheelset_1", "wheelset_2"), {"f1": ("wheelset_1",), "f2": ("wheelset_2",)})


def named(
    motion: dict[tuple[str, str], complex], energy: dict[tuple[str, str], float], *, hunting: bool = False
) -> str:
    keys = list(motion)
    shares = np.array([energy[key] for key in keys])[None, :, None]
    parts = np.array([motion[key] for key in keys], dtype=np.complex128)[None, :, None]
    return mode_names(Shapes(keys, np.zeros((1, 1)), shares, parts, np.full((1, 1), hunting)), ROLES)[0]


@pytest.mark.parametrize(("roll", "name"), [(-0.5, "car body lower sway"), (0.5, "car body upper sway")])
def test_a_sway_is_named_after_its_axis(roll: float, name: str) -> None:
    """Roll about x is positive from y to z: what is above the centre goes to -y. With roll of the other sign than y, the top goes
    further than the centre: the axis is below."""
    motion = {("body", "lateral"): 1.0 + 0j, ("body", "roll"): roll + 0j}
    assert named(motion, {("body", "lateral"): 0.6, ("body", "roll"): 0.4}) == name


@pytest.mark.parametrize(
    ("rear", "name"), [(1.0, "bogie pitch, in phase"), (-1.0, "bogie pitch, out of phase"), (0.01, "front bogie pitch")]
)
def test_two_bogies_are_told_by_their_phase(rear: float, name: str) -> None:
    motion = {("f1", "pitch"): 1j, ("f2", "pitch"): 1j * rear}
    whole = 1 + rear**2
    assert named(motion, {("f1", "pitch"): 1 / whole, ("f2", "pitch"): rear**2 / whole}) == name


def test_wheelsets_that_weave_hunt() -> None:
    motion = {
        ("f1", "lateral"): 1.0,
        ("wheelset_1", "lateral"): 1.0,
        ("f2", "lateral"): -1.0,
        ("wheelset_2", "lateral"): -1.0,
    }
    energy = dict.fromkeys(motion, 0.25)
    assert named(motion, energy, hunting=True) == "hunting, bogies out of phase"
    assert named(motion, energy).startswith(("wheelsets", "bogie"))  # they sway, and do not roll as they point


def test_names_are_made_different() -> None:
    assert unique_names(["a", "b", "a", "a"]) == ["a", "b", "a 2", "a 3"]
