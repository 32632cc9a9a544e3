"""Signals of a run: filters that shift no phase, and what an oscillation does: grows or decays, how large, how fast.

    signal over time -> [Butterworth, forward and backward] -> signal within a band
                     -> [mean over the 2 m around it]       -> what the rail feels
                     -> [extrema] -> half-wave amplitudes   -> rate, amplitude, frequency

A second-order Butterworth filter run forward and backward is in all of fourth order: 24 dB per octave, as EN 14363 asks.
Its corner is moved so that the two runs together have -3 dB where the cut-off is said to be:

    |H|^2 of one run = 1 / (1 + x^4),  x = tan(π f / f_s) / tan(π f_1 / f_s)
    both runs at the cut-off f_c: 1 / (1 + x_c^4) = 1 / sqrt(2)   =>   tan(π f_1 / f_s) = tan(π f_c / f_s) / (sqrt(2) - 1)^(1/4)

A high pass has x upside down.

Source: EN 14363:2016, table of assessed quantities and their filters; K. Steiglitz et al. on filtering twice.

Amplitudes are half the distance between successive extrema: no offset enters, and for y = e^(σt) sin(ωt) they are exactly
exponential.
"""

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np
import xarray as xr

from rollerrig.common.arrays import Array
from rollerrig.common.linear_algebra import one_blas_thread

SAMPLES_PER_PERIOD = 10
"""Least samples in a period of the cut-off: what the output step folds down from above must be small there."""

SLIDING_LENGTH = 2.0
"""Length of the sliding mean over distance [m]: EN 14363, for the sum of guiding forces and Y/Q."""

_EVEN = 1e-6
"""Steps of time may differ by this part: output times are multiples of the output step, to round-off."""

_RUNS_SHIFT = (math.sqrt(2.0) - 1.0) ** 0.25
"""Factor by which the corner of one run moves so that two runs have -3 dB at the cut-off."""


def low_pass(signal: xr.DataArray, cutoff: float) -> xr.DataArray:
    """The signal without what is faster than the cut-off.

    Args:
        signal: values with the dimension `time`, even steps [s]; other dimensions are filtered each on its own.
        cutoff: frequency at which -3 dB are left [Hz].

    Returns:
        The same dimensions, coordinates and attributes.

    Raises:
        ValueError: the steps are uneven, too coarse for the cut-off, or too few.
    """
    return _filtered(signal, cutoff, "lowpass")


def band_pass(signal: xr.DataArray, low: float, high: float) -> xr.DataArray:
    """The signal between two frequencies, each at -3 dB [Hz]; the rest as in `low_pass`."""
    return _filtered(_filtered(signal, high, "lowpass"), low, "highpass")


def narrow_band(signal: xr.DataArray, low: float, high: float) -> xr.DataArray:
    """The signal in a band that may be narrow: unchanged at its middle, -3 dB at its ends [Hz]; the rest as in `low_pass`.

    A low and a high pass one after the other, as in `band_pass`, would take from the middle, too.
    """
    from scipy.signal import butter

    rate = sampling_rate(signal["time"].to_numpy(), high)
    half = 0.5 * (high - low) / _RUNS_SHIFT  # of one run, about the same geometric mean
    upper = half + math.sqrt(half * half + low * high)
    sections = butter(2, (upper - 2.0 * half, upper), "bandpass", fs=rate, output="sos")
    return _both_ways(signal, sections, math.ceil(3 * rate / low))


def _filtered(signal: xr.DataArray, cutoff: float, kind: Literal["lowpass", "highpass"]) -> xr.DataArray:
    from scipy.signal import butter  # takes a second to load, and most commands filter nothing

    rate = sampling_rate(signal["time"].to_numpy(), cutoff)
    warped = math.tan(math.pi * cutoff / rate)
    corner = math.atan(warped / _RUNS_SHIFT if kind == "lowpass" else warped * _RUNS_SHIFT) * rate / math.pi
    sections = butter(2, corner, kind, fs=rate, output="sos")
    return _both_ways(signal, sections, math.ceil(3 * rate / cutoff))


def _both_ways(signal: xr.DataArray, sections: Array, mirrored: int) -> xr.DataArray:
    """Forward and backward through a filter, with so many samples mirrored beyond both ends."""
    from scipy.signal import sosfiltfilt

    axis, beyond = signal.get_axis_num("time"), min(signal.sizes["time"] - 1, mirrored)
    # Even: an odd continuation would take the last value, vibration and all, for the level beyond the end.
    return signal.copy(data=sosfiltfilt(sections, signal.to_numpy(), axis=axis, padlen=beyond, padtype="even"))


def away_from_ends(filtered: xr.DataArray, cutoff: float) -> xr.DataArray:
    """A filtered signal without what depends on how the run goes on: NaN within a period of the cut-off [Hz] of both ends.

    There what is mirrored beyond the end has a part: of the guiding force of a hunting wheel up to a tenth, further in 0.2 %.

    Raises:
        ValueError: nothing is left.
    """
    time = filtered["time"].to_numpy()
    inside = (time >= time[0] + 1.0 / cutoff) & (time <= time[-1] - 1.0 / cutoff)
    if not inside.any():
        needed = f"a filter at {cutoff:g} Hz needs a run of at least {2 / cutoff:g} s"
        raise ValueError(f"{needed}; this has {float(np.ptp(time)):.3g} s")
    return filtered.where(xr.DataArray(inside, dims="time"))


def sampling_rate(time: Array, cutoff: float) -> float:
    """Samples per second, if they can carry a filter of this cut-off.

    Args:
        time: output times [s].
        cutoff: [Hz].

    Raises:
        ValueError: the steps are uneven, too coarse, or the whole is shorter than a period of the cut-off.
    """
    duration = float(time[-1] - time[0]) if len(time) else 0.0
    if duration * cutoff < 1.0:
        raise ValueError(
            f"a filter at {cutoff:g} Hz needs a run of at least {1 / cutoff:g} s; this has {duration:.3g} s"
        )
    step = duration / (len(time) - 1)
    if np.abs(np.diff(time) - step).max() > _EVEN * step:
        raise ValueError("the output times are not evenly spaced; a filter needs one output_step")
    if step * cutoff * SAMPLES_PER_PERIOD > 1.0 + _EVEN:
        finest = 1e3 / (SAMPLES_PER_PERIOD * cutoff)
        raise ValueError(
            f"a filter at {cutoff:g} Hz needs an output_step of at most {finest:g} ms; this run has {1e3 * step:g} ms"
        )
    return 1.0 / step


def sliding_mean(signal: xr.DataArray, distance: xr.DataArray, length: float = SLIDING_LENGTH) -> xr.DataArray:
    """Mean of a signal over a distance centred at each sample.

        mean(s) = 1/L ∫ f ds  from s - L/2 to s + L/2,  f straight between samples

    Args:
        signal: values with the dimension `time`.
        distance: at each time [m], never falling.
        length: L [m].

    Returns:
        The same shape; NaN where the window reaches beyond the run or over a NaN.

    Raises:
        ValueError: the run went backwards.
    """
    s = distance.to_numpy()
    if np.any(np.diff(s) < 0.0):
        raise ValueError("a mean over distance needs a run that never goes backwards")
    values = np.moveaxis(signal.to_numpy(), signal.get_axis_num("time"), 0)
    missing = np.isnan(values)
    inside = (s - 0.5 * length >= s[:1] - 1e-9) & (s + 0.5 * length <= s[-1:] + 1e-9)
    mean = np.full(values.shape, np.nan)
    for column in np.ndindex(*values.shape[1:]):
        at = (slice(None), *column)
        mean[at] = _over_window(np.where(missing[at], 0.0, values[at]), s, length)
        mean[at][_over_window(missing[at].astype(float), s, length) > 1e-12] = np.nan
    mean[~inside] = np.nan
    return signal.copy(data=np.moveaxis(mean, 0, signal.get_axis_num("time")))


def _over_window(f: Array, s: Array, length: float) -> Array:
    """Mean of f over s - length/2 to s + length/2, exact for straight lines between samples."""
    interval = np.diff(s)
    total = np.concatenate(([0.0], np.cumsum(0.5 * (f[1:] + f[:-1]) * interval)))

    def integral(at: Array) -> Array:
        k = np.clip(np.searchsorted(s, at, side="right") - 1, 0, len(s) - 2)
        part = np.clip(at - s[k], 0.0, interval[k])
        slope = np.divide(f[k + 1] - f[k], interval[k], out=np.zeros_like(part), where=interval[k] > 0.0)
        return np.asarray(total[k] + part * (f[k] + 0.5 * slope * part))

    return (integral(s + 0.5 * length) - integral(s - 0.5 * length)) / length


@dataclass(frozen=True)
class Fit:
    """A linear least-squares fit."""

    coefficients: tuple[float, ...]  # one per column
    largest: float  # largest of what is left, over the largest value [1]


@one_blas_thread()
def fit(values: Array, *columns: Array) -> Fit:
    """Fit values by a sum of columns, all of shape (n,)."""
    matrix = np.stack(columns, axis=1)
    solution = np.linalg.lstsq(matrix, values, rcond=None)[0]
    left = values - matrix @ solution
    scale = float(np.abs(values).max()) or 1.0
    return Fit(tuple(float(c) for c in solution), float(np.abs(left).max()) / scale)


LEAST_AMPLITUDE = 1e-6
"""Smaller half-waves are no motion but remains of the integration's error [m]."""


@dataclass(frozen=True)
class HalfWaves:
    """Successive half-waves of a signal."""

    time: Array  # middle of each half-wave [s]
    amplitude: Array  # half the distance of its two extrema [unit of the signal]
    duration: Array  # time between its two extrema [s]


def half_waves(time: Array, signal: Array, least_amplitude: float = LEAST_AMPLITUDE) -> HalfWaves:
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


@dataclass(frozen=True)
class FinalMotion:
    """What is left at the end of a run."""

    amplitude: float  # half the range of the signal in the last part of the run [unit of the signal]; 0 if it decayed
    frequency: float  # of that oscillation [Hz]; NaN if it decayed
    rate: float  # its growth rate [1/s]; NaN if it decayed


RIPPLE = 0.25
"""Half-waves smaller than this part of the amplitude are ripples on larger waves: they count for no frequency [1]."""


def final_motion(time: Array, signal: Array, part: float = 1 / 3) -> FinalMotion:
    """Amplitude, frequency and growth rate in the last part of a run.

    The rate compares the ranges of the two halves of that part: it is exact for an exponential, and an irregular limit
    cycle, whose half-waves differ, gives nearly zero.

    Args:
        time: rising times [s].
        signal: values, shape of `time`.
        part: how much of the run counts as its end.
    """
    start = time[-1] - part * (time[-1] - time[0])
    last = time >= start
    t, y = time[last], signal[last]
    amplitude = 0.5 * float(np.ptp(y)) if len(y) else 0.0
    waves = half_waves(t, y, max(LEAST_AMPLITUDE, RIPPLE * amplitude))
    if amplitude < LEAST_AMPLITUDE or len(waves.time) < 2:
        return FinalMotion(0.0, float("nan"), float("nan"))
    early, late = (0.5 * float(np.ptp(half)) for half in np.array_split(y, 2))
    rate = float(np.log(late / early)) / (0.5 * float(t[-1] - t[0])) if late > 0 < early else float("-inf")
    return FinalMotion(amplitude, 0.5 * len(waves.duration) / float(waves.duration.sum()), rate)
