"""Derivatives of the critical speed against differences of critical speeds, and what counts as a number of the suspension."""

from __future__ import annotations

import numpy as np
import pytest

import rollerrig as rr
from rollerrig.analysis import mode_table
from rollerrig.analysis.critical_speed import scan_linear
from rollerrig.analysis.modes import Lineariser, eigensystem
from rollerrig.analysis.stability_sensitivity import suspension_parameters
from rollerrig.simulation.sensitivity import changed_case

KEYS = ["vehicle.element.primary_*.x.stiffness", "support.roller_radius"]


@pytest.fixture(scope="module")
def found():
    return rr.stability_sensitivity("bogie_rollers_constant", KEYS, [200.0, 220.0, 240.0, 260.0])


@pytest.mark.parametrize("key", KEYS)
def test_critical_speed(found, key: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Differences of 0.5 %, extrapolated from twice that: their error is about 1e-7."""
    monkeypatch.setattr(mode_table, "SPEED_TOLERANCE", 1e-9)
    own = found.sel(parameter=key)
    value, speed = float(own["value"]), found.attrs["linear_critical_speed_kmh"] / 3.6

    def critical(factor: float) -> float:
        case = changed_case(rr.load_case("bogie_rollers_constant"), key, value * factor)
        return scan_linear(case, [3.6 * (speed - 2.0), 3.6 * (speed + 2.0)]).speed_kmh

    wide, narrow = ((critical(1 + w) - critical(1 - w)) / (2 * w * value) for w in (0.01, 0.005))
    assert float(own["critical_speed_derivative"]) == pytest.approx((4 * narrow - wide) / 3, rel=1e-5)


def test_eigenvalues(found) -> None:
    key = KEYS[0]
    own = found.sel(parameter=key)
    value, speed = float(own["value"]), found.attrs["linear_critical_speed_kmh"] / 3.6
    roots = found["growth_rate"].values + 1j * found["angular_frequency"].values
    moved = [
        eigensystem(
            Lineariser(rr.load_case("bogie_rollers_constant").with_changes({key: value * (1 + w)})).at(speed).matrix
        ).values
        for w in (1e-3, -1e-3)
    ]
    mode = int(np.argmin(np.abs(roots.real)))  # the critical one
    above, below = (each[np.argmin(np.abs(each - roots[mode]))] for each in moved)
    wanted = (above - below) / (2e-3 * value)
    derivative = own["growth_rate_derivative"].values[mode] + 1j * own["angular_frequency_derivative"].values[mode]
    assert derivative == pytest.approx(wanted, rel=1e-4)


def test_numbers_of_the_suspension() -> None:
    keys = list(suspension_parameters(rr.load_case("bogie_track")))
    assert "vehicle.element.primary_*.x.stiffness" in keys
    assert "vehicle.element.primary_*.x.damper.series_stiffness" in keys
    assert len(keys) == len(set(keys))


def test_without_a_critical_speed_it_says_so() -> None:
    with pytest.raises(ValueError, match="no linear critical speed between them"):
        rr.stability_sensitivity("bogie_track", [], [60.0, 80.0])
