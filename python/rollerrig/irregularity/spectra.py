"""Rails with a published spectrum: power spectral densities, and a sum of waves with fixed amplitudes and drawn phases.

One-sided densities over Omega = 2 pi / wavelength [rad/m]: the variance is the integral over Omega > 0 [m^2].

Source: ORE question B 176, report RP 1 (1989), low and high level, for alignment, longitudinal level and cross level. The
gauge is not part of it: its spectrum and levels are those customarily tabulated beside the other three (e.g. W. Zhai,
Vehicle-Track Coupled Dynamics, 2020, "German spectra"). Conventions: docs/theory/irregularities.md.

    component(s) = sum_k sqrt(2 S(Omega_k) d_Omega) cos(Omega_k s + phi_k),   Omega_k = k d_Omega,  d_Omega = 2 pi / period

The sum repeats after the period. The variance is that of the spectrum between the two wavelengths, whatever the seed; the
phases come from the raw numbers of PCG64, one stream per component. The spline runs through the sum exactly at its knots.
Its weights are rounded to a nanometre: the same seed gives the same bytes whatever sine and transform a machine has.
"""

from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from rollerrig.common.arrays import Array
from rollerrig.irregularity.rails import COMPONENTS, RAILS, Component, RailIrregularity, periodic_spline, rails_of

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


def track_spectrum(component: Component, level: Level, omega: ArrayLike) -> Array:
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
        case "cross_level":
            # published as that of the angle, A / b^2 times the shape; a height over 2 b is (2 b)^2 of it
            return np.asarray((2 * HALF_BASE) ** 2 * factors["vertical"] / HALF_BASE**2 * between_rails)
        case "gauge":
            return np.asarray(factors["gauge"] * between_rails)


KNOTS_PER_WAVE = 12
"""Knots of the spline on the shortest wave: its amplitude between knots is right to 1e-4."""

ROUNDING = 1e-9  # [m]


def generate(
    level: Level, seed: int, *, shortest: float, longest: float, period: float, fade_in: float, scale: float = 1.0
) -> RailIrregularity:
    """Rails of a published spectrum.

    Args:
        level: of the spectra.
        seed: another seed, other phases.
        shortest: shortest wavelength [m].
        longest: longest wavelength [m].
        period: distance after which the rails repeat [m].
        fade_in: see RailIrregularity [m].
        scale: factor on all displacements.
    """
    count = int(np.ceil(period / shortest * KNOTS_PER_WAVE - 1e-9))
    step = period / count
    weights = {name: _weights(name, level, seed, (shortest, longest), period, count) for name in COMPONENTS}
    rails = rails_of(weights)
    return RailIrregularity(step, {rail: periodic_spline(scale * rails[rail], step) for rail in RAILS}, fade_in)


def _weights(
    component: Component, level: Level, seed: int, wavelengths: tuple[float, float], period: float, count: int
) -> Array:
    """B-spline weights of one component, (count,) [m]."""
    shortest, longest = wavelengths
    first, last = int(np.ceil(period / longest - 1e-9)), int(np.floor(period / shortest + 1e-9))
    k = np.arange(first, last + 1)
    spacing = 2 * np.pi / period
    amplitude = np.sqrt(2 * track_spectrum(component, level, k * spacing) * spacing)
    amplitude *= 6 / (4 + 2 * np.cos(2 * np.pi * k / count))  # what a spline's knots show of its weights, inverted
    waves = np.zeros(count // 2 + 1, dtype=np.complex128)
    waves[k] = amplitude * count / 2 * np.exp(1j * _phases(component, seed, last + 1)[k])
    return np.asarray(np.round(np.fft.irfft(waves, count) / ROUNDING) * ROUNDING)


def _phases(component: Component, seed: int, count: int) -> Array:
    """Uniform in [0, 2 pi), from the upper 53 bits of the generator's raw numbers."""
    bits = np.random.PCG64(np.random.SeedSequence([seed, COMPONENTS.index(component)]))
    raw = np.atleast_1d(bits.random_raw(count)).astype(np.uint64)
    return np.asarray(2 * np.pi * (raw >> np.uint64(11)).astype(np.float64) * 2.0**-53)
