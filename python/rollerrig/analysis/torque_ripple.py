"""Ripple in the torque of the roller drives above the action of the slide protection: how large, how long, how fast.

torque over time -> [ripple_windows] -> RMS of each window -> persistent ripple and frequency, or largest ripple and spell
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

RIPPLE_ABOVE = 10.0
"""Slide protection acts at a few hertz; what is faster is the loop or its noise [Hz]."""

WINDOW = 0.25  # [s]
PERCENTILE = 95.0


def torque_ripple(time: Array, torque: Array) -> tuple[float, float]:
    """Persistent ripple of the worst axle's torque, and its frequency.

    The RMS above RIPPLE_ABOVE in windows of a quarter of a second; the median of them, since the response to a switching valve
    decays sooner than in every second of them.

    Args:
        time: evenly spaced [s], shape (time,).
        torque: [N m], shape (time, axle).

    Returns:
        RMS [N m] and frequency of most power [Hz]; NaN where the run is shorter than two windows.
    """
    found = ripple_windows(time, torque)
    if found is None:
        return math.nan, math.nan
    from scipy.signal import welch  # slow to load, and seldom needed

    parts, high = found
    median = np.median(parts, axis=0)
    worst, step = int(np.argmax(median)), float(time[1] - time[0])
    frequency, power = welch(high[:, worst], fs=1.0 / step, nperseg=min(len(high), 4 * round(WINDOW / step)))
    return float(median[worst]), float(frequency[np.argmax(power)])


def largest_ripple(time: Array, torque: Array, limit: float) -> tuple[float, float]:
    """Ripple that is not passed for PERCENTILE of the time, of the worst axle, and its longest spell above a limit.

    Args:
        time: evenly spaced [s], shape (time,).
        torque: [N m], shape (time, axle).
        limit: RMS of a window [N m].

    Returns:
        RMS [N m] and duration [s]; NaN where the run is shorter than two windows.
    """
    found = ripple_windows(time, torque)
    if found is None:
        return math.nan, math.nan
    spell = longest = np.zeros(found[0].shape[1])
    for above in found[0] > limit:
        spell = np.where(above, spell + WINDOW, 0.0)
        longest = np.maximum(longest, spell)
    return float(np.percentile(found[0], PERCENTILE, axis=0).max()), float(longest.max())


def ripple_windows(time: Array, torque: Array) -> tuple[Array, Array] | None:
    """RMS above RIPPLE_ABOVE in each window, shape (window, axle), and the filtered torque, shape (time, axle).

    None where the run is shorter than two windows or has no torque at some time.
    """
    if time.size < 2 or time[-1] - time[0] < 2.0 * WINDOW or not np.isfinite(torque).all():
        return None
    from scipy.signal import butter, sosfiltfilt  # slow to load, and seldom needed

    step = float(time[1] - time[0])
    window = round(WINDOW / step)
    high = sosfiltfilt(butter(4, RIPPLE_ABOVE, "highpass", fs=1.0 / step, output="sos"), torque, axis=0)
    count = len(high) // window
    return np.sqrt(np.mean(high[: count * window].reshape(count, window, -1) ** 2, axis=1)), high
