"""Modes over speed and the linear critical speeds as one Dataset.

Case, speeds -> [speed map, critical] -> Dataset over speed, mode, body and direction
"""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence

import numpy as np
import xarray as xr

from rollerrig import __version__
from rollerrig.analysis.crossings import diverging, first_onset, growing_at_start, zero_crossings
from rollerrig.analysis.hunting_modes import frequency_of_hunting
from rollerrig.analysis.linearise import DIRECTIONS
from rollerrig.analysis.mode_names import roles
from rollerrig.analysis.speed_map import SPEEDS_KMH, ModesOverSpeed, modes_over_speed
from rollerrig.cases import as_case
from rollerrig.config import Case
from rollerrig.results import variable
from rollerrig.results.run_info import describe


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
    table = [
        {
            "speed_kmh": 3.6 * one.speed,
            "frequency_hz": one.frequency,
            "mode": one.name,
            "grows": "above" if one.grows_above else "below",
        }
        for one in crossings
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
    rates = {
        name: float(modes.values[:, m].real.max()) for m, name in enumerate(modes.names) if name.startswith("hunting")
    }
    return max(rates, key=lambda name: rates[name], default="")


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
