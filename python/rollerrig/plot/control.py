"""Figures of the rig's control: comparisons of controllers, and frequency responses."""

import math
from collections.abc import Mapping, Sequence
from typing import Any, Literal

import numpy as np
from matplotlib.figure import Figure

from rollerrig.common.arrays import Array, Complex
from rollerrig.plot.style import (
    COLOURS,
    GREY,
    MARKERS,
    colour,
    house_style,
    legend_above,
    logarithmic,
    look,
    new_figure,
    panels,
)

LIMIT: dict[str, Any] = {"color": "#b00020", "linewidth": 1.0, "linestyle": (0, (5, 2))}
SHIPPED: dict[str, Any] = {"color": GREY, "linewidth": 1.0, "linestyle": ":"}
"""Looks of a failure limit, and of the case as it is."""


def over_parameter(
    curves: Mapping[str, Array],
    label: str,
    scale: Literal["log", "linear"],
    base: float | None,
    limits: tuple[float, float],
) -> Figure:
    """Tracking error and ripple over what is varied, a line per curve; a vertical line at the base, the value of the case.

    Curves by label: a row of value, tracking RMS [-] and ripple [N m] per test, NaN where it ended early.
    Limits: the same two numbers from which on a variant fails.
    """
    with panels(("tracking error\nRMS [%]", "torque ripple\nRMS [N m]"), label, 4.6) as (figure, both):
        for number, (name, points) in enumerate(curves.items()):
            style = {**look(number), "marker": MARKERS[number % len(MARKERS)], "markersize": 4.0}
            for axes, values, factor in zip(both, points.T[1:], (100.0, 1.0), strict=True):
                axes.plot(points[:, 0], factor * values, label=name, **style)
            early = points[np.isnan(points[:, 1]), 0]
            if early.size:
                y, top = np.full(early.size, 0.94 - 0.08 * number), both[0].get_xaxis_transform()
                options: dict[str, Any] = {"color": colour(number), "markersize": 7.0, "transform": top}
                both[0].plot(early, y, "x", label=f"{name}: test ended early", **options)
        for axes, limit, least in zip(both, (100.0 * limits[0], limits[1]), (0.0, 1e-2), strict=True):
            logarithmic(axes, "y")
            axes.axhline(limit, **LIMIT)
            axes.set_ylim(bottom=max(axes.get_ylim()[0], least * limit))
            if base is not None:
                axes.axvline(base, **SHIPPED)
        if scale == "log":
            logarithmic(both[1])
    return figure


Response = tuple[Array, Complex]
"""Frequencies [Hz] and complex amplitudes there."""


def bode_figure(lines: Mapping[str, Response], points: Mapping[str, Response], unit: str) -> Figure:
    """Magnitude and phase over frequency: lines of the linear bench, points as measured, one colour per label."""
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


@house_style()
def nyquist_figure(lines: Mapping[str, Response], unit: str) -> Figure:
    """The responses in the complex plane, with the point -1 of a loop closed over each."""
    figure, (axes,) = new_figure(height=4.2)
    for number, (label, (_, values)) in enumerate(lines.items()):
        axes.plot(values.real, values.imag, label=label, **look(number))
    axes.plot([-1.0], [0.0], "k+", label="−1")
    axes.set(xlabel=f"real part [{unit}]", ylabel=f"imaginary part [{unit}]")
    axes.legend(loc="best")
    return figure


@house_style()
def poles_and_zeros_figure(poles: Mapping[str, Complex], zeros: Mapping[str, Complex]) -> Figure:
    """Poles as crosses, zeros as circles [1/s], one colour per label."""
    figure, (axes,) = new_figure(height=4.2)
    for number, label in enumerate(poles):
        there = colour(number)
        axes.plot(poles[label].real, poles[label].imag / (2 * np.pi), "x", color=there, ms=5, label=label)
        axes.plot(zeros[label].real, zeros[label].imag / (2 * np.pi), "o", color=there, ms=5, mfc="none")
    axes.axvline(0.0, color="black", lw=0.6)
    axes.set_xscale("symlog", linthresh=1.0)
    axes.set_yscale("symlog", linthresh=1.0)
    axes.set(xlabel="growth rate [1/s]", ylabel="frequency [Hz]")
    axes.legend(loc="best")
    return figure


@house_style()
def front(points: Mapping[str, Mapping[str, Any]], names: Sequence[str], shipped: str, chosen: str) -> Figure:
    """Torque ripple over tracking error of candidates, as a line the names of the front, by rising tracking error.

    Points have `tracking_rms` [-] and `ripple_nm` [N m] with `mean`, `low` and `high`; two names are those of the case as it is,
    and of the compromise.
    """
    figure, (axes,) = new_figure(height=4.2)
    both, ends = (("tracking_rms", 100.0), ("ripple_nm", 1.0)), ("mean", "low", "high")
    shown = {name: np.array([[factor * (one[of][end] or math.nan) for end in ends] for of, factor in both])
             for name, one in points.items()}  # fmt: skip
    on_front = [shown[name][:, 0] for name in names]
    if on_front:
        axes.plot(*np.array(on_front).T, color=COLOURS[0], label="front")
    for name, one in shown.items():
        reach = np.abs(one[:, 1:] - one[:, :1])
        looks: dict[str, Any] = {
            "fmt": "o",
            "color": COLOURS[0] if name in names else GREY,
            "markersize": 4.0,
            "linewidth": 0.8,
        }
        if name == shipped:
            looks |= {"fmt": "s", "color": COLOURS[1], "markersize": 7.0, "label": "as shipped"}
        elif name == chosen:
            looks |= {"fmt": "D", "markersize": 7.0, "label": "best compromise"}
        axes.errorbar(one[0, 0], one[1, 0], xerr=reach[0][:, None], yerr=reach[1][:, None], **looks)
    for which in ("x", "y"):
        logarithmic(axes, which)
    axes.set_xlabel("tracking error RMS [%]")
    axes.set_ylabel("torque ripple RMS [N m]")
    legend_above(figure, axes)
    return figure
