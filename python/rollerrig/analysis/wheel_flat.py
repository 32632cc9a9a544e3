"""How long a flat a locked wheel gets, as an estimate from the energy that its sliding dissipates.

run of `simulate` with a brake -> [wheel_flat] -> length of the longest flat [m]

The worn volume is in proportion to the energy; what is worn off a wheel that does not turn is a segment of its circle under a
chord: V = k E, V = b L^3 / (12 r) for L << r, (H1) and (H2) of docs/theory/wheel_flats.md. Heat, martensite and the rounding of
the flat's ends are left out. On the rig no wheel slides so: the estimate is what the virtual train's wheels would get.
"""

from __future__ import annotations

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from rollerrig.analysis.slide_statistics import LOCKED
from rollerrig.analysis.tracking import slip, wheel_radius


def flat_length(energy: float, radius: float, wear: float, width: float) -> float:
    """Length of a flat [m].

        V = k E        (H1)
        L = (12 r V / b)^(1/3)        (H2)

    Args:
        energy: E, dissipated under one wheel while it did not turn [J].
        radius: r of the wheel [m].
        wear: k, volume worn off per energy [m^3/J].
        width: b of the flat across the tread [m].

    Example:
        >>> round(1e3 * flat_length(165e3, radius=0.46, wear=7e-13, width=0.012), 1)
        37.6
    """
    return float(np.cbrt(12.0 * radius * wear * energy / width))


def lock_energies(run: xr.Dataset) -> NDArray[np.float64]:
    """Energy dissipated under each wheel of an axle in each of its locks, of all axles [J].

    A lock lasts while the axle turns slower than LOCKED of the speed of a train that is not too slow for slips.
    """
    time, train = run["time"].to_numpy(), run["train_speed"].to_numpy()
    sliding = train[:, None] - wheel_radius(run) * run["axle_speed"].transpose("time", "axle").to_numpy()
    power = 0.5 * np.abs(run["creep_force"].transpose("time", "axle").to_numpy() * sliding)  # of one wheel
    locked = (slip(run) < LOCKED - 1.0).transpose("axle", "time").to_numpy()
    found = []
    for axle, own in enumerate(locked):
        edges = np.flatnonzero(np.diff(np.concatenate([[False], own, [False]]).astype(int)))
        for first, end in zip(edges[::2], edges[1::2], strict=True):
            last = min(end, time.size - 1)  # to the first sample at which it turns again
            found.append(float(np.trapezoid(power[first : last + 1, axle], time[first : last + 1])))
    return np.array(found)


def longest_flat(run: xr.Dataset, wear: float, width: float) -> float:
    """Length of the longest flat that a run leaves, each lock at another place of the tread [m]."""
    energies = lock_energies(run)
    return flat_length(float(energies.max()), wheel_radius(run), wear, width) if energies.size else 0.0
