"""Frequency responses: Bode, Nyquist, poles and zeros, several speeds in one figure."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from rollerrig.plot.log_axis import logarithmic
from rollerrig.plot.style import colour, house_style, look, new_figure, panels

Curve = tuple[NDArray[np.float64], NDArray[np.complex128]]
"""Frequencies [Hz] and complex amplitudes there."""


def bode_figure(lines: Mapping[str, Curve], points: Mapping[str, Curve], unit: str) -> Figure:
    """Magnitude and phase over frequency: lines of the linear bench, points as measured, one colour per label.

    Args:
        lines: label -> response.
        points: label -> measured response, of some of the labels.
        unit: of the magnitude.
    """
    with panels([f"magnitude [dB re 1 {unit}]", "phase [°]"], "frequency [Hz]", 5.0) as (figure, (magnitude, phase)):
        for number, (label, (frequencies, values)) in enumerate(lines.items()):
            angle = np.degrees(np.unwrap(np.angle(values)))
            magnitude.plot(frequencies, 20 * np.log10(np.abs(values)), label=label, **look(number))
            phase.plot(frequencies, angle, **look(number))
            if label not in points:
                continue
            at, measured = points[label]
            there = np.isfinite(measured)
            near = np.interp(at[there], frequencies, angle)
            turned = near + np.degrees(np.angle(measured[there] * np.exp(-1j * np.radians(near))))
            options: dict[str, Any] = {"marker": "o", "markersize": 3.5, "linestyle": "none", "color": colour(number)}
            magnitude.plot(at[there], 20 * np.log10(np.abs(measured[there])), label=f"{label}, measured", **options)
            phase.plot(at[there], turned, **options)
        logarithmic(magnitude)
        logarithmic(phase)
    return figure


def nyquist_figure(lines: Mapping[str, Curve], unit: str) -> Figure:
    """The responses in the complex plane, with the point -1 of a loop closed over each."""
    with house_style():
        figure, (axes,) = new_figure(height=4.2)
        for number, (label, (_, values)) in enumerate(lines.items()):
            axes.plot(values.real, values.imag, label=label, **look(number))
        axes.plot([-1.0], [0.0], "k+", label="−1")
        axes.set_xlabel(f"real part [{unit}]")
        axes.set_ylabel(f"imaginary part [{unit}]")
        axes.legend(loc="best")
    return figure


def poles_and_zeros_figure(
    poles: Mapping[str, NDArray[np.complex128]], zeros: Mapping[str, NDArray[np.complex128]]
) -> Figure:
    """Poles as crosses, zeros as circles, one colour per label.

    Args:
        poles: label -> poles [1/s].
        zeros: label -> zeros [1/s], of the same labels.
    """
    with house_style():
        figure, (axes,) = new_figure(height=4.2)
        for number, label in enumerate(poles):
            there = colour(number)
            axes.plot(poles[label].real, poles[label].imag / (2 * np.pi), "x", color=there, ms=5, label=label)
            axes.plot(zeros[label].real, zeros[label].imag / (2 * np.pi), "o", color=there, ms=5, mfc="none")
        axes.axvline(0.0, color="black", lw=0.6)
        axes.set_xscale("symlog", linthresh=1.0)
        axes.set_yscale("symlog", linthresh=1.0)
        axes.set_xlabel("growth rate [1/s]")
        axes.set_ylabel("frequency [Hz]")
        axes.legend(loc="best")
    return figure
