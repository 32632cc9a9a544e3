"""Persistent ripple in the torque of the roller drives: amplitude and frequency above the action of the slide protection."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

RIPPLE_ABOVE = 10.0
"""Slide protection acts at a few hertz; what is faster is the loop or its noise [Hz]."""

WINDOW = 0.25  # [s]


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
    if time.size < 2 or time[-1] - time[0] < 2.0 * WINDOW or not np.isfinite(torque).all():
        return math.nan, math.nan
    from scipy.signal import butter, sosfiltfilt, welch  # slow to load, and seldom needed

    step = float(time[1] - time[0])
    window = round(WINDOW / step)
    high = sosfiltfilt(butter(4, RIPPLE_ABOVE, "highpass", fs=1.0 / step, output="sos"), torque, axis=0)
    count = len(high) // window
    parts = np.sqrt(np.mean(high[: count * window].reshape(count, window, -1) ** 2, axis=1))
    median = np.median(parts, axis=0)
    worst = int(np.argmax(median))
    frequency, power = welch(high[:, worst], fs=1.0 / step, nperseg=min(len(high), 4 * window))
    return float(median[worst]), float(frequency[np.argmax(power)])
