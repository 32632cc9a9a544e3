"""Equivalent conicity: the cone whose wheelset would weave as long as this one does.

    rolling radius difference over lateral shift -> [kinematic motion integrated] -> wavelength, conicity over amplitude

A free wheelset that rolls without slip follows, over the arc length x of the track,

    y'' + Δr(y) / (e r0) = 0                                                       (K1)

which has the first integral y'^2 / 2 = [U(m + ŷ) - U(y)] / (e r0), U(y) = ∫ Δr dy. Half of its wave is the way from one
outer position m - ŷ to the other, m + ŷ, at which U is the same; where both sides have the same profiles m is 0:

    λ(ŷ) = 2 sqrt(e r0) ∫_(m-ŷ)^(m+ŷ) dy / sqrt(2 [U(m + ŷ) - U(y)])                (K2)
    tan γ_e = 2 e r0 (π / λ)^2                                                     (K3)

On rollers Δr is the effective difference, which counts the rollers' radii as well, and x is the way of the surface. With
the wheel's radius growing by λ_w and the roller's falling by λ_r per shift that is λ_w / r0 + λ_r / R0 = λ_effective / r0. The
part of the rollers is what they add to the conicity of the same wheels at the same amplitude.

Units   SI. The conicity depends on neither e nor r0; the wavelength does.
Source  EN 15302:2021, clause 9 and annex E (direct integration of the nonlinear differential equation); EN 15302:2008,
        annex B; Klingel (1883) for (K3).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy.optimize import brentq

from rollerrig.results import variable

FloatArray = NDArray[np.float64]

POINTS = 2000
"""Points of the quadrature in (K2); the kink that a jump of the contact leaves in U costs 1e-6 of the conicity."""

CYLINDRICAL = 1e-7
"""Rolling radius differences up to this one count as none [m]: profile files print no more digits."""


def equivalent_conicity(lateral: FloatArray, difference: FloatArray, amplitudes: Sequence[float]) -> FloatArray:
    """Equivalent conicity tan γ_e over the amplitude of the kinematic motion.

    Args:
        lateral: lateral shifts, increasing, 0 among them [m]; only those from 0 on: the other side is their mirror image.
        difference: rolling radius difference, left less right, at these shifts [m]; straight lines between them.
        amplitudes: amplitudes ŷ, half of the distance between the outer positions [m].

    Returns:
        One value per amplitude [-]: 0 where the radii do not differ, NaN where nothing drives the wheelset
        back, or where the shifts given end too early.

    Raises:
        ValueError: an amplitude is not positive or beyond the shifts given.

    Example:
        >>> y = np.linspace(-8e-3, 8e-3, 161)
        >>> equivalent_conicity(y, 2 * 0.05 * y, [3e-3]).round(6).tolist()  # a cone 1:20
        [0.05]
    """
    y, dr = lateral, difference
    if not np.any(y == 0.0) or y[-1] <= 0.0:
        raise ValueError("lateral: the shift 0 and positive ones are needed")
    if y[0] == 0.0:
        y, dr = np.concatenate([-y[:0:-1], y]), np.concatenate([-dr[:0:-1], dr])
    for amplitude in amplitudes:
        if not 0 < amplitude <= y[-1] * (1 + 1e-12):
            raise ValueError(f"amplitude {1e3 * amplitude:g} mm; allowed above 0 and up to {1e3 * y[-1]:g} mm")
    areas, middle = 0.5 * (dr[1:] + dr[:-1]) * np.diff(y), int(np.flatnonzero(y == 0.0)[0])
    potential = np.concatenate((-np.cumsum(areas[:middle][::-1])[::-1], [0.0], np.cumsum(areas[middle:])))
    slope = np.diff(dr) / np.diff(y)

    def energy(at: FloatArray) -> FloatArray:
        """U(y) of the straight lines, exact [m^2]."""
        k = np.clip(np.searchsorted(y, at, side="right") - 1, 0, len(slope) - 1)
        t = at - y[k]
        return np.asarray(potential[k] + t * (dr[k] + 0.5 * slope[k] * t))

    # y = m + ŷ sin θ takes the roots at the turning points out of the integrand.
    theta = (np.arange(2 * POINTS) + 0.5) * (0.5 * math.pi / POINTS) - 0.5 * math.pi
    result = []
    for amplitude in amplitudes:
        at = _middle(energy, amplitude, float(y[0]), float(y[-1])) + amplitude * np.sin(theta)
        if np.max(np.abs(np.interp(at, y, dr))) < CYLINDRICAL:
            result.append(0.0)
            continue
        rest = energy(at[-1:] + amplitude * (1.0 - np.sin(theta[-1:]))) - energy(at)
        if not np.all(rest > 0.0):
            result.append(math.nan)
            continue
        half = np.sum(amplitude * np.cos(theta) / np.sqrt(2 * rest)) * (0.5 * math.pi / POINTS)
        result.append(2 * (math.pi / (2 * half)) ** 2)  # (K2) in (K3)
    return np.array(result)


def _middle(energy: Callable[[FloatArray], FloatArray], amplitude: float, low: float, high: float) -> float:
    """The middle m of a motion whose outer positions have the same potential [m]; NaN if they are not between low and high."""

    def surplus(middle: float) -> float:
        left, right = energy(np.array([middle - amplitude, middle + amplitude]))
        return float(right - left)

    first, last = low + amplitude, high - amplitude
    if abs(surplus(0.0)) <= 1e-9 * float(np.abs(energy(np.array([-amplitude, amplitude]))).max()):
        return 0.0
    return brentq(surplus, first, last, xtol=1e-12) if surplus(first) * surplus(last) < 0.0 else math.nan


def conicity_table(shifts: xr.Dataset, amplitudes: Sequence[float]) -> xr.Dataset:
    """Conicity and wavelength of the kinematic motion over its amplitude.

    Args:
        shifts: what `shift_table` returns.
        amplitudes: [m].

    Returns:
        Over `amplitude`: conicity [-], of_wheels and of_rollers [-], its parts from the radii of the wheels and of the
        rollers (0 on rails), and wavelength [m], infinite where the conicity is 0. The attribute nonlinearity_per_mm is the
        `nonlinearity_parameter`, NaN where it does not exist.
    """
    lateral, difference = shifts["lateral"].to_numpy(), shifts["effective_difference"].to_numpy()
    conicity = equivalent_conicity(lateral, difference, amplitudes)
    of_wheels = equivalent_conicity(lateral, shifts["rolling_radius_difference"].to_numpy(), amplitudes)
    product = shifts.attrs["contact_distance_m"] * shifts.attrs["wheel_radius_m"]
    with np.errstate(divide="ignore"):
        wavelength = math.pi * np.sqrt(2 * product / conicity)  # (K3)
    return xr.Dataset(
        {
            "conicity": variable("amplitude", conicity, "1", "equivalent conicity"),
            "of_wheels": variable("amplitude", of_wheels, "1", "conicity of the wheels' radii alone"),
            "of_rollers": variable(
                "amplitude", conicity - of_wheels, "1", "what the rollers' radii add to the conicity"
            ),
            "wavelength": variable("amplitude", wavelength, "m", "wavelength of the kinematic motion"),
        },
        coords={"amplitude": variable("amplitude", np.array(amplitudes), "m", "amplitude")},
        attrs={
            "title": shifts.attrs["title"],
            "support": shifts.attrs["support"],
            "nonlinearity_per_mm": nonlinearity_parameter(lateral, difference),
        },
    )


def nonlinearity_parameter(lateral: FloatArray, difference: FloatArray) -> float:
    """Change of the conicity from 2 to 4 mm of amplitude, per millimetre.

        N_P = [tan γ_e(4 mm) - tan γ_e(2 mm)] / 2 mm

    Negative where the conicity falls with the amplitude, which goes with a gradual onset of small limit cycles;
    positive with a sudden one of large ones.

    Args:
        lateral: as in `equivalent_conicity`.
        difference: as there.

    Returns:
        N_P [1/mm]; NaN if the shifts end before 4 mm.

    Source: O. Polach, Vehicle System Dynamics 48 Suppl. (2010) 19-36; EN 15302:2021, clause 9.
    """
    if lateral[-1] < 4e-3:
        return math.nan
    two, four = equivalent_conicity(lateral, difference, [2e-3, 4e-3])
    return float(four - two) / 2
