"""The estimate of wheel flats: energy of each lock, worn segment, length."""

from __future__ import annotations

import math

import numpy as np
import pytest
import xarray as xr

from rollerrig import load_case, simulate
from rollerrig.analysis.slide_statistics import flat_length, lock_energies, longest_flat, longest_lock, wheel_radius


@pytest.mark.parametrize("length", [1e-3, 0.02, 0.06])
def test_what_is_worn_off_is_the_segment_of_the_circle_under_the_flat(length: float) -> None:
    """Exact segment r^2 (a - sin a) / 2; (H2) is its first term, which makes the flat longer by (L/r)^2 / 40."""
    radius, width, wear = 0.46, 0.012, 7e-13
    angle = 2.0 * math.asin(0.5 * length / radius)
    volume = width * 0.5 * radius**2 * (angle - math.sin(angle))
    found = flat_length(volume / wear, radius, wear, width)
    assert found == pytest.approx(length * (1.0 + (length / radius) ** 2 / 40), rel=(length / radius) ** 4 + 1e-12)
    assert flat_length(0.0, radius, wear, width) == 0.0


@pytest.fixture(scope="module")
def run() -> xr.Dataset:
    case = load_case("adhesion_brake").with_changes({"time.duration": "20 ms"})
    return simulate(case)


def test_the_energy_of_a_lock_is_force_times_way_of_the_train(run: xr.Dataset) -> None:
    """Made-up signals: one axle locked for 2 s at 20 m/s under 6 kN, twice; half of it under each wheel."""
    clock = np.arange(0.0, 10.0, 0.01)
    locked = ((clock >= 1.0) & (clock < 3.0)) | ((clock >= 6.0) & (clock < 8.0))
    turning = np.where(locked, 0.0, 20.0 / wheel_radius(run))
    speeds = np.stack([turning, np.full(clock.size, 20.0 / wheel_radius(run))], axis=1)
    axes = ("time", "axle")
    made = xr.Dataset(
        {
            "train_speed": ("time", np.full(clock.size, 20.0)),
            "axle_speed": (axes, speeds),
            "creep_force": (axes, np.full((clock.size, 2), -6e3)),
        },
        coords={"time": clock, "axle": run["axle"].to_numpy()},
        attrs=run.attrs,
    )
    energies = lock_energies(made)
    assert energies == pytest.approx([0.5 * 6e3 * 20.0 * 2.0] * 2, rel=0.01)  # a sample more or less of 200
    assert longest_lock(made) == pytest.approx(2.0, abs=0.02)
    assert longest_flat(made, 7e-13, 0.012) == flat_length(energies.max(), wheel_radius(run), 7e-13, 0.012)


def test_wheels_that_turn_get_no_flat(run: xr.Dataset) -> None:
    assert lock_energies(run).size == 0
    assert longest_flat(run, 7e-13, 0.012) == 0.0
