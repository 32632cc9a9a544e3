"""All oscillatory modes of one case over speed, followed and named.

Case, speeds -> [linearise, modes, mode names] -> ModesOverSpeed -> critical speeds, Dataset
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rollerrig.analysis.hunting_modes import hunts
from rollerrig.analysis.linearise import Linearisation, Lineariser
from rollerrig.analysis.mode_names import Shapes, mode_names, roles
from rollerrig.analysis.modes import LEAST_FREQUENCY, Complex, Followed, body_shapes, energy_shares, follow_modes
from rollerrig.config import Case

Matrix = NDArray[np.float64]

SPEEDS_KMH = tuple(float(v) for v in range(60, 301, 20))
"""Speeds of a stability analysis unless others are given [km/h]."""

FINEST_STEP = 10.0 / 3.6
"""Between two speeds no crossing of zero growth is looked for twice: steps are no longer than this [m/s]."""


@dataclass(frozen=True)
class ModesOverSpeed:
    """Modes at the speeds asked for and at those between them.

    Attributes:
        lineariser: of the case.
        followed: eigensystems over speed [m/s], all columns.
        asked: where the speeds asked for stand among `followed.parameters`.
        columns: of the eigensystems, one per oscillatory mode, by frequency at the highest speed.
        names: of these modes.
        values: their eigenvalues [1/s], shape (speeds, modes).
        keys: (body, direction) of each coordinate.
        shapes: displacements, shape (speeds, coordinates, modes).
        shares: of the kinetic energy, same shape.
        hunting: where a mode hunts, shape (speeds, modes).
    """

    lineariser: Lineariser
    followed: Followed
    asked: list[int]
    columns: list[int]
    names: list[str]
    values: Complex
    keys: list[tuple[str, str]]
    shapes: Complex
    shares: Matrix
    hunting: NDArray[np.bool_]

    @property
    def speeds(self) -> Matrix:
        """All speeds [m/s]."""
        return self.followed.parameters


def modes_over_speed(
    case: Case | Lineariser, speeds: Sequence[float], progress: Callable[[float, str], None] | None = None
) -> ModesOverSpeed:
    """Follow the oscillatory modes of a case over speed.

    Args:
        case: the case, or its lineariser.
        speeds: running speeds [m/s], positive, rising.
        progress: called with the fraction done and a short text.

    Raises:
        ValueError: speeds not rising or not positive.
        StartError: no rolling equilibrium at one of the speeds.
        KeyboardInterrupt: Ctrl-C came before the first speed was done.
    """
    wanted = np.asarray(speeds, dtype=np.float64)
    if wanted.size == 0 or not np.all(np.isfinite(wanted)) or wanted[0] <= 0 or np.any(np.diff(wanted) <= 0):
        raise ValueError("speeds_kmh: allowed: positive speeds, each above the one before")
    lineariser = case if isinstance(case, Lineariser) else Lineariser(case)
    linearisations: dict[float, Linearisation] = {}

    def matrix_at(speed: float) -> Matrix:
        if progress is not None and speed in wanted:
            progress(int(np.searchsorted(wanted, speed)) / len(wanted), f"{3.6 * speed:.0f} km/h")
        linearisations[speed] = lineariser.at(speed)
        return linearisations[speed].matrix

    fine, at = refined(wanted)
    followed = follow_modes(matrix_at, fine.tolist())
    asked = [followed.asked[i] for i in at if i < len(followed.asked)]
    return _named(lineariser, followed, asked, [linearisations[v] for v in followed.parameters.tolist()])


def _named(
    lineariser: Lineariser, followed: Followed, asked: list[int], linearisations: list[Linearisation]
) -> ModesOverSpeed:
    every = followed.values()
    oscillating = np.any(every.imag > LEAST_FREQUENCY, axis=0) & (every.imag.mean(axis=0) > 0)
    columns = sorted(np.flatnonzero(oscillating).tolist(), key=lambda m: abs(every[-1, m].imag))
    pairs = list(zip(linearisations, followed.systems, strict=True))
    shapes = np.array([body_shapes(linear, system, columns) for linear, system in pairs])
    shares = np.array([energy_shares(linear, system, columns) for linear, system in pairs])
    keys = list(linearisations[0].rate_rows)
    values = every[:, columns]
    who = roles(lineariser.case)
    hunting = hunts(keys, followed.parameters, values, shapes, who.wheelsets)
    names = mode_names(Shapes(keys, values.real, shares, shapes, hunting), who)
    return ModesOverSpeed(lineariser, followed, asked, columns, names, values, keys, shapes, shares, hunting)


def refined(speeds: Matrix) -> tuple[Matrix, list[int]]:
    """Speeds with further ones between them, no step longer than FINEST_STEP, and where the asked ones stand."""
    fine: list[float] = [float(speeds[0])]
    asked = [0]
    for low, high in zip(speeds[:-1], speeds[1:], strict=True):
        parts = max(1, int(np.ceil((high - low) / FINEST_STEP * (1 - 1e-9))))
        fine += [float(low + (high - low) * k / parts) for k in range(1, parts)] + [float(high)]
        asked.append(len(fine) - 1)
    return np.array(fine), asked
