"""Speeds at which an oscillation begins or ceases to grow: crossings of zero growth.

    modes over speed -> [crossings] -> all of them in the range, by speed, with the name of the mode -> critical speed

The growth rate of one mode, followed, is a smooth function of speed: its root is bracketed between neighbouring speeds and found
by Brent's method. Equation: docs/theory/equilibrium_and_linearisation.md, (L7).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rollerrig.analysis.mode_names import roles, shape_name
from rollerrig.analysis.modes import LEAST_FREQUENCY, body_shapes, eigensystem, energy_shares, modal_assurance
from rollerrig.analysis.speed_map import ModesOverSpeed

SPEED_TOLERANCE = 1e-4 / 3.6
"""Accuracy of a crossing [m/s]; far below the uncertainty of the model's parameters, far above round-off."""

LEAST_DIVERGENCE = 0.01
"""A motion that grows more slowly without oscillating is neutral: a vehicle coasting along its track [1/s]."""


@dataclass(frozen=True)
class Crossing:
    """Where an oscillation turns from damped to growing, or back.

    Attributes:
        speed: [m/s].
        frequency: of the mode [Hz].
        name: of the mode.
        grows_above: True: damped below, growing above; False: the other way round.
    """

    speed: float
    frequency: float
    name: str
    grows_above: bool = True


def zero_crossings(modes: ModesOverSpeed) -> list[Crossing]:
    """All speeds at which an oscillation begins or ends to grow, rising.

    Also found are modes that grow only between two neighbouring speeds, where their growth rate has a clear maximum there.
    """
    found = [one for mode in range(len(modes.columns)) for one in _of_mode(modes, mode)]
    return sorted(found, key=lambda one: one.speed)


def first_onset(crossings: Sequence[Crossing]) -> Crossing | None:
    """The lowest crossing above which a mode grows; None if there is none."""
    return next((one for one in crossings if one.grows_above), None)


def growing_at_start(modes: ModesOverSpeed) -> tuple[str, ...]:
    """Names of the oscillations that grow at the lowest speed."""
    first = modes.values[0]
    growing = (first.imag > LEAST_FREQUENCY) & (first.real > 0)
    return tuple(name for name, grows in zip(modes.names, growing, strict=True) if grows)


def diverging(modes: ModesOverSpeed) -> list[dict[str, object]]:
    """Motions that grow without oscillating, as a vehicle that nothing holds on top of its rollers.

    Returns:
        Per motion its `name`, the largest `growth_rate_per_s` and the `speed_kmh` where it has it.
    """
    every = modes.followed.values()[modes.asked]
    real = np.where(np.abs(every.imag) <= LEAST_FREQUENCY, every.real, -np.inf)
    who = roles(modes.lineariser.case)
    found: list[dict[str, object]] = []
    for column in np.flatnonzero(real.max(axis=0) > LEAST_DIVERGENCE).tolist():
        k = int(np.argmax(real[:, column]))
        speed = float(modes.speeds[modes.asked[k]])
        system, linear = modes.followed.systems[modes.asked[k]], modes.lineariser.at(speed)
        shares, parts = energy_shares(linear, system, [column])[:, 0], body_shapes(linear, system, [column])[:, 0]
        name = shape_name(modes.keys, shares, parts, who)
        found.append({"name": name, "growth_rate_per_s": float(real[k, column]), "speed_kmh": 3.6 * speed})
    return found


# ---------------------------------------------------------------------------------------------------- one mode


def _of_mode(modes: ModesOverSpeed, mode: int) -> list[Crossing]:
    speeds, values = modes.speeds, modes.values[:, mode]
    rate = np.where(values.imag > LEAST_FREQUENCY, values.real, -np.inf)
    found: list[Crossing] = []
    for k in range(len(speeds) - 1):
        if not np.all(np.isfinite(rate[k : k + 2])):
            continue  # no oscillation on one side: nothing that crosses
        if (rate[k] < 0) != (rate[k + 1] < 0):
            found.append(_root(modes, mode, k, float(speeds[k]), float(speeds[k + 1]), bool(rate[k] < 0)))
    for k in range(1, len(speeds) - 1):
        if np.all(np.isfinite(rate[k - 1 : k + 2])) and _may_hide(speeds[k - 1 : k + 2], rate[k - 1 : k + 2]):
            found += _hidden(modes, mode, k)
    return found


def _followed_value(modes: ModesOverSpeed, mode: int, k: int, speed: float) -> complex:
    """Eigenvalue of a mode at a speed between two known ones, k and k + 1."""
    column, speeds = modes.columns[mode], modes.speeds
    system = eigensystem(modes.lineariser.at(speed).matrix)
    weight = (speed - speeds[k]) / (speeds[k + 1] - speeds[k])
    expected = (1 - weight) * modes.values[k, mode] + weight * modes.values[k + 1, mode]
    alike = np.maximum(*(modal_assurance(modes.followed.systems[i], system)[column] for i in (k, k + 1)))
    distance = np.abs(system.values - expected) / (1.0 + np.abs(expected))
    return complex(system.values[int(np.argmin(distance + 1.0 - alike))])


def _root(modes: ModesOverSpeed, mode: int, k: int, low: float, high: float, grows_above: bool) -> Crossing:
    from scipy.optimize import brentq  # slow to load, and seldom needed

    def rate(speed: float) -> float:
        return _followed_value(modes, mode, k, speed).real

    speed = float(brentq(rate, low, high, xtol=SPEED_TOLERANCE))
    frequency = _followed_value(modes, mode, k, speed).imag / (2 * np.pi)
    return Crossing(speed, frequency, modes.names[mode], grows_above)


def _may_hide(speeds: np.ndarray, rate: np.ndarray) -> bool:
    """Whether a damped mode's maximum in the middle is so pronounced that it may be above zero between the speeds."""
    if not (rate[1] < 0 and rate[1] > rate[0] and rate[1] > rate[2]):
        return False
    curvature, slope, _ = np.polyfit(speeds - speeds[1], rate - rate[1], 2)
    rise = -(slope**2) / (4 * curvature) if curvature < 0 else 0.0
    return bool(rate[1] + 2.0 * rise > 0.0)


def _hidden(modes: ModesOverSpeed, mode: int, k: int) -> list[Crossing]:
    speeds = modes.speeds

    from scipy.optimize import minimize_scalar  # slow to load, and seldom needed

    def rate(speed: float) -> float:
        return _followed_value(modes, mode, k if speed >= speeds[k] else k - 1, speed).real

    top = minimize_scalar(
        lambda v: -rate(v), bounds=(speeds[k - 1], speeds[k + 1]), method="bounded", options={"xatol": 1e-2}
    )
    if not -top.fun > 0.0:
        return []
    at = float(top.x)
    inner = k if at >= speeds[k] else k - 1
    low, high = float(speeds[inner]), float(speeds[inner + 1])
    return [_root(modes, mode, inner, low, at, True), _root(modes, mode, inner, at, high, False)]
