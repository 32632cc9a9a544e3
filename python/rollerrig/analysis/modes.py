"""Eigenvalues and mode shapes, followed from speed to speed, with names.

    A over speed -> [modes] -> one row per mode and speed: eigenvalue, frequency, damping, shape

Equations: docs/theory/equilibrium_and_linearisation.md, (L5)-(L6).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from rollerrig.analysis.linearise import Linearisation

Complex = NDArray[np.complex128]

LEAST_FREQUENCY = 2 * np.pi * 0.05
"""Below this, an eigenvalue does not count as an oscillation [rad/s]."""

HUNTING_SHARE = 0.2
"""Least share of the kinetic energy that a hunting mode has in the lateral motion of wheelsets."""


@dataclass(frozen=True)
class Eigensystem:
    """All eigenvalues of one linearisation.

    Attributes:
        values: eigenvalues [1/s], shape (n,).
        vectors: right eigenvectors as columns, each of norm 1, shape (n, n).
    """

    values: Complex
    vectors: Complex


def eigensystem(matrix: NDArray[np.float64]) -> Eigensystem:
    """Eigenvalues and eigenvectors of A."""
    values, vectors = np.linalg.eig(matrix)
    return Eigensystem(values.astype(np.complex128), vectors.astype(np.complex128))


def oscillates(values: Complex) -> NDArray[np.bool_]:
    """Which eigenvalues are oscillations, one of each conjugate pair."""
    return np.asarray(values.imag > LEAST_FREQUENCY)


def follow(previous: Eigensystem, following: Eigensystem) -> NDArray[np.intp]:
    """Which mode of the next speed continues each mode of this one.

    The pairing with the least sum of relative eigenvalue distance and 1 - MAC, the modal assurance criterion
    |u* v|^2 / (|u|^2 |v|^2): the distance alone confuses modes that cross, the shapes alone those that are alike.

    Returns:
        Column of `following` for each column of `previous`, shape (n,).
    """
    size = 1.0 + 0.5 * (np.abs(previous.values)[:, None] + np.abs(following.values)[None, :])
    distance = np.abs(previous.values[:, None] - following.values[None, :]) / size
    mac = np.abs(previous.vectors.conj().T @ following.vectors) ** 2
    _, columns = linear_sum_assignment(distance + (1.0 - mac))
    return np.asarray(columns)


def track(systems: list[Eigensystem]) -> list[Eigensystem]:
    """The same eigensystems with their columns in one order, mode by mode."""
    ordered = systems[:1]
    for system in systems[1:]:
        columns = follow(ordered[-1], system)
        ordered.append(Eigensystem(system.values[columns], system.vectors[:, columns]))
    return ordered


def body_shape(linearisation: Linearisation, value: complex, vector: Complex) -> dict[tuple[str, str], complex]:
    """Displacement of each body coordinate in a mode, the largest one 1 (rotations: per radian on 1 m).

    Taken from the rates, divided by the eigenvalue: wheelsets have no pitch angle among the states.
    """
    shape = {key: complex(vector[row]) / value for key, row in linearisation.rate_rows.items()}
    largest = max(shape.values(), key=abs)
    return {key: part / largest for key, part in shape.items()} if largest else shape


def energy_shares(linearisation: Linearisation, vector: Complex) -> dict[tuple[str, str], float]:
    """Share of each body coordinate in the kinetic energy of a mode; they sum to 1."""
    energy = {key: linearisation.inertia[key] * abs(vector[row]) ** 2 for key, row in linearisation.rate_rows.items()}
    total = sum(energy.values())
    return {key: part / total for key, part in energy.items()} if total > 0 else energy


def dominant_motion(shares: dict[tuple[str, str], float]) -> str:
    """Name of a mode by what moves most: 'front_frame pitch'; wheelsets of one kind count together."""
    grouped: dict[str, float] = {}
    for (body, direction), share in shares.items():
        kind = "wheelsets" if body.startswith("wheelset") else body
        name = f"{kind} {direction}"
        grouped[name] = grouped.get(name, 0.0) + share
    return max(grouped, key=lambda name: grouped[name])


def wheelset_lateral_share(shares: dict[tuple[str, str], float]) -> float:
    """How much of a mode's kinetic energy is lateral motion of wheelsets: large only where they run in waves."""
    return sum(s for (body, direction), s in shares.items() if body.startswith("wheelset") and direction == "lateral")


def unique_names(names: list[str]) -> list[str]:
    """Names made different: 'frame yaw', 'frame yaw 2'."""
    seen: dict[str, int] = {}
    result = []
    for name in names:
        seen[name] = seen.get(name, 0) + 1
        result.append(name if seen[name] == 1 else f"{name} {seen[name]}")
    return result
