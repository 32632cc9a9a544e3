"""Modes over speed and the linear critical speed.

Case, speeds -> [linearise, modes] -> Dataset over speed and mode; critical speed by root finding
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import xarray as xr
from scipy.optimize import brentq

from rollerrig import __version__
from rollerrig.analysis.linearise import DIRECTIONS, Lineariser
from rollerrig.analysis.modes import (
    HUNTING_SHARE,
    LEAST_FREQUENCY,
    body_shape,
    dominant_motion,
    eigensystem,
    energy_shares,
    oscillates,
    track,
    unique_names,
    wheelset_lateral_share,
)
from rollerrig.config import Case

FINEST_TRACKING = 5.0 / 3.6
"""Modes are followed in steps of speed no longer than this [m/s]."""

SPEED_TOLERANCE = 1e-4 / 3.6
"""Accuracy of a linear critical speed [m/s]; far below what the model knows, far above round-off."""


@dataclass(frozen=True)
class CriticalSpeed:
    """Where the least damped oscillation loses its damping.

    Attributes:
        speed: [m/s].
        frequency: of the mode that turns unstable [Hz].
        name: of its dominant motion; 'hunting' where the wheelsets run in waves.
    """

    speed: float
    frequency: float
    name: str


def stability(
    case: Case, speeds_kmh: Sequence[float], *, progress: Callable[[float, str], None] | None = None
) -> xr.Dataset:
    """Eigenvalues, frequency, damping and shapes of all oscillatory modes over speed.

    Args:
        case: what runs; its rollers or rails are held at each speed.
        speeds_kmh: running speeds [km/h], rising.
        progress: called with the fraction done and a short text.

    Returns:
        Dimensions speed, mode, body, direction; `growth_rate` [1/s], `frequency` [Hz], `damping` [1],
        `shape_amplitude` and `shape_phase` [deg], `energy_share` [1]. Modes are ordered by frequency at the highest speed.
        The attributes hold the linear critical speed within the range, or NaN, and whether Ctrl-C came first
        (`interrupted`, 0 or 1): then the speeds done until then are there.

    Raises:
        ValueError: speeds not rising or not positive.
        StartError: no rolling equilibrium at one of the speeds.
        KeyboardInterrupt: Ctrl-C came before the first speed was done.
    """
    speeds = np.asarray(speeds_kmh, dtype=np.float64) / 3.6
    if speeds.size == 0 or not np.all(np.isfinite(speeds)) or speeds[0] <= 0 or np.any(np.diff(speeds) <= 0):
        raise ValueError("speeds_kmh: allowed: positive speeds, each above the one before")
    lineariser = Lineariser(case)
    fine, asked = _refined(speeds)
    linearisations = []
    interrupted = False
    try:
        for done, speed in enumerate(fine):
            linearisations.append(lineariser.at(float(speed)))
            if progress is not None:
                progress(done / len(fine), f"{3.6 * speed:.0f} km/h")
    except KeyboardInterrupt:
        interrupted = True
        asked = [i for i in asked if i < len(linearisations)]
        if not asked:
            raise
        speeds, linearisations = speeds[: len(asked)], linearisations[: asked[-1] + 1]
    systems = track([eigensystem(item.matrix) for item in linearisations])
    values = np.array([systems[i].values for i in asked])
    sure = [m for m in range(values.shape[1]) if np.any(values[:, m].imag > LEAST_FREQUENCY)]
    modes = [m for m in sure if values[:, m].imag.mean() > 0]
    modes.sort(key=lambda m: float(abs(values[-1, m].imag)))
    shares = [
        [energy_shares(linearisations[i], systems[i].vectors[:, m]) for m in modes] for i in asked
    ]  # by speed, then mode
    names = _names(values[:, modes], shares)
    bodies = [b for b in lineariser.model.bodies if any(key[0] == b for key in linearisations[0].rate_rows)]
    shape = np.zeros((len(speeds), len(modes), len(bodies), 6), dtype=np.complex128)
    share = np.zeros(shape.shape)
    for k, i in enumerate(asked):
        for j, m in enumerate(modes):
            parts = body_shape(linearisations[i], systems[i].values[m], systems[i].vectors[:, m])
            for (body, direction), part in parts.items():
                at = (k, j, bodies.index(body), DIRECTIONS.index(direction))
                shape[at], share[at] = part, shares[k][j][body, direction]
    dataset = _dataset(speeds, names, bodies, values[:, modes], shape, share)
    rates = [float(systems[i].values[oscillates(systems[i].values)].real.max()) for i in asked]
    critical = linear_critical_speed(lineariser, speeds.tolist(), rates)
    return dataset.assign_attrs(
        title=f"Modes of {case.name} over speed",
        case=case.name,
        linear_critical_speed_kmh=3.6 * critical.speed if critical else np.nan,
        linear_critical_frequency_hz=critical.frequency if critical else np.nan,
        linear_critical_mode=critical.name if critical else "",
        interrupted=int(interrupted),
        config_toml=lineariser.case.to_toml(),
        rollerrig_version=__version__,
    )


def largest_growth_rate(lineariser: Lineariser, speed: float) -> float:
    """Largest real part of the oscillatory modes at a speed [1/s]; positive: a disturbance grows."""
    values = eigensystem(lineariser.at(speed).matrix).values
    return float(values[oscillates(values)].real.max())


def linear_critical_speed(
    case: Case | Lineariser, speeds: Sequence[float], rates: Sequence[float] | None = None
) -> CriticalSpeed | None:
    """The lowest speed at which an oscillatory mode turns from damped to growing.

    Args:
        case: the case, or its lineariser.
        speeds: speeds between which a change of sign is looked for [m/s], rising.
        rates: `largest_growth_rate` at each of them, where it is known already [1/s].

    Returns:
        The critical speed, to `SPEED_TOLERANCE`; None if nothing changes from damped to growing in the range.
    """
    lineariser = case if isinstance(case, Lineariser) else Lineariser(case)
    if rates is None:
        rates = [largest_growth_rate(lineariser, float(speed)) for speed in speeds]
    for k in range(len(rates) - 1):
        if rates[k] < 0 <= rates[k + 1]:
            low, high = float(speeds[k]), float(speeds[k + 1])
            speed = float(brentq(lambda v: largest_growth_rate(lineariser, v), low, high, xtol=SPEED_TOLERANCE))
            return _critical_mode(lineariser, speed)
    return None


def _critical_mode(lineariser: Lineariser, speed: float) -> CriticalSpeed:
    linearisation = lineariser.at(speed)
    system = eigensystem(linearisation.matrix)
    real = np.where(oscillates(system.values), system.values.real, -np.inf)
    mode = int(np.argmax(real))
    shares = energy_shares(linearisation, system.vectors[:, mode])
    hunting = wheelset_lateral_share(shares) >= HUNTING_SHARE
    name = "hunting" if hunting else dominant_motion(shares)
    return CriticalSpeed(speed, float(system.values[mode].imag) / (2 * np.pi), name)


def _refined(speeds: np.ndarray) -> tuple[np.ndarray, list[int]]:
    """Speeds with further ones between them, and where the asked ones stand."""
    fine: list[float] = [float(speeds[0])]
    asked = [0]
    for low, high in zip(speeds[:-1], speeds[1:], strict=True):
        parts = max(1, int(np.ceil((high - low) / FINEST_TRACKING)))
        fine += [float(low + (high - low) * k / parts) for k in range(1, parts)] + [float(high)]
        asked.append(len(fine) - 1)
    return np.array(fine), asked


def _names(values: np.ndarray, shares: list[list[dict[tuple[str, str], float]]]) -> list[str]:
    """Dominant motion of each mode on average over speed; 'hunting' for the least damped one in which wheelsets weave."""
    names, weave = [], []
    for j in range(values.shape[1]):
        mean = {key: float(np.mean([row[j][key] for row in shares])) for key in shares[0][j]}
        names.append(dominant_motion(mean))
        weave.append(wheelset_lateral_share(mean) >= HUNTING_SHARE)
    candidates = [j for j in range(len(names)) if weave[j]]
    if candidates:
        hunting = max(candidates, key=lambda j: float(values[:, j].real.mean()))
        names[hunting] = "hunting"
    return unique_names(names)


def _dataset(
    speeds: np.ndarray,
    names: list[str],
    bodies: list[str],
    values: np.ndarray,
    shape: np.ndarray,
    share: np.ndarray,
) -> xr.Dataset:
    frequency = np.abs(values.imag) / (2 * np.pi)
    damping = -values.real / np.abs(values)
    dims = ("speed", "mode", "body", "direction")
    variables = {
        "growth_rate": (
            dims[:2],
            values.real,
            {"units": "1/s", "long_name": "real part of the eigenvalue; > 0: grows"},
        ),
        "angular_frequency": (dims[:2], np.abs(values.imag), {"units": "rad/s", "long_name": "imaginary part"}),
        "frequency": (dims[:2], frequency, {"units": "Hz", "long_name": "frequency"}),
        "damping": (dims[:2], damping, {"units": "1", "long_name": "damping ratio, -Re / |eigenvalue|"}),
        "shape_amplitude": (
            dims,
            np.abs(shape),
            {"units": "1", "long_name": "displacement amplitude, m or rad; the largest one is 1"},
        ),
        "shape_phase": (
            dims,
            np.degrees(np.angle(shape)),
            {"units": "deg", "long_name": "phase lead of the displacement"},
        ),
        "energy_share": (dims, share, {"units": "1", "long_name": "share of the mode's kinetic energy"}),
    }
    coordinates = {
        "speed": ("speed", 3.6 * speeds, {"units": "km/h", "long_name": "running speed"}),
        "mode": ("mode", np.array(names, dtype=str), {"long_name": "mode, named by its dominant motion"}),
        "body": ("body", np.array(bodies, dtype=str), {"long_name": "body"}),
        "direction": ("direction", np.array(DIRECTIONS, dtype=str), {"long_name": "direction"}),
    }
    return xr.Dataset(variables, coordinates)
