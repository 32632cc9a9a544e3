"""Eigenvalues and mode shapes, followed from one value of a parameter to the next.

    A(speed) -> [modes] -> eigenvalues and eigenvectors in an order in which a column stays the same mode

Equations: docs/theory/equilibrium_and_linearisation.md, (L5)-(L9).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eig

from rollerrig.analysis.linearise import Linearisation
from rollerrig.common.blas_threads import one_blas_thread

Complex = NDArray[np.complex128]
Matrix = NDArray[np.float64]

LEAST_FREQUENCY = 2 * np.pi * 0.05
"""Below this, an eigenvalue does not count as an oscillation [rad/s]."""

FOLLOWED_FREQUENCY = 2 * np.pi * 40.0
"""Up to here it is worth a further step to know which mode is which [rad/s]; above are wheels on their Hertz springs."""

CLEAR_MARGIN = 0.5
"""A pairing is clear if any other one costs at least this much more, of at most 2 for modes that have nothing in common."""

MOST_HALVINGS = 7
"""A step is halved at most this often where modes are hard to tell apart."""


@dataclass(frozen=True)
class Eigensystem:
    """All eigenvalues of one matrix.

    Attributes:
        values: eigenvalues [1/s], shape (n,).
        vectors: right eigenvectors as columns, each of norm 1, shape (n, n).
        left: left eigenvectors as columns, each of norm 1, shape (n, n): left[:, i]^H A = value[i] left[:, i]^H.
    """

    values: Complex
    vectors: Complex
    left: Complex

    def reordered(self, columns: NDArray[np.intp]) -> Eigensystem:
        """The same with its columns in another order."""
        return Eigensystem(self.values[columns], self.vectors[:, columns], self.left[:, columns])


@one_blas_thread()
def eigensystem(matrix: Matrix) -> Eigensystem:
    """Eigenvalues, right and left eigenvectors of A."""
    solution: tuple[Complex, Complex, Complex] = eig(matrix, left=True, check_finite=False)  # type: ignore[assignment]
    values, left, right = solution
    return Eigensystem(values.astype(np.complex128), right.astype(np.complex128), left.astype(np.complex128))


def oscillates(values: Complex) -> NDArray[np.bool_]:
    """Which eigenvalues are oscillations, one of each conjugate pair."""
    return np.asarray(values.imag > LEAST_FREQUENCY)


# ---------------------------------------------------------------------------------------------------- following


@one_blas_thread()
def modal_assurance(one: Eigensystem, other: Eigensystem) -> Matrix:
    """How much two modes of neighbouring matrices are the same, (L8): 1 for the same mode, 0 for another one.

    Left vectors of one mode are orthogonal to the right vectors of all others, however alike those may look: this tells
    apart modes that the usual modal assurance criterion takes for one.
    """
    across = np.abs(one.left.conj().T @ other.vectors)
    back = np.abs(other.left.conj().T @ one.vectors).T
    own = np.abs(np.sum(one.left.conj() * one.vectors, axis=0))
    others_own = np.abs(np.sum(other.left.conj() * other.vectors, axis=0))
    # where two modes have become one, `own` vanishes: there the limit of 1 decides
    return np.asarray(np.minimum(1.0, across * back / np.maximum(np.outer(own, others_own), 1e-30)))


@one_blas_thread()
def predicted(system: Eigensystem, change: Matrix) -> Complex:
    """Eigenvalues after a small change of the matrix, to first order, (L9)."""
    own = np.sum(system.left.conj() * system.vectors, axis=0)
    shift = np.sum(system.left.conj() * (change @ system.vectors), axis=0)
    # near a double eigenvalue the slope is infinite: no prediction is better than a wild one
    usable = np.abs(own) > 1e-6
    shift = np.where(usable, shift / np.where(usable, own, 1.0), 0.0)
    reach = 0.5 * (1.0 + np.abs(system.values))
    shift *= np.minimum(1.0, reach / np.maximum(np.abs(shift), 1e-30))
    return np.asarray(system.values + shift)


def _costs(previous: Eigensystem, following: Eigensystem, change: Matrix | None) -> Matrix:
    ahead = previous.values if change is None else predicted(previous, change)
    back = following.values if change is None else predicted(following, -change)
    size = 1.0 + 0.5 * (np.abs(previous.values)[:, None] + np.abs(following.values)[None, :])
    distance = np.abs(ahead[:, None] - following.values[None, :]) + np.abs(previous.values[:, None] - back[None, :])
    return np.asarray(0.5 * distance / size + 1.0 - modal_assurance(previous, following))


@one_blas_thread()
def follow(
    previous: Eigensystem, following: Eigensystem, change: Matrix | None = None
) -> tuple[NDArray[np.intp], bool]:
    """Which mode of the next matrix continues each mode of this one.

    The pairing with the least sum of relative distance between predicted and found eigenvalue and of 1 - `modal_assurance`.

    Args:
        previous: modes that are known.
        following: modes to be put in their order.
        change: difference of the two matrices; None predicts no change.

    Returns:
        Column of `following` for each column of `previous`, shape (n,), and whether the pairing is clear: no two
        oscillations up to FOLLOWED_FREQUENCY could as well be exchanged.
    """
    from scipy.optimize import linear_sum_assignment  # slow to load, and seldom needed

    costs = _costs(previous, following, change)
    _, columns = linear_sum_assignment(costs)
    watched = np.flatnonzero(oscillates(previous.values) & (np.abs(previous.values) < FOLLOWED_FREQUENCY))
    paired = costs[np.ix_(watched, columns[watched])]
    own = np.diag(paired)
    exchange = paired + paired.T - own[:, None] - own[None, :]
    values = following.values[columns[watched]]
    apart = np.abs(values[:, None] - values[None, :]) > 1e-6 * (1.0 + np.abs(values)[:, None])
    return np.asarray(columns), not bool(np.any(apart & (exchange < CLEAR_MARGIN)))


@dataclass(frozen=True)
class Followed:
    """Modes along a parameter, each in one column.

    Attributes:
        parameters: the values asked for and those added between them, rising, shape (m,).
        asked: where the values asked for stand among them.
        systems: one eigensystem each, columns in one order.
        unclear: parameters after which a pairing stayed unclear however small the step.
        interrupted: whether Ctrl-C came before the last value; what was done until then is here.
    """

    parameters: NDArray[np.float64]
    asked: list[int]
    systems: list[Eigensystem]
    unclear: list[float]
    interrupted: bool = False

    def values(self) -> Complex:
        """Eigenvalues, shape (m, n)."""
        return np.array([system.values for system in self.systems])


def follow_modes(
    matrix_at: Callable[[float], Matrix], parameters: Sequence[float], halvings: int = MOST_HALVINGS
) -> Followed:
    """Follow all modes of a matrix along a parameter, with smaller steps where it is unclear which mode is which.

    Args:
        matrix_at: the real matrix at a value of the parameter, always of one size.
        parameters: rising values.
        halvings: how often a step may be halved.

    Raises:
        KeyboardInterrupt: it came from `matrix_at` before the first value was done.
    """
    values = [float(value) for value in parameters]
    matrix = matrix_at(values[0])
    system = eigensystem(matrix)
    sign = np.sign(system.values.imag)
    done, asked, systems, unclear = [values[0]], [0], [system], []
    try:
        for target in values[1:]:
            least = (target - done[-1]) / 2**halvings
            ahead = [_solved(matrix_at, target)]
            while ahead:
                value, next_matrix, found = ahead[-1]
                columns, clear = follow(system, found, next_matrix - matrix)
                if not clear and value - done[-1] > 1.5 * least:
                    middle = 0.5 * (done[-1] + value)
                    ahead.append(_solved(matrix_at, middle))
                    continue
                if not clear:
                    unclear.append(done[-1])
                ahead.pop()
                system = _signs_kept(found.reordered(columns), system, sign)
                sign = np.where(system.values.imag != 0.0, np.sign(system.values.imag), sign)
                matrix = next_matrix
                done.append(value)
                systems.append(system)
            asked.append(len(done) - 1)
    except KeyboardInterrupt:
        whole = asked[-1] + 1
        return Followed(np.array(done[:whole]), asked, systems[:whole], unclear, True)
    return Followed(np.array(done), asked, systems, unclear)


def _solved(matrix_at: Callable[[float], Matrix], value: float) -> tuple[float, Matrix, Eigensystem]:
    matrix = matrix_at(value)
    return value, matrix, eigensystem(matrix)


def _signs_kept(system: Eigensystem, previous: Eigensystem, sign: NDArray[np.float64]) -> Eigensystem:
    """Where two real eigenvalues become a pair: the column that was the one of positive frequency is so again."""
    born = np.flatnonzero((system.values.imag > 0.0) & (previous.values.imag == 0.0))
    columns = np.arange(len(system.values))
    for upper in born.tolist():
        lower = int(np.argmin(np.abs(system.values - system.values[upper].conj())))
        if sign[upper] < 0.0 or sign[lower] > 0.0:
            columns[upper], columns[lower] = lower, upper
    return system.reordered(columns)


# ---------------------------------------------------------------------------------------------------- shapes


def body_shapes(linearisation: Linearisation, system: Eigensystem, columns: Sequence[int]) -> Complex:
    """Displacement of each body coordinate in some modes, the largest one 1 (rotations: per radian on 1 m).

    Taken from the rates, divided by the eigenvalue: wheelsets have no pitch angle among the states.

    Returns:
        Shape (coordinates, modes), coordinates in the order of `linearisation.rate_rows`.
    """
    rows = list(linearisation.rate_rows.values())
    shape = system.vectors[np.ix_(rows, columns)] / system.values[list(columns)]
    largest = shape[np.argmax(np.abs(shape), axis=0), np.arange(len(columns))]
    return np.asarray(shape / np.where(largest == 0.0, 1.0, largest))


def energy_shares(linearisation: Linearisation, system: Eigensystem, columns: Sequence[int]) -> Matrix:
    """Share of each body coordinate in the kinetic energy of some modes; each column sums to 1.

    Returns:
        Shape (coordinates, modes), coordinates in the order of `linearisation.rate_rows`.
    """
    rows = list(linearisation.rate_rows.values())
    inertia = np.array([linearisation.inertia[key] for key in linearisation.rate_rows])
    energy = inertia[:, None] * np.abs(system.vectors[np.ix_(rows, columns)]) ** 2
    total = energy.sum(axis=0)
    return np.asarray(energy / np.where(total > 0.0, total, 1.0))
