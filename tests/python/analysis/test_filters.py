"""Filters against their gain in closed form, the sliding mean against integrals."""

from __future__ import annotations

import math

import numpy as np
import pytest
import xarray as xr

from rollerrig.analysis.signals import band_pass, low_pass, narrow_band, sliding_mean

STEP = 2e-3
TIME = np.arange(0.0, 40.0, STEP)
MIDDLE = slice(5000, 15000)  # away from the ends, where the filter knows only one side


def sine(frequency: float) -> xr.DataArray:
    return xr.DataArray(np.sin(2 * np.pi * frequency * TIME), {"time": TIME}, "time")


def gain(filtered: xr.DataArray, frequency: float) -> float:
    """Amplitude in phase with the sine that came in; exact over whole periods."""
    wave = np.exp(-2j * np.pi * frequency * TIME[MIDDLE])
    found = 2j * np.mean(wave * filtered.to_numpy()[MIDDLE])
    assert found.imag == pytest.approx(0.0, abs=1e-6)  # no phase is shifted
    return float(found.real)


@pytest.mark.parametrize("cutoff", [10.0, 20.0])
def test_three_decibels_are_lost_at_the_cutoff(cutoff: float) -> None:
    assert gain(low_pass(sine(cutoff), cutoff), cutoff) == pytest.approx(math.sqrt(0.5), abs=1e-6)


@pytest.mark.parametrize(("low", "high"), [(7.0, 11.0), (2.0, 6.0), (0.4, 3.5)])
def test_a_narrow_band_keeps_its_middle_and_loses_three_decibels_at_its_ends(low: float, high: float) -> None:
    middle = math.sqrt(low * high)
    assert gain(narrow_band(sine(round(middle, 1)), low, high), round(middle, 1)) == pytest.approx(1.0, abs=1e-3)
    for end in (low, high):  # frequencies are warped by 1e-3 at 500 samples a second
        assert gain(narrow_band(sine(end), low, high), end) == pytest.approx(math.sqrt(0.5), abs=2e-3)


@pytest.mark.parametrize("frequency", [1.0, 10.0, 40.0, 80.0])
def test_low_pass_has_fourth_order(frequency: float) -> None:
    ratio = math.tan(math.pi * frequency * STEP) / math.tan(math.pi * 20.0 * STEP)
    exact = 1 / (1 + (math.sqrt(2) - 1) * ratio**4)  # 24 dB per octave far above
    assert gain(low_pass(sine(frequency), 20.0), frequency) == pytest.approx(exact, abs=1e-6)


@pytest.mark.parametrize("frequency", [0.1, 0.4, 2.0, 10.0, 25.0])
def test_band_pass_is_both_flanks(frequency: float) -> None:
    up = math.tan(math.pi * frequency * STEP) / math.tan(math.pi * 10.0 * STEP)
    down = math.tan(math.pi * 0.4 * STEP) / math.tan(math.pi * frequency * STEP)
    exact = 1 / (1 + (math.sqrt(2) - 1) * up**4) / (1 + (math.sqrt(2) - 1) * down**4)
    # A slow flank rings for seconds: 10 s from the ends 1e-5 of a constant is left.
    assert gain(band_pass(sine(frequency), 0.4, 10.0), frequency) == pytest.approx(exact, abs=2e-5)


def test_a_constant_passes_low_pass_and_is_stopped_by_band_pass() -> None:
    constant = xr.DataArray(np.full((2, len(TIME)), 3.0), {"time": TIME}, ["wheel", "time"])
    assert np.abs(low_pass(constant, 20.0) - 3.0).max() < 1e-9
    assert np.abs(band_pass(constant, 0.4, 10.0)).max() < 1e-6


def test_a_vibration_at_the_ends_is_not_taken_for_the_level_beyond_them() -> None:
    """1 and a vibration of ten times that at 200 Hz, which stands at its peak at both ends."""
    time = np.arange(0.0, 2.0 + 1e-9, 1e-3)
    shaken = xr.DataArray(1.0 + 10.0 * np.cos(2 * np.pi * 200.0 * time), {"time": time}, "time")
    # 200 Hz pass with 1e-4 of their amplitude; what the kink of the continuation adds at the end is of the order of a percent.
    assert np.abs(low_pass(shaken, 20.0) - 1.0).max() < 0.5


@pytest.mark.parametrize(
    ("time", "message"),
    [
        (np.arange(0.0, 4.0, 0.01), "needs an output_step of at most 5 ms; this run has 10 ms"),
        (np.arange(0.0, 0.04, 0.002), "needs a run of at least 0.05 s"),
        (np.zeros(0), "needs a run of at least 0.05 s"),
        (np.cumsum(np.where(np.arange(100) % 2, 1e-3, 2e-3)), "not evenly spaced"),
    ],
)
def test_what_cannot_be_filtered_is_refused(time: np.ndarray, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        low_pass(xr.DataArray(np.zeros_like(time), {"time": time}, "time"), 20.0)


def test_five_milliseconds_are_fine_enough_for_twenty_hertz() -> None:
    time = np.linspace(0.0, 2.0, 401)  # not exact multiples of 5 ms
    low_pass(xr.DataArray(time, {"time": time}, "time"), 20.0)


def over_way(values: np.ndarray, way: np.ndarray) -> tuple[xr.DataArray, xr.DataArray]:
    time = np.arange(len(way), dtype=float)
    return xr.DataArray(values, {"time": time}, "time"), xr.DataArray(way, {"time": time}, "time")


def test_the_mean_of_a_straight_line_is_its_middle_whatever_the_speed() -> None:
    way = np.cumsum(np.linspace(0.01, 0.4, 60))
    signal, distance = over_way(3.0 * way - 1.0, way)
    mean = sliding_mean(signal, distance)
    inside = (way >= way[0] + 1.0) & (way <= way[-1] - 1.0)
    assert mean.to_numpy()[inside] == pytest.approx(signal.to_numpy()[inside], abs=1e-12)
    assert np.isnan(mean.to_numpy()[~inside]).all()


def test_a_wave_shrinks_as_its_integral_says() -> None:
    way = np.arange(0.0, 30.0, 0.005)
    signal, distance = over_way(np.sin(2 * np.pi * way / 5.0), way)
    share = math.sin(2 * math.pi / 5.0) / (2 * math.pi / 5.0)
    inside = slice(300, -300)
    # Straight lines between samples: 0.005^2/8 of the second derivative.
    assert sliding_mean(signal, distance).to_numpy()[inside] == pytest.approx(
        share * signal.to_numpy()[inside], abs=1e-5
    )


def test_a_gap_makes_a_gap_as_wide_as_the_window() -> None:
    way = np.arange(0.0, 10.0, 0.1)
    values = np.ones_like(way)
    values[50] = np.nan
    mean = sliding_mean(*over_way(values, way)).to_numpy()
    # The sample's straight lines to its neighbours are missing as well.
    assert np.isnan(mean[40:61]).all()
    assert mean[[15, 38, 62, 85]] == pytest.approx(1.0)


def test_standing_still_keeps_the_mean() -> None:
    way = np.concatenate([np.arange(0.0, 5.0, 0.1), np.full(30, 5.0), np.arange(5.1, 10.0, 0.1)])
    mean = sliding_mean(*over_way(way, way)).to_numpy()
    assert mean[50:80] == pytest.approx(5.0)
    with pytest.raises(ValueError, match="backwards"):
        sliding_mean(*over_way(way, -way))
