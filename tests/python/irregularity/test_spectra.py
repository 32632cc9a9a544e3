"""The published spectra: values, shape, variance."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest

from published_spectra import standard_deviation
from rollerrig.irregularity import COMPONENTS, track_spectrum

OMEGA = np.geomspace(1e-3, 20.0, 400)


@pytest.mark.parametrize("component", ["alignment", "vertical"])
def test_levels_of_the_rails_mean_fall_with_the_wavenumber(component: str) -> None:
    for level in ("low", "high"):
        assert np.all(np.diff(track_spectrum(component, level, OMEGA)) < 0)


@pytest.mark.parametrize("component", ["cross_level", "gauge"])
def test_rails_follow_each_other_on_long_waves(component: str) -> None:
    """From 0 the density rises to one maximum near sqrt(Or Os) and falls: the two rails bend alike on long waves."""
    density = track_spectrum(component, "low", OMEGA)
    assert density[0] < 0.01 * density.max()
    rises = np.diff(density) > 0
    assert np.count_nonzero(np.diff(rises.astype(int))) == 1
    assert 0.05 < OMEGA[density.argmax()] < 0.2


@pytest.mark.parametrize("component", COMPONENTS)
def test_the_high_level_is_the_higher_one(component: str) -> None:
    assert np.all(track_spectrum(component, "high", OMEGA) > 1.5 * track_spectrum(component, "low", OMEGA))


def test_the_published_values() -> None:
    """By hand at Omega = 1: 2.119e-7 * 0.67996 / (1.00042436 * 1.67996516) and the cross level 4 A_v ... / (1 + 0.438^2)."""
    assert float(track_spectrum("alignment", "low", 1.0)) == pytest.approx(8.573e-8, rel=1e-3)
    assert float(track_spectrum("vertical", "high", 1.0)) == pytest.approx(8.573e-8 * 1.080e-6 / 2.119e-7, rel=1e-3)
    ratio = track_spectrum("cross_level", "low", 1.0) / track_spectrum("vertical", "low", 1.0)
    assert float(ratio) == pytest.approx(4 / (1 + 0.4380**2), rel=1e-12)


def test_on_short_waves_the_rails_are_independent() -> None:
    """Heights z + d/2 and z - d/2 have no correlation where the density of d is four times that of z."""
    ratio = track_spectrum("cross_level", "low", 50.0) / track_spectrum("vertical", "low", 50.0)
    assert float(ratio) == pytest.approx(4.0, rel=1e-4)


def test_the_variance_is_the_closed_form() -> None:
    """Over all waves A Oc^2 pi / (2 Or Oc (Or + Oc)); 1e-6 of it lies beyond these limits."""
    exact = 4.032e-7 * 0.8246 * math.pi / (2 * 0.0206 * (0.0206 + 0.8246))
    assert standard_deviation("vertical", "low", 1e-3, 1e9) ** 2 == pytest.approx(exact, rel=1e-5)


def test_variances_of_bands_add_up() -> None:
    bands = [3.0, 25.0, 70.0, 150.0]
    parts = sum(standard_deviation("gauge", "low", a, b) ** 2 for a, b in itertools.pairwise(bands))
    assert standard_deviation("gauge", "low", 3.0, 150.0) ** 2 == pytest.approx(parts, rel=1e-8)
