"""Modes over speed, the speeds at which an oscillation begins or ceases to grow, and linear critical speeds as one Dataset.

    Case, speeds -> [Lineariser, modes, mode names] -> ModesOverSpeed -> critical speeds, Dataset over speed, mode, body
    modes over speed -> [crossings] -> all of them in the range, by speed, with the name of the mode -> critical speed

The growth rate of one mode, followed, is a smooth function of speed: its root is bracketed between neighbouring speeds and found
by Brent's method. Equation: docs/theory/equilibrium_and_linearisation.md, (L7).
"""

import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import xarray as xr

from rollerrig import __version__
from rollerrig.analysis import SPEEDS_KMH
from rollerrig.analysis.mode_names import Shapes, mode_names, roles, shape_name
from rollerrig.analysis.modes import (
    DIRECTIONS,
    LEAST_FREQUENCY,
    Followed,
    Linearisation,
    Lineariser,
    body_shapes,
    eigensystem,
    energy_shares,
    follow_modes,
    frequency_of_hunting,
    hunts,
    modal_assurance,
)
from rollerrig.cases import as_case
from rollerrig.common.arrays import Array, Complex, Mask
from rollerrig.config import Case
from rollerrig.results import variable
from rollerrig.results.run_info import describe

FINEST_STEP = 10.0 / 3.6
"""Between two speeds no crossing of zero growth is looked for twice: steps are no longer than this [m/s]."""


@dataclass(frozen=True)
class ModesOverSpeed:
    """Modes at the speeds asked for and at those between them."""

    lineariser: Lineariser  # of the case
    followed: Followed  # eigensystems over speed [m/s], all columns
    asked: list[int]  # where the speeds asked for stand among `followed.parameters`
    columns: list[int]  # of the eigensystems, one per oscillatory mode, by frequency at the highest speed
    names: list[str]  # of these modes
    values: Complex  # their eigenvalues [1/s], shape (speeds, modes)
    keys: list[tuple[str, str]]  # (body, direction) of each coordinate
    shapes: Complex  # displacements, shape (speeds, coordinates, modes)
    shares: Array  # of the kinetic energy, same shape
    hunting: Mask  # where a mode hunts, shape (speeds, modes)

    @property
    def speeds(self) -> Array:
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

    def matrix_at(speed: float) -> Array:
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
    columns = sorted(np.flatnonzero(oscillating).tolist(), key=lambda m: (abs(every[-1, m].imag), every[-1, m].real))
    pairs = list(zip(linearisations, followed.systems, strict=True))
    shapes = np.array([body_shapes(linear, system, columns) for linear, system in pairs])
    shares = np.array([energy_shares(linear, system, columns) for linear, system in pairs])
    keys = list(linearisations[0].rate_rows)
    values = every[:, columns]
    who = roles(lineariser.case)
    hunting = hunts(keys, followed.parameters, values, shapes, who.wheelsets)
    names = mode_names(Shapes(keys, values.real, shares, shapes, hunting), who)
    return ModesOverSpeed(lineariser, followed, asked, columns, names, values, keys, shapes, shares, hunting)


def refined(speeds: Array) -> tuple[Array, list[int]]:
    """Speeds with further ones between them, no step longer than FINEST_STEP, and where the asked ones stand."""
    parts = np.maximum(1, np.ceil(np.diff(speeds) / FINEST_STEP * (1 - 1e-9)).astype(int))
    steps = [low + (high - low) * np.arange(n) / n for low, high, n in zip(speeds, speeds[1:], parts, strict=False)]
    return np.concatenate([*steps, speeds[-1:]]), [0, *np.cumsum(parts).tolist()]


SPEED_TOLERANCE = 1e-4 / 3.6
"""Accuracy of a crossing [m/s]; far below the uncertainty of the model's parameters, far above round-off."""

LEAST_DIVERGENCE = 0.01
"""A motion that grows more slowly without oscillating is neutral: a vehicle coasting along its track [1/s]."""


@dataclass(frozen=True)
class Crossing:
    """Speed [m/s] at which an oscillation, with its frequency [Hz] there, turns from damped to growing, or back."""

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


def _of_mode(modes: ModesOverSpeed, mode: int) -> list[Crossing]:
    speeds, values = modes.speeds, modes.values[:, mode]
    rate = np.where(values.imag > LEAST_FREQUENCY, values.real, -np.inf)
    found: list[Crossing] = []
    for k in range(len(speeds) - 1):  # where there is an oscillation on both sides
        if np.all(np.isfinite(rate[k : k + 2])) and (rate[k] < 0) != (rate[k + 1] < 0):
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

    ends = (speeds[k - 1], speeds[k + 1])
    top = minimize_scalar(lambda v: -rate(v), bounds=ends, method="bounded", options={"xatol": 1e-2})
    if not -top.fun > 0.0:
        return []
    at = float(top.x)
    inner = k if at >= speeds[k] else k - 1
    low, high = float(speeds[inner]), float(speeds[inner + 1])
    return [_root(modes, mode, inner, low, at, True), _root(modes, mode, inner, at, high, False)]


def stability(
    case: Case | str, speeds_kmh: Sequence[float] = SPEEDS_KMH, *, progress: Callable[[float, str], None] | None = None
) -> xr.Dataset:
    """Eigenvalues, frequency, damping and shapes of all oscillatory modes over speed.

    Args:
        case: what runs, or its name in the catalogue; its rollers or rails are speed-controlled.
        speeds_kmh: running speeds [km/h], rising.
        progress: called with the fraction done and a short text.

    Returns:
        Dimensions speed, mode, body, direction; `growth_rate` [1/s], `frequency` [Hz], `damping` [1],
        `shape_amplitude` and `shape_phase` [deg], `energy_share` [1], `position` [m] of the bodies, `hunting_frequency` [Hz] and
        `hunting_damping` [1] over speed. Modes are ordered by frequency at the highest speed. The attributes hold the linear
        critical speed within the range, or NaN, all crossings of zero growth (`crossings`, JSON), motions that grow without
        oscillating (`diverging`, JSON), the name of the least damped hunting mode or '', and whether Ctrl-C came first
        (`interrupted`, 0 or 1): then the speeds done until then are there.

    Raises:
        ValueError: speeds not rising or not positive.
        StartError: no rolling equilibrium at one of the speeds.
        KeyboardInterrupt: Ctrl-C came before the first speed was done.

    Example:
        >>> import rollerrig as rr
        >>> modes = rr.stability("wheelset_rollers", [100.0, 200.0])
        >>> modes["damping"].sizes["speed"]
        2
    """
    case = as_case(case)
    modes = modes_over_speed(case, [v / 3.6 for v in speeds_kmh], progress)
    crossings = zero_crossings(modes)
    critical = first_onset(crossings)
    sides = ("below", "above")
    table = [
        {"speed_kmh": 3.6 * c.speed, "frequency_hz": c.frequency, "mode": c.name, "grows": sides[c.grows_above]}
        for c in crossings
    ]
    return _dataset(modes).assign_attrs(
        title=f"Modes of {case.name} over speed",
        case=case.name,
        linear_critical_speed_kmh=3.6 * critical.speed if critical else np.nan,
        linear_critical_frequency_hz=critical.frequency if critical else np.nan,
        linear_critical_mode=critical.name if critical else "",
        crossings=json.dumps(table),
        grows_at_lowest_speed=json.dumps(growing_at_start(modes)),
        diverging=json.dumps(diverging(modes)),
        hunting_mode=_hunting(modes),
        interrupted=int(modes.followed.interrupted),
        run_info=describe(modes.lineariser.model).to_json(),
        config_toml=modes.lineariser.case.to_toml(),
        rollerrig_version=__version__,
    )


def _hunting(modes: ModesOverSpeed) -> str:
    """The hunting mode that comes nearest to growing; '' if wheelsets weave in none."""
    rates = dict(zip(modes.names, modes.values.real.max(axis=0), strict=True))
    return max((name for name in rates if name.startswith("hunting")), key=lambda name: rates[name], default="")


def _dataset(modes: ModesOverSpeed) -> xr.Dataset:
    values = modes.values[modes.asked]
    bodies = [b for b in modes.lineariser.model.bodies if any(key[0] == b for key in modes.keys)]
    shape = np.zeros((len(modes.asked), len(modes.names), len(bodies), 6), dtype=np.complex128)
    share = np.zeros(shape.shape)
    for row, (body, direction) in enumerate(modes.keys):
        place = (slice(None), slice(None), bodies.index(body), DIRECTIONS.index(direction))
        shape[place] = modes.shapes[modes.asked, row]
        share[place] = modes.shares[modes.asked, row]
    frequency = np.abs(values.imag) / (2 * np.pi)
    damping = -values.real / np.abs(values)
    position = np.array([modes.lineariser.model.positions[body] for body in bodies])
    who = roles(modes.lineariser.case)
    dims = ("speed", "mode", "body", "direction")
    hunting = frequency_of_hunting(modes.names, values, modes.hunting[modes.asked])
    variables = {
        "growth_rate": variable(dims[:2], values.real, "1/s", "real part of the eigenvalue; > 0: grows"),
        "angular_frequency": variable(dims[:2], np.abs(values.imag), "rad/s", "imaginary part"),
        "frequency": variable(dims[:2], frequency, "Hz", "frequency"),
        "damping": variable(dims[:2], damping, "1", "damping ratio, -Re / |eigenvalue|"),
        "shape_amplitude": variable(dims, np.abs(shape), "1", "displacement amplitude, m or rad; the largest one is 1"),
        "shape_phase": variable(dims, np.degrees(np.angle(shape)), "deg", "phase lead of the displacement"),
        "energy_share": variable(dims, share, "1", "share of the mode's kinetic energy"),
        "hunting_frequency": variable("speed", hunting[0], "Hz", "frequency of hunting; NaN where no mode hunts"),
        "hunting_damping": variable("speed", hunting[1], "1", "its damping ratio"),
        "position": variable(("body", "axis"), position, "m", "design position"),
        "role": ("body", np.array([who.kind(body) for body in bodies], dtype=str), {"long_name": "what the body is"}),
    }
    coordinates = {
        "speed": variable("speed", 3.6 * modes.speeds[modes.asked], "km/h", "running speed"),
        "mode": ("mode", np.array(modes.names, dtype=str), {"long_name": "mode, named by its dominant motion"}),
        "body": ("body", np.array(bodies, dtype=str), {"long_name": "body"}),
        "direction": ("direction", np.array(DIRECTIONS, dtype=str), {"long_name": "direction"}),
        "axis": ("axis", np.array(["x", "y", "z"], dtype=str), {"long_name": "axis"}),
    }
    return xr.Dataset(variables, coordinates)
