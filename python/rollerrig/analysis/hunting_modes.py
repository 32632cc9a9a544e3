"""Which modes are hunting, speed by speed: the wheelsets move most, and roll where they point.

    eigenvalues and shapes over speed -> [hunts] -> where each mode hunts -> names, frequency of hunting over speed

A wheelset that rolls without sliding sideways is carried along by its yaw,

    dy/dt = V psi,

the kinematics of Klingel's wave, on rollers with the speed of their surface. In a mode of the suspension it slides sideways
instead, or hardly moves. A mode that is followed over speed may be the one at low speed and the other at high speed: where the
frequency of hunting, which rises with speed, meets that of the car body's sway, the two exchange their shapes.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence

import numpy as np
from numpy.typing import NDArray

from rollerrig.analysis.modes import LEAST_FREQUENCY

LEAST_PART = 0.7
"""A hunting wheelset moves sideways by at least this part of the largest lateral displacement of any body [1]."""

LEAST_DISPLACEMENT = 0.3
"""Least such displacement where the largest displacement of the mode is 1 m or rad: else it is no lateral motion."""

MOST_SLIDING = 0.5
"""|dy/dt - V psi| of a hunting wheelset is at most this part of |dy/dt| + |V psi| [1]."""


def hunts(
    keys: Sequence[tuple[str, str]],
    speeds: NDArray[np.float64],
    values: NDArray[np.complex128],
    parts: NDArray[np.complex128],
    wheelsets: Collection[str],
) -> NDArray[np.bool_]:
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
    sliding = np.abs(swept - carried).sum(axis=1)
    whole = (np.abs(swept) + np.abs(carried)).sum(axis=1)
    largest = np.abs(parts[:, [row for (_, way), row in rows.items() if way == "lateral"]]).max(axis=1)
    most = np.abs(lateral).max(axis=1)
    return np.asarray(
        (values.imag > LEAST_FREQUENCY)
        & (most >= LEAST_DISPLACEMENT * np.abs(parts).max(axis=1))
        & (most > 0.0)
        & (most >= LEAST_PART * largest)
        & (sliding <= MOST_SLIDING * whole)
    )


def frequency_of_hunting(
    names: Sequence[str], values: NDArray[np.complex128], hunting: NDArray[np.bool_]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
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
    if values.shape[1]:
        best = damping.argmin(axis=1)
        some = np.isfinite(damping.min(axis=1))
        found[some] = values[some, best[some]]
    return np.abs(found.imag) / (2 * np.pi), -found.real / np.abs(found)
