"""The frequency of an oscillation that dies out, as figure 7b of the paper needs it."""

from __future__ import annotations

import math

import numpy as np
import pytest
import xarray as xr

from rollerrig.analysis.hunting import HuntingRun, decay_frequency
from rollerrig.analysis.limit_cycle import decide_motion
from rollerrig.analysis.signals import final_motion


def run_of(lateral: np.ndarray, time: np.ndarray) -> HuntingRun:
    motion = xr.Dataset(
        {"lateral": (("time", "body"), lateral[:, None])}, {"time": time, "body": ["frame"]}, {"status": "ok"}
    )
    return HuntingRun(30.0, "frame", motion, final_motion(time, lateral), decide_motion(time, lateral, ended=True))


@pytest.mark.parametrize("damping", [0.05, 0.2, 0.4])
def test_a_damped_oscillation_has_its_damped_frequency(damping: float) -> None:
    time = np.arange(0.0, 6.0, 5e-3)
    omega = 2 * math.pi * 3.0
    lateral = 3e-3 * np.exp(-damping * omega * time) * np.cos(omega * math.sqrt(1 - damping**2) * time + 0.3)
    # Extrema of a damped cosine are exactly half a period apart; the spline between 5 ms samples places them to 1e-4.
    assert decay_frequency(run_of(lateral, time)) == pytest.approx(3.0 * math.sqrt(1 - damping**2), rel=1e-3)


def test_what_goes_on_or_never_swings_has_none() -> None:
    time = np.arange(0.0, 6.0, 5e-3)
    assert math.isnan(decay_frequency(run_of(1e-3 * np.sin(20 * time), time)))
    assert math.isnan(decay_frequency(run_of(3e-3 * np.exp(-5 * time), time)))


def test_what_is_left_much_later_does_not_count() -> None:
    time = np.arange(0.0, 6.0, 5e-3)
    hunting = 3e-3 * np.exp(-3.0 * time) * np.cos(2 * math.pi * 4.0 * time)
    sway = 0.1e-3 * np.exp(-1.0 * time) * np.cos(2 * math.pi * 0.5 * time)
    assert decay_frequency(run_of(hunting + sway, time)) == pytest.approx(4.0, rel=0.02)
