"""Rails with a published spectrum: a sum of waves with fixed amplitudes and drawn phases.

    component(s) = sum_k sqrt(2 S(Omega_k) d_Omega) cos(Omega_k s + phi_k),   Omega_k = k d_Omega,  d_Omega = 2 pi / period

The sum repeats after the period. The variance is that of the spectrum between the two wavelengths, whatever the seed; the
phases come from the raw numbers of PCG64, one stream per component. The spline runs through the sum exactly at its knots.
Its weights are rounded to a nanometre: the same seed gives the same bytes whatever sine and transform a machine has.
"""

from __future__ import annotations

import numpy as np

from rollerrig.irregularity.rails import (
    COMPONENTS,
    RAILS,
    Component,
    FloatArray,
    RailIrregularity,
    periodic_spline,
    rails_of,
)
from rollerrig.irregularity.spectra import Level, track_spectrum

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
) -> FloatArray:
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


def _phases(component: Component, seed: int, count: int) -> FloatArray:
    """Uniform in [0, 2 pi), from the upper 53 bits of the generator's raw numbers."""
    bits = np.random.PCG64(np.random.SeedSequence([seed, COMPONENTS.index(component)]))
    raw = np.atleast_1d(bits.random_raw(count)).astype(np.uint64)
    return np.asarray(2 * np.pi * (raw >> np.uint64(11)).astype(np.float64) * 2.0**-53)
