"""Generated rails have the spectrum they were asked for, and the same seed gives the same bytes."""

from __future__ import annotations

import hashlib

import numpy as np
import pytest
from scipy.signal import welch

from published_spectra import standard_deviation
from rollerrig.irregularity import COMPONENTS, RailIrregularity, generate, track_spectrum

WAVES = {"shortest": 3.0, "longest": 100.0}


def rails(seed: int = 1, period: float = 2000.0, **more: float) -> RailIrregularity:
    return generate("low", seed, period=period, fade_in=20.0, **{**WAVES, **more})


@pytest.mark.parametrize("component", COMPONENTS)
def test_the_variance_is_the_integral_of_the_spectrum(component: str) -> None:
    """The sum over the waves 20 to 666 is the midpoint rule for the integral from 19.5 to 666.5, good to (1 / 20)^2."""
    found = rails().root_mean_square()[component]
    exact = standard_deviation(component, "low", 2000.0 / 666.5, 2000.0 / 19.5)
    assert found == pytest.approx(exact, rel=1e-3)


@pytest.mark.parametrize("component", COMPONENTS)
def test_welch_finds_the_spectrum_again(component: str) -> None:
    """Averaged over octaves: 40 km in segments of 1 km have a standard deviation below 5 % per octave."""
    road = rails(period=40e3)
    step = 0.5
    samples = road.components(np.arange(0.0, road.period, step))[component]
    frequency, density = welch(samples, fs=2 * np.pi / step, nperseg=2000, noverlap=1000, window="hann")
    expected = track_spectrum(component, "low", np.maximum(frequency, 1e-9))
    for low in (0.08, 0.16, 0.32, 0.64):  # rad/m; waves of 79 to 5 m
        octave = (frequency > low) & (frequency < 2 * low)
        assert density[octave].mean() == pytest.approx(expected[octave].mean(), rel=0.15)


def test_components_have_nothing_to_do_with_each_other() -> None:
    """Correlation of independent components over 40 km: a few per cent."""
    samples = np.array(list(rails(period=40e3).components(np.arange(0, 40e3, 0.5)).values()))
    correlation = np.corrcoef(samples) - np.eye(4)
    assert np.abs(correlation).max() < 0.1


def test_the_spline_runs_through_the_waves() -> None:
    """Values and slopes between the knots against the sum itself; a single wave at the shortest length is the worst."""
    road = generate("low", 5, shortest=3.0, longest=3.1, period=30.0, fade_in=0.0)
    s = np.arange(777) * 30.0 / 777
    amplitude = np.sqrt(2 * track_spectrum("vertical", "low", 2 * np.pi / 3) * 2 * np.pi / 30)
    found = road.components(s)["vertical"]
    wave = np.exp(2j * np.pi * s / 3)
    phase = np.vdot(wave, found)
    np.testing.assert_allclose(found, amplitude * np.real(wave * phase / abs(phase)), atol=3e-4 * amplitude + 2e-9)


def test_it_repeats_smoothly_after_the_period() -> None:
    road = rails(period=500.0)
    for derivative in (0, 1):
        before, after = (road.evaluate("left_z", road.period + side, derivative) for side in (-1e-9, 1e-9))
        assert float(before) == pytest.approx(float(after), abs=1e-9)
    np.testing.assert_allclose(
        road.evaluate("left_y", [3.7, -96.3]), road.evaluate("left_y", [503.7, 403.7]), atol=1e-15
    )


def test_same_seed_same_bytes_other_seed_other_rails() -> None:
    first, again, other = rails(7), rails(7), rails(8)
    for rail, table in first.coefficients.items():
        assert table.tobytes() == again.coefficients[rail].tobytes()
        assert np.abs(table - other.coefficients[rail]).max() > 1e-4


def test_the_bytes_are_those_of_every_machine() -> None:
    """Written down on x86-64, NumPy 2; a change of these is a change of every user's track."""
    tables = rails(1, 300.0).coefficients
    digest = hashlib.sha256(b"".join(tables[rail].astype("<f8").tobytes() for rail in sorted(tables))).hexdigest()
    assert digest[:16] == "7497784203615662"


def test_a_scale_is_a_factor() -> None:
    full, scaled = rails().coefficients["left_y"], rails(scale=0.01).coefficients["left_y"]
    np.testing.assert_allclose(scaled, 0.01 * full, atol=1e-15 * np.abs(full).max())
