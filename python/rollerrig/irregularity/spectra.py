"""The published spectra of track irregularities: power spectral densities over the angular wavenumber.

One-sided densities over Omega = 2 pi / wavelength [rad/m]: the variance is the integral over Omega > 0 [m^2].

Source: ORE question B 176, report RP 1 (1989), low and high level, for alignment, longitudinal level and cross level. The
gauge is not part of it: its spectrum and levels are those customarily tabulated beside the other three (e.g. W. Zhai,
Vehicle-Track Coupled Dynamics, 2020, "German spectra"). Conventions: docs/theory/irregularities.md.
"""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from rollerrig.irregularity.rails import Component, FloatArray

Level = Literal["low", "high"]

OMEGA_C = 0.8246
"""Beyond this the spectra fall with the fourth power [rad/m]."""
OMEGA_R = 0.0206
"""Below this they are flat [rad/m]."""
OMEGA_S = 0.4380
"""Below this cross level and gauge lose power: the two rails follow each other on long waves [rad/m]."""
HALF_BASE = 0.75
"""Half of the distance of the rails, b of the cross level's spectrum [m]."""

LEVELS: dict[Level, dict[str, float]] = {
    "low": {"alignment": 2.119e-7, "vertical": 4.032e-7, "gauge": 5.32e-8},
    "high": {"alignment": 6.124e-7, "vertical": 1.080e-6, "gauge": 1.032e-7},
}
"""The factors A of the spectra [rad m]."""


def track_spectrum(component: Component, level: Level, omega: ArrayLike) -> FloatArray:
    """One-sided power spectral density of one component.

    Args:
        component: alignment and vertical: mean of the two rails; cross_level: height of the right rail over the left one;
            gauge: its widening.
        level: of the irregularities.
        omega: angular wavenumber [rad/m], any shape, positive.

    Returns:
        Density [m^2/(rad/m)], of the shape of `omega`.
    """
    omega2 = np.square(np.asarray(omega, dtype=np.float64))
    mean_of_rails = OMEGA_C**2 / ((omega2 + OMEGA_R**2) * (omega2 + OMEGA_C**2))
    between_rails = mean_of_rails * omega2 / (omega2 + OMEGA_S**2)
    factors = LEVELS[level]
    match component:
        case "alignment" | "vertical":
            return np.asarray(factors[component] * mean_of_rails)
        case (
            "cross_level"
        ):  # published as that of the angle, A / b^2 times the shape; a height over 2 b is (2 b)^2 of it
            return np.asarray((2 * HALF_BASE) ** 2 * factors["vertical"] / HALF_BASE**2 * between_rails)
        case "gauge":
            return np.asarray(factors["gauge"] * between_rails)


def standard_deviation(component: Component, level: Level, shortest: float, longest: float) -> float:
    """Standard deviation of the waves between two wavelengths [m]; both wavelengths in m."""
    from scipy.integrate import quad

    low, high = 2 * np.pi / longest, 2 * np.pi / shortest
    variance, _ = quad(
        lambda x: np.exp(x) * track_spectrum(component, level, np.exp(x)), np.log(low), np.log(high), epsrel=1e-10
    )
    return float(np.sqrt(variance))
