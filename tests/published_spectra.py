"""The variance of a published spectrum, by quadrature."""

import numpy as np
from scipy.integrate import quad

from rollerrig.irregularity import track_spectrum
from rollerrig.irregularity.rails import Component
from rollerrig.irregularity.spectra import Level


def standard_deviation(component: Component, level: Level, shortest: float, longest: float) -> float:
    """Standard deviation of the waves between two wavelengths [m]; both wavelengths in m."""
    low, high = 2 * np.pi / longest, 2 * np.pi / shortest
    variance, _ = quad(
        lambda x: np.exp(x) * track_spectrum(component, level, np.exp(x)), np.log(low), np.log(high), epsrel=1e-10
    )
    return float(np.sqrt(variance))
