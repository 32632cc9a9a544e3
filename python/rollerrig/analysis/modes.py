"""Linearisation at the rolling equilibrium; eigenvalues and mode shapes, followed over a parameter; which modes are hunting.

    Case, running speed -> [Lineariser] -> A of x' = A x around steady rolling, names of the states
    A(speed) -> [modes] -> eigenvalues and eigenvectors in an order in which a column stays the same mode
    eigenvalues and shapes over speed -> [hunts] -> where each mode hunts -> names, frequency of hunting over speed

The rollers (or the rails) are speed-controlled: the rates of driven rollers are inputs, not states, and are taken out of A.
Equations: docs/theory/equilibrium_and_linearisation.md, (L3)-(L9).

In a hunting mode the wheelsets move most, and roll where they point: one that rolls without sliding sideways is
carried along by its yaw,

    dy/dt = V psi,

the kinematics of Klingel's wave, on rollers with the speed of their surface. In a mode of the suspension it slides sideways
instead, or hardly moves. A mode that is followed over speed may be the one at low speed and the other at high speed: where the
frequency of hunting, which rises with speed, meets that of the car body's sway, the two exchange their shapes.
"""

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eig

from rollerrig import _core
from rollerrig.assembly.model import assemble
from rollerrig.cases import at_speed
from rollerrig.common.arrays import Array, Complex, Mask
from rollerrig.common.linear_algebra import one_blas_thread
from rollerrig.config import Case
from rollerrig.simulation.starting_state import StartError

DIRECTIONS = ("longitudinal", "lateral", "vertical", "roll", "pitch", "yaw")
"""Words for the six coordinates of a body, in the core's order."""


@dataclass(frozen=True)
class Linearisation:
    """x' = A x for small motions around steady rolling."""

    speed: float  # running speed [m/s]
    matrix: Array  # A, shape (states, states)
    equilibrium: Array  # all states of the core at the equilibrium, driven rates included
    rate_rows: dict[tuple[str, str], int]  # per moving body coordinate (body, direction), the row of its rate in A
    inertia: dict[tuple[str, str], float]  # mass [kg] or moment of inertia [kg m^2] that belongs to each of them


class Lineariser:
    """One assembled model, linearised at any number of speeds.

    Each speed starts from the equilibrium of the one before, the first one from a state `near` it: neighbouring speeds in order
    are fastest.

    Attributes:
        case, model: what is linearised.
        kept: places in the core's states of those of the matrix: all but the rates of driven rollers.
    """

    def __init__(self, case: Case, near: Array | None = None) -> None:
        self.case = at_speed(case)
        self.model = assemble(self.case)
        simulation = _core.Simulation(self.model.core)
        self._near = near
        driven = {simulation.rate_index[self.model.body_index(name)][4] for name in self.model.rollers}
        self.kept = np.array([i for i in range(simulation.state_count) if i not in driven])
        row_of = {int(state_index): row for row, state_index in enumerate(self.kept)}
        self._rows = {
            (body, direction): row_of[simulation.rate_index[b][d]]
            for b, body in enumerate(self.model.bodies)
            for d, direction in enumerate(DIRECTIONS)
            if simulation.rate_index[b][d] in row_of
        }
        mass_and_inertia = {b: (mass, mass, mass, *self.model.inertias[b]) for b, mass in self.model.masses.items()}
        self._inertia = {(body, d): mass_and_inertia[body][DIRECTIONS.index(d)] for body, d in self._rows}

    def simulation_at(self, speed: float) -> _core.Simulation:
        """A simulation of the model whose rails run at this speed [m/s]; rollers take theirs from the state."""
        return _core.Simulation(self.model.core.with_speed([(0.0, speed)]))

    def at(self, speed: float) -> Linearisation:
        """Linearise at a running speed [m/s].

        Raises:
            StartError: no rolling equilibrium was found at this speed.
        """
        simulation = self.simulation_at(speed)
        found = simulation.equilibrium(speed, 0.0, [], self._near)
        if not found["converged"]:
            raise StartError(
                f"{self.case.name}: no rolling equilibrium at {3.6 * speed:g} km/h: {found['residual']:.3g} N or N m remain "
                "unbalanced; check gauge, profiles and torques with `rollerrig check`; a whole vehicle on track needs "
                "something that holds it in x, e.g. locked = ['x'] for its car body"
            )
        state = np.ascontiguousarray(found["x"], dtype=np.float64)
        self._near = state
        full = simulation.jacobian(0.0, state)[0]
        return Linearisation(speed, np.array(full[np.ix_(self.kept, self.kept)]), state, self._rows, self._inertia)


LEAST_FREQUENCY = 2 * np.pi * 0.05  # below this, an eigenvalue does not count as an oscillation [rad/s]

FOLLOWED_FREQUENCY = 2 * np.pi * 40.0
"""Up to here it is worth a further step to know which mode is which [rad/s]; above are wheels on their Hertz springs."""

CLEAR_MARGIN = 0.5
"""A pairing is clear if any other one costs at least this much more, of at most 2 for modes that have nothing in common."""

MOST_HALVINGS = 7  # a step is halved at most this often where modes are hard to tell apart


@dataclass(frozen=True)
class Eigensystem:
    """All eigenvalues of one matrix."""

    values: Complex  # eigenvalues [1/s], shape (n,)
    vectors: Complex  # right eigenvectors as columns, each of norm 1, shape (n, n)
    left: Complex  # left eigenvectors as columns, each of norm 1, shape (n, n): left[:, i]^H A = value[i] left[:, i]^H

    def reordered(self, columns: NDArray[np.intp]) -> "Eigensystem":
        """The same with its columns in another order."""
        return Eigensystem(self.values[columns], self.vectors[:, columns], self.left[:, columns])


@one_blas_thread()
def eigensystem(matrix: Array) -> Eigensystem:
    """Eigenvalues, right and left eigenvectors of A."""
    solution: tuple[Complex, Complex, Complex] = eig(matrix, left=True, check_finite=False)  # type: ignore[assignment]
    values, left, right = solution
    return Eigensystem(values.astype(np.complex128), right.astype(np.complex128), left.astype(np.complex128))


def oscillates(values: Complex) -> Mask:
    """Which eigenvalues are oscillations, one of each conjugate pair."""
    return np.asarray(values.imag > LEAST_FREQUENCY)


@one_blas_thread()
def modal_assurance(one: Eigensystem, other: Eigensystem) -> Array:
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
def predicted(system: Eigensystem, change: Array) -> Complex:
    """Eigenvalues after a small change of the matrix, to first order, (L9)."""
    own = np.sum(system.left.conj() * system.vectors, axis=0)
    shift = np.sum(system.left.conj() * (change @ system.vectors), axis=0)
    # near a double eigenvalue the slope is infinite: no prediction is better than a wild one
    usable = np.abs(own) > 1e-6
    shift = np.where(usable, shift / np.where(usable, own, 1.0), 0.0)
    reach = 0.5 * (1.0 + np.abs(system.values))
    shift *= np.minimum(1.0, reach / np.maximum(np.abs(shift), 1e-30))
    return np.asarray(system.values + shift)


def _costs(previous: Eigensystem, following: Eigensystem, change: Array | None) -> Array:
    ahead = previous.values if change is None else predicted(previous, change)
    back = following.values if change is None else predicted(following, -change)
    size = 1.0 + 0.5 * (np.abs(previous.values)[:, None] + np.abs(following.values)[None, :])
    distance = np.abs(ahead[:, None] - following.values[None, :]) + np.abs(previous.values[:, None] - back[None, :])
    # both of a pair are alike: where one of them becomes real, it is the one of negative frequency, and not as round-off has it
    ends = (previous.values.imag > 0.0)[:, None] & (following.values.imag == 0.0)[None, :]
    return np.asarray(0.5 * distance / size + 1.0 - modal_assurance(previous, following) + 1e-6 * ends)


@one_blas_thread()
def follow(previous: Eigensystem, following: Eigensystem, change: Array | None = None) -> tuple[NDArray[np.intp], bool]:
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
    """Modes along a parameter, each in one column."""

    parameters: Array  # the values asked for and those added between them, rising, shape (m,)
    asked: list[int]  # where the values asked for stand among them
    systems: list[Eigensystem]  # one eigensystem each, columns in one order
    unclear: list[float]  # parameters after which a pairing stayed unclear however small the step
    interrupted: bool = False  # whether Ctrl-C came before the last value; what was done until then is here

    def values(self) -> Complex:
        """Eigenvalues, shape (m, n)."""
        return np.array([system.values for system in self.systems])


def follow_modes(matrix_at: Callable[[float], Array], parameters: Sequence[float]) -> Followed:
    """Follow all modes of a real matrix along a rising parameter, with smaller steps where it is unclear which mode is which.

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
            least = (target - done[-1]) / 2**MOST_HALVINGS
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


def _solved(matrix_at: Callable[[float], Array], value: float) -> tuple[float, Array, Eigensystem]:
    matrix = matrix_at(value)
    return value, matrix, eigensystem(matrix)


def _signs_kept(system: Eigensystem, previous: Eigensystem, sign: Array) -> Eigensystem:
    """The columns of two that become a pair, or cease to be one, in an order that is a rule and not round-off.

    The one of positive frequency is that which had it before, else that which decays more slowly; it goes on as that.
    """
    columns = np.arange(len(system.values))
    for pair, apart, born in ((system.values, previous.values, True), (previous.values, system.values, False)):
        for upper in np.flatnonzero((pair.imag > 0.0) & (apart.imag == 0.0)).tolist():
            lower = int(np.argmin(np.abs(pair - pair[upper].conj())))
            earlier = sign[upper] - sign[lower] if born else 0.0
            if (earlier or apart[upper].real - apart[lower].real) < 0.0:
                columns[upper], columns[lower] = lower, upper
    return system.reordered(columns)


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


def energy_shares(linearisation: Linearisation, system: Eigensystem, columns: Sequence[int]) -> Array:
    """Share of each body coordinate in the kinetic energy of some modes; each column sums to 1.

    Returns:
        Shape (coordinates, modes), coordinates in the order of `linearisation.rate_rows`.
    """
    rows = list(linearisation.rate_rows.values())
    inertia = np.array([linearisation.inertia[key] for key in linearisation.rate_rows])
    energy = inertia[:, None] * np.abs(system.vectors[np.ix_(rows, columns)]) ** 2
    total = energy.sum(axis=0)
    return np.asarray(energy / np.where(total > 0.0, total, 1.0))


LEAST_PART = 0.7
"""A hunting wheelset moves sideways by at least this part of the largest lateral displacement of any body [1]."""

LEAST_DISPLACEMENT = 0.3
"""Least such displacement where the largest displacement of the mode is 1 m or rad: else it is no lateral motion."""

MOST_SLIDING = 0.5  # |dy/dt - V psi| of a hunting wheelset is at most this part of |dy/dt| + |V psi| [1]


def hunts(
    keys: Sequence[tuple[str, str]], speeds: Array, values: Complex, parts: Complex, wheelsets: Collection[str]
) -> Mask:
    """At which speeds a mode hunts.

    Args:
        keys: (body, direction) of each coordinate.
        speeds: running speeds [m/s], shape (speeds,).
        values: eigenvalues [1/s], shape (speeds, modes).
        parts: displacements, shape (speeds, coordinates, modes).
        wheelsets: names of the bodies that roll.

    Returns:
        Shape (speeds, modes).
    """
    rows = {key: row for row, key in enumerate(keys)}
    free = [name for name in wheelsets if (name, "lateral") in rows and (name, "yaw") in rows]
    if not free:
        return np.zeros(values.shape, dtype=np.bool_)
    lateral = parts[:, [rows[name, "lateral"] for name in free]]
    swept = values[:, None, :] * lateral
    carried = speeds[:, None, None] * parts[:, [rows[name, "yaw"] for name in free]]
    rolls = np.abs(swept - carried).sum(axis=1) <= MOST_SLIDING * (np.abs(swept) + np.abs(carried)).sum(axis=1)
    largest = np.abs(parts[:, [row for (_, way), row in rows.items() if way == "lateral"]]).max(axis=1)
    most = np.abs(lateral).max(axis=1)
    sideways = (most > 0.0) & (most >= LEAST_PART * largest) & (most >= LEAST_DISPLACEMENT * np.abs(parts).max(axis=1))
    return np.asarray((values.imag > LEAST_FREQUENCY) & sideways & rolls)


def frequency_of_hunting(names: Sequence[str], values: Complex, hunting: Mask) -> tuple[Array, Array]:
    """Frequency [Hz] and damping ratio [1] of hunting over speed: of the least damped mode named so that hunts there.

    Args:
        names: of the modes.
        values: eigenvalues [1/s], shape (speeds, modes).
        hunting: of `hunts`, same shape.

    Returns:
        Both of shape (speeds,); NaN where none of these modes hunts.
    """
    named = np.array([name.startswith("hunting") for name in names], dtype=np.bool_)
    damping = np.where(hunting & named, -values.real / np.maximum(np.abs(values), 1e-30), np.inf)
    found = np.full(len(values), complex(np.nan, np.nan))
    for k in np.flatnonzero(np.isfinite(damping).any(axis=1)):
        found[k] = values[k, damping[k].argmin()]
    return np.abs(found.imag) / (2 * np.pi), -found.real / np.abs(found)
