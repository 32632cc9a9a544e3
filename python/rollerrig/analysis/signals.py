"""What an oscillation does: grows or decays, how large, how fast.

    time series -> [extrema] -> half-wave amplitudes over time -> rate, amplitude, frequency

Amplitudes are half the distance between successive extrema: no offset enters, and for y = e^(σt) sin(ωt) they are exactly
exponential.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import xarray as xr
from numpy.typing import NDArray

Series = NDArray[np.float64]

LEAST_AMPLITUDE = 1e-6
"""Smaller half-waves are no motion but remains of the integration's error [m]."""


@dataclass(frozen=True)
class HalfWaves:
    """Successive half-waves of a signal.

    Attributes:
        time: middle of each half-wave [s].
        amplitude: half the distance of its two extrema [unit of the signal].
        duration: time between its two extrema [s].
    """

    time: Series
    amplitude: Series
    duration: Series


def half_waves(time: Series, signal: Series, least_amplitude: float = LEAST_AMPLITUDE) -> HalfWaves:
    """Half-waves of a signal, by the extrema of its cubic spline.

    Args:
        time: rising times [s].
        signal: values, shape of `time`.
        least_amplitude: smaller ripples are left out, and the two half-waves beside each are joined.
    """
    from scipy.interpolate import CubicSpline  # slow to load, and seldom needed

    if len(time) < 4:
        return HalfWaves(*(np.zeros(0),) * 3)
    spline = CubicSpline(time, signal)
    at = np.sort(spline.derivative().roots(discontinuity=False, extrapolate=False))
    value = np.asarray(spline(at))
    keep: list[int] = []
    for k in range(len(at)):
        if len(keep) >= 2 and (value[keep[-1]] - value[keep[-2]]) * (value[k] - value[keep[-1]]) >= 0:
            if abs(value[k] - value[keep[-2]]) >= abs(value[keep[-1]] - value[keep[-2]]):
                keep[-1] = k  # same direction as before
        elif not keep or abs(value[k] - value[keep[-1]]) >= 2 * least_amplitude:
            keep.append(k)
        elif len(keep) == 1:
            keep[0] = k
    t, y = at[keep], value[keep]
    return HalfWaves(0.5 * (t[1:] + t[:-1]), 0.5 * np.abs(np.diff(y)), np.diff(t))


def growth_rate(signal: xr.DataArray, least_amplitude: float = LEAST_AMPLITUDE) -> float:
    """Exponential growth rate of an oscillation [1/s], negative if it decays.

    The slope of the logarithm of the half-wave amplitudes, by least squares.

    Args:
        signal: oscillation with the coordinate `time` [s].
        least_amplitude: half-waves below it are left out [unit of the signal].

    Returns:
        The rate; NaN with fewer than three half-waves.
    """
    waves = half_waves(signal["time"].to_numpy(), signal.to_numpy(), least_amplitude)
    if len(waves.time) < 3:
        return float("nan")
    return float(np.polyfit(waves.time - waves.time.mean(), np.log(waves.amplitude), 1)[0])


@dataclass(frozen=True)
class FinalMotion:
    """What is left at the end of a run.

    Attributes:
        amplitude: half the range of the signal in the last part of the run [unit of the signal]; 0 if it decayed.
        frequency: of that oscillation [Hz]; NaN if it decayed.
        rate: its growth rate [1/s]; NaN if it decayed.
    """

    amplitude: float
    frequency: float
    rate: float


RIPPLE = 0.25
"""Half-waves smaller than this part of the amplitude are ripples on larger waves: they count for no frequency [1]."""


def final_motion(
    time: Series, signal: Series, part: float = 1 / 3, least_amplitude: float = LEAST_AMPLITUDE
) -> FinalMotion:
    """Amplitude, frequency and growth rate in the last part of a run.

    The rate compares the ranges of the two halves of that part: it is exact for an exponential, and an irregular limit
    cycle, whose half-waves differ, gives nearly zero.

    Args:
        time: rising times [s].
        signal: values, shape of `time`.
        part: how much of the run counts as its end.
        least_amplitude: half-waves below it are no motion.
    """
    start = time[-1] - part * (time[-1] - time[0])
    last = time >= start
    t, y = time[last], signal[last]
    amplitude = 0.5 * float(np.ptp(y)) if len(y) else 0.0
    waves = half_waves(t, y, max(least_amplitude, RIPPLE * amplitude))
    if amplitude < least_amplitude or len(waves.time) < 2:
        return FinalMotion(0.0, float("nan"), float("nan"))
    early, late = (0.5 * float(np.ptp(half)) for half in np.array_split(y, 2))
    rate = float(np.log(late / early)) / (0.5 * float(t[-1] - t[0])) if late > 0 < early else float("-inf")
    return FinalMotion(amplitude, 0.5 * len(waves.duration) / float(waves.duration.sum()), rate)
