"""Growth rate, amplitude and frequency of signals that are known exactly."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rollerrig.analysis.signals import final_motion, half_waves

TIME = np.linspace(0.0, 6.0, 1201)


def spiral(rate: float, frequency: float = 2.5, amplitude: float = 1e-3) -> np.ndarray:
    return amplitude * np.exp(rate * TIME) * np.sin(2 * np.pi * frequency * TIME)


def growth_rate(signal: np.ndarray, least_amplitude: float = 1e-6) -> float:
    waves = half_waves(TIME, signal, least_amplitude)
    return float(np.polyfit(waves.time, np.log(waves.amplitude), 1)[0])


@pytest.mark.parametrize("rate", [-1.2, -0.3, 0.0, 0.4, 1.5])
def test_growth_rate_of_a_spiral(rate: float) -> None:
    # extrema of a spline through 80 points per wave: their error is of fourth order
    assert growth_rate(spiral(rate)) == pytest.approx(rate, abs=1e-4)


@settings(max_examples=25, deadline=None)
@given(
    rate=st.floats(-1.0, 1.0), frequency=st.floats(1.0, 8.0), offset=st.floats(-1e-2, 1e-2), scale=st.floats(1e-2, 1e2)
)
def test_growth_rate_knows_no_offset_and_no_scale(rate: float, frequency: float, offset: float, scale: float) -> None:
    y = offset + scale * spiral(rate, frequency)
    assert growth_rate(y, least_amplitude=1e-9) == pytest.approx(rate, abs=2e-3)


def test_frequency_and_amplitude_of_a_steady_wave() -> None:
    found = final_motion(TIME, spiral(0.0))
    assert found.frequency == pytest.approx(2.5, rel=1e-5)
    assert found.amplitude == pytest.approx(1e-3, rel=1e-5)


def test_a_dying_signal_leaves_nothing() -> None:
    found = final_motion(TIME, spiral(-8.0))
    assert found.amplitude == 0.0
    assert np.isnan(found.frequency)


def test_rest_and_short_signals_do_not_trouble() -> None:
    assert final_motion(TIME, np.zeros_like(TIME)).amplitude == 0.0
    assert len(half_waves(TIME[:3], TIME[:3]).time) == 0
    assert len(half_waves(TIME, TIME).time) == 0


def test_ripples_below_the_threshold_do_not_split_waves() -> None:
    clean = spiral(0.0)
    rippled = clean + 1e-7 * np.sin(2 * np.pi * 60 * TIME)
    found = half_waves(TIME, rippled, least_amplitude=1e-6)
    assert len(found.time) == len(half_waves(TIME, clean).time)
    assert np.median(found.amplitude) == pytest.approx(1e-3, rel=1e-3)
