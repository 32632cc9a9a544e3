"""Linear critical speeds: where an oscillation begins or ends to grow.

    modes over speed -> [critical] -> all crossings of zero growth in the range, by speed, with the name of the mode

The growth rate of one mode, followed, is a smooth function of speed: its root is bracketed between neighbouring speeds and found
by Brent's method. Equation: docs/theory/equilibrium_and_linearisation.md, (L7).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from scipy.optimize import brentq, minimize_scalar

from rollerrig.analysis.linearise import Lineariser
from rollerrig.analysis.mode_names import roles, shape_name
from rollerrig.analysis.modes import LEAST_FREQUENCY, body_shapes, eigensystem, energy_shares, likeness, oscillates
from rollerrig.analysis.parallel import Progress, run_jobs
from rollerrig.analysis.speed_map import ModesOverSpeed, modes_over_speed
from rollerrig.config import Case
from rollerrig.starting_state import StartError

SPEED_TOLERANCE = 1e-4 / 3.6
"""Accuracy of a linear critical speed [m/s]; far below what the model knows, far above round-off."""

LEAST_DIVERGENCE = 0.01
"""A motion that grows more slowly without oscillating is neutral: a vehicle coasting along its track [1/s]."""


@dataclass(frozen=True)
class CriticalSpeed:
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


def critical_speeds(modes: ModesOverSpeed) -> list[CriticalSpeed]:
    """All speeds at which an oscillation begins or ends to grow, rising.

    Also found are modes that grow only between two neighbouring speeds, where their growth rate has a clear maximum there.
    """
    found = [one for mode in range(len(modes.columns)) for one in _of_mode(modes, mode)]
    return sorted(found, key=lambda one: one.speed)


def linear_critical_speed(
    case: Case | Lineariser, speeds: Sequence[float], progress: Callable[[float, str], None] | None = None
) -> CriticalSpeed | None:
    """The lowest speed at which an oscillatory mode turns from damped to growing.

    Args:
        case: the case, or its lineariser.
        speeds: range of speeds [m/s], rising; where they are far apart, further ones are put between them.
        progress: called with the fraction done and a short text.

    Returns:
        The critical speed, to `SPEED_TOLERANCE`; None if nothing changes from damped to growing in the range.

    Raises:
        ValueError: speeds not rising or not positive.
        StartError: no rolling equilibrium at one of the speeds.
    """
    return first_onset(critical_speeds(modes_over_speed(case, speeds, progress)))


def first_onset(crossings: Sequence[CriticalSpeed]) -> CriticalSpeed | None:
    """The lowest crossing above which a mode grows; None if there is none."""
    return next((one for one in crossings if one.grows_above), None)


def largest_growth_rate(lineariser: Lineariser, speed: float) -> float:
    """Largest real part of the oscillatory modes at a speed [1/s]; positive: a disturbance grows."""
    values = eigensystem(lineariser.at(speed).matrix).values
    return float(values[oscillates(values)].real.max(initial=-math.inf))


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


def _of_mode(modes: ModesOverSpeed, mode: int) -> list[CriticalSpeed]:
    speeds, values = modes.speeds, modes.values[:, mode]
    rate = np.where(values.imag > LEAST_FREQUENCY, values.real, -np.inf)
    found: list[CriticalSpeed] = []
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
    alike = np.maximum(*(likeness(modes.followed.systems[i], system)[column] for i in (k, k + 1)))
    distance = np.abs(system.values - expected) / (1.0 + np.abs(expected))
    return complex(system.values[int(np.argmin(distance + 1.0 - alike))])


def _root(modes: ModesOverSpeed, mode: int, k: int, low: float, high: float, grows_above: bool) -> CriticalSpeed:
    def rate(speed: float) -> float:
        return _followed_value(modes, mode, k, speed).real

    speed = float(brentq(rate, low, high, xtol=SPEED_TOLERANCE))
    frequency = _followed_value(modes, mode, k, speed).imag / (2 * np.pi)
    return CriticalSpeed(speed, frequency, modes.names[mode], grows_above)


def _may_hide(speeds: np.ndarray, rate: np.ndarray) -> bool:
    """Whether a damped mode's maximum in the middle is so pronounced that it may be above zero between the speeds."""
    if not (rate[1] < 0 and rate[1] > rate[0] and rate[1] > rate[2]):
        return False
    curvature, slope, _ = np.polyfit(speeds - speeds[1], rate - rate[1], 2)
    rise = -(slope**2) / (4 * curvature) if curvature < 0 else 0.0
    return bool(rate[1] + 2.0 * rise > 0.0)


def _hidden(modes: ModesOverSpeed, mode: int, k: int) -> list[CriticalSpeed]:
    speeds = modes.speeds

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


# ---------------------------------------------------------------------------------------------------- many cases


@dataclass(frozen=True)
class CriticalScan:
    """Linear critical speeds of one case in a range.

    Attributes:
        critical: the lowest onset; None if there is none in the range.
        crossings: all of them, by speed.
        grows_at_start: names of the modes that grow already at the lowest speed.
        problem: why nothing could be computed; '' if it could.
    """

    critical: CriticalSpeed | None = None
    crossings: list[CriticalSpeed] = field(default_factory=list)
    grows_at_start: tuple[str, ...] = ()
    problem: str = ""

    @property
    def speed_kmh(self) -> float:
        """The critical speed [km/h]; NaN if there is none."""
        return math.nan if self.critical is None else 3.6 * self.critical.speed


def scan_case(job: tuple[Case, Sequence[float]], progress: Progress | None = None) -> CriticalScan:
    """Critical speeds of one case between speeds [m/s]; a case without equilibrium is told, not raised.

    Raises:
        KeyboardInterrupt: Ctrl-C came before the end.
    """
    case, speeds = job
    try:
        modes = modes_over_speed(case, speeds, progress)
    except StartError as problem:
        return CriticalScan(problem=str(problem))
    if modes.followed.interrupted:
        raise KeyboardInterrupt
    crossings = critical_speeds(modes)
    return CriticalScan(first_onset(crossings), crossings, growing_at_start(modes))


def linear_critical_speeds(
    cases: Mapping[str, Case],
    speeds_kmh: Sequence[float],
    *,
    processes: int = 1,
    progress: Progress | None = None,
) -> dict[str, CriticalScan]:
    """Linear critical speeds of several cases, such as radii of rollers, vehicles or supports.

    Args:
        cases: label -> case.
        speeds_kmh: range of speeds [km/h], rising; where they are far apart, further ones are put between them.
        processes: cases at a time.
        progress: called with the fraction done and a short text.

    Returns:
        Label -> what was found, in the order of `cases`; after Ctrl-C, those that were done.

    Example:
        >>> from rollerrig import load_case
        >>> rig = load_case("bogie_rollers_constant")
        >>> radii = {f"{r} m": rig.with_changes({"support.roller_radius": r}) for r in (0.5, 1.0)}
        >>> found = linear_critical_speeds(radii, [60, 400])
        >>> found["0.5 m"].speed_kmh < found["1.0 m"].speed_kmh
        True
    """
    labels = list(cases)
    jobs = [(cases[label], [v / 3.6 for v in speeds_kmh]) for label in labels]
    done = run_jobs(scan_case, jobs, processes=processes, progress=progress, names=labels)
    return {label: scan for label, scan in zip(labels, done.results, strict=True) if scan is not None}
