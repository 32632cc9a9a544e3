"""Figures: axes carry units, the same input gives the same bytes, nothing of the user's settings shows."""

from __future__ import annotations

import matplotlib as mpl
import numpy as np
import pytest
import xarray as xr

from rollerrig.plot import (
    amplitude_over_speed,
    damping_over_speed,
    figure_bytes,
    frequency_over_speed,
    hunting_over_time,
    ramp_over_speed,
    root_locus,
    traction_forces,
    traction_sliding,
)

TIME = np.linspace(0, 2, 201)
SPEED = np.array([60.0, 120.0, 180.0])
WHEELS = ["front", "rear"]


def modes() -> xr.Dataset:
    growth = np.array([[-1.0, -5.0], [0.2, -5.0], [1.0, -5.0]])
    frequency = np.array([[2.0, 10.0], [4.0, 10.0], [5.0, 10.0]])
    variables = {
        name: (("speed", "mode"), values) for name, values in (("growth_rate", growth), ("frequency", frequency))
    }
    damping = -growth / np.hypot(growth, 2 * np.pi * frequency)
    coordinates = {"speed": SPEED, "mode": ["hunting", "frame pitch"]}
    return xr.Dataset(
        {**variables, "damping": (("speed", "mode"), damping)}, coordinates, {"linear_critical_speed_kmh": 110.0}
    )


def motion() -> xr.Dataset:
    lateral = 1e-3 * np.sin(20 * TIME)[:, None]
    return xr.Dataset(
        {"lateral": (("time", "body"), lateral), "speed": ("time", 20 + 5 * np.sin(np.pi * TIME / 2))},
        {"time": TIME, "body": ["front_frame"]},
        {"nudge_times_s": "[0.5]"},
    )


def table() -> xr.Dataset:
    values = {"amplitude": [0.0, 1e-3, 2e-3], "oscillation_frequency": [np.nan, 4.0, 5.0], "sustained": [0, 1, 1]}
    return xr.Dataset({name: ("speed", v) for name, v in values.items()}, {"speed": SPEED})


def traction() -> xr.Dataset:
    names = ("sliding", "sliding_theory", "longitudinal_force", "longitudinal_force_theory")
    both = (*names, "vertical_force", "vertical_force_theory")
    variables = {name: (("time", "wheel"), np.ones((len(TIME), 2))) for name in both}
    return xr.Dataset({**variables, "torque": ("time", TIME), "speed": ("time", TIME)}, {"time": TIME, "wheel": WHEELS})


FIGURES = {
    "root_locus": lambda: root_locus(modes()),
    "damping": lambda: damping_over_speed(modes()),
    "frequency": lambda: frequency_over_speed(modes(), table()),
    "ramp": lambda: ramp_over_speed({"steel": motion()}, "front_frame", {"steel": {"linear": 80.0, "none": np.nan}}),
    "time": lambda: hunting_over_time([(60.0, motion()), (80.0, motion())], "front_frame"),
    "amplitude": lambda: amplitude_over_speed({"steel": table()}, {"linear": 100.0}),
    "sliding": lambda: traction_sliding(traction(), {w: w for w in WHEELS}),
    "forces": lambda: traction_forces(traction(), {w: w for w in WHEELS}),
}


@pytest.mark.parametrize("name", FIGURES)
def test_every_axis_carries_its_unit(name: str) -> None:
    figure = FIGURES[name]()
    labels = [label for axes in figure.axes for label in (axes.get_xlabel(), axes.get_ylabel()) if label]
    assert labels
    assert all("[" in label and label.rstrip(")").count("[") == label.count("]") for label in labels), labels


@pytest.mark.parametrize("name", FIGURES)
def test_the_same_figure_gives_the_same_bytes(name: str) -> None:
    first = figure_bytes(FIGURES[name]())
    with mpl.rc_context({"font.size": 30, "lines.linewidth": 9}):
        second = figure_bytes(FIGURES[name]())
    assert first == second
    assert b"<dc:date>" not in first


def test_png_is_the_same_too() -> None:
    assert figure_bytes(root_locus(modes()), "png") == figure_bytes(root_locus(modes()), "png")
