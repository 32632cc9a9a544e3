"""Equivalent conicity against laws of Δr whose wavelength is known in closed form."""

from __future__ import annotations

import math

import numpy as np
import pytest
import xarray as xr
from hypothesis import given, settings
from hypothesis import strategies as st

from rollerrig.contact_analysis import conicity_table, equivalent_conicity, nonlinearity_parameter

Y = np.linspace(-8e-3, 8e-3, 161)
AMPLITUDES = [0.5e-3, 2e-3, 3e-3, 7.95e-3]


@settings(deadline=None, max_examples=25)
@given(conicity=st.floats(1e-3, 1.0), amplitude=st.floats(0.1e-3, 8e-3))
def test_a_cone_has_its_conicity_at_every_amplitude(conicity: float, amplitude: float) -> None:
    # Midpoint quadrature of a constant: round-off only.
    assert equivalent_conicity(Y, 2 * conicity * Y, [amplitude])[0] == pytest.approx(conicity, rel=1e-9)


def test_a_cubic_law_grows_with_the_square_of_the_amplitude() -> None:
    """Δr = k y^3: a quarter is sqrt(2/k)/A times Γ(1/4)^2 / (4 sqrt(2π)), so tan γ = (π A / 4I)^2 k."""
    k, y = 2e3, np.linspace(-8e-3, 8e-3, 1601)
    integral = math.gamma(0.25) ** 2 / (4 * math.sqrt(2 * math.pi))
    exact = [(math.pi * a / (4 * integral)) ** 2 * k for a in AMPLITUDES]
    # Straight lines at 0.01 mm: at 0.5 mm the curvature between them is 1e-4 of the value.
    assert equivalent_conicity(y, k * y**3, AMPLITUDES) == pytest.approx(exact, rel=3e-4)


def test_a_step_of_the_radii_falls_with_the_amplitude() -> None:
    """Δr = c sign(y): uniformly accelerated quarters, tan γ = π^2 c / (16 A)."""
    c, edge = 1e-3, 1e-7
    y = np.array([-8e-3, -edge, 0.0, edge, 8e-3])
    exact = [math.pi**2 * c / (16 * a) for a in AMPLITUDES]
    assert equivalent_conicity(y, c * np.clip(y / edge, -1, 1), AMPLITUDES) == pytest.approx(exact, rel=1e-3)


def test_equal_radii_have_no_conicity_and_an_inverse_cone_has_none_at_all() -> None:
    assert equivalent_conicity(Y, np.zeros_like(Y), AMPLITUDES).tolist() == [0.0] * 4
    assert np.isnan(equivalent_conicity(Y, -0.1 * Y, AMPLITUDES)).all()


def test_a_cylinder_between_flanges_weaves_only_beyond_its_play() -> None:
    play, slope = 2e-3, 0.5
    dr = np.where(np.abs(Y) > play, slope * (np.abs(Y) - play) * np.sign(Y), 0.0)
    # A quarter: straight across the play at the speed of the flange's harmonic arc, then a quarter of that arc's wave.
    reach = 2e-3
    quarter = (play / reach + math.pi / 2) / math.sqrt(slope)
    exact = 2 * (math.pi / (4 * quarter)) ** 2
    found = equivalent_conicity(Y, dr, [1e-3, play + reach])
    assert found[0] == 0.0
    assert found[1] == pytest.approx(exact, rel=1e-3)  # rows at 0.1 mm meet the corner exactly


def test_wavelength_and_nonlinearity() -> None:
    shifts = xr.Dataset(
        dict.fromkeys(("effective_difference", "rolling_radius_difference"), ("lateral", 2 * 0.05 * Y)),
        {"lateral": Y},
        {"contact_distance_m": 1.5, "wheel_radius_m": 0.46, "title": "cone", "support": "track"},
    )
    table = conicity_table(shifts, AMPLITUDES)
    klingel = 2 * math.pi * math.sqrt(0.46 * 0.75 / 0.05)
    assert table["wavelength"].to_numpy() == pytest.approx(klingel)
    assert table.attrs["nonlinearity_per_mm"] == pytest.approx(0.0, abs=1e-9)
    assert nonlinearity_parameter(Y, 1e3 * Y * np.abs(Y)) > 0
    assert math.isnan(nonlinearity_parameter(Y[np.abs(Y) < 3e-3], Y[np.abs(Y) < 3e-3]))


@pytest.mark.parametrize("amplitude", [0.0, -1e-3, 8.1e-3])
def test_amplitudes_that_cannot_be_reached_are_refused(amplitude: float) -> None:
    with pytest.raises(ValueError, match="allowed above 0 and up to 8 mm"):
        equivalent_conicity(Y, Y, [amplitude])
