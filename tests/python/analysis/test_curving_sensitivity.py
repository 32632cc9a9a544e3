"""Derivatives of steady curving against Richardson-extrapolated differences of `curving`; what is refused, and why."""

from __future__ import annotations

import numpy as np
import pytest

import rollerrig as rr
from rollerrig.analysis.curving_sensitivity import OUTPUTS, curving_parameters
from rollerrig.config import ConfigError
from rollerrig.simulation.sensitivity import changed_case

KEYS = [
    "vehicle.element.primary_*.x.stiffness",
    "vehicle.element.secondary_spring_*.y.stiffness",
    "contact.friction.mu_0",
    "support.cant_base",
]
CURVE = {"radius": 300.0, "deficiency": 0.1}


@pytest.fixture(scope="module")
def found():
    return rr.curving_sensitivity("vehicle_curve", KEYS, **CURVE)


@pytest.mark.slow
def test_differences_of_steady_states(found) -> None:
    """Differences of 0.02 % and half of it, extrapolated: to 1e-5 of what the number that moves an output most does to it."""
    case, off = rr.load_case("vehicle_curve"), {}
    for key in KEYS:
        value = float(found["value"].sel(parameter=key))

        def difference(part: float, key: str = key, value: float = value):
            above, below = (
                rr.curving(changed_case(case, key, value * (1 + sign * part)), [300.0], [0.1]) for sign in (1, -1)
            )
            return ((above[[*OUTPUTS]] - below[[*OUTPUTS]]) / (2 * part)).isel(radius=0, cant_deficiency=0)

        wanted = (4 * difference(1e-4) - difference(2e-4)) / 3
        own = value * found[[f"{name}_derivative" for name in OUTPUTS]].sel(parameter=key)
        off[key] = {
            name: (float(abs(own[f"{name}_derivative"] - wanted[name]).max()), float(abs(wanted[name]).max()))
            for name in OUTPUTS
        }
    for name in OUTPUTS:
        largest = max(one[name][1] for one in off.values())
        assert {key: one[name][0] / largest for key, one in off.items() if one[name][0] > 1e-5 * largest} == {}


def test_the_steady_state_is_that_of_curving(found) -> None:
    whole = rr.curving("vehicle_curve", [300.0], [0.1]).isel(radius=0, cant_deficiency=0)
    for name in OUTPUTS:
        np.testing.assert_allclose(found[name], whole[name], rtol=1e-9, atol=1e-12)
        assert found[f"{name}_derivative"].dims == ("parameter", *whole[name].dims)
    assert found.attrs["speed_kmh"] == pytest.approx(3.6 * float(whole["speed"]))


def test_more_friction_wears_more_and_a_wider_base_of_the_cant_runs_slower(found) -> None:
    """v^2 goes with 1 / b_0: the car body leans less to the outer rails, whose wheels carry less."""
    assert float(found["wear_number_derivative"].sel(parameter="contact.friction.mu_0").sum()) > 0.0
    loads = found["wheel_load_derivative"].sel(parameter="support.cant_base")
    assert float(loads[1::2].sum()) < 0.0


def test_what_drives_the_rollers_and_their_radius_changes_nothing() -> None:
    case = rr.load_case("bogie_rollers_constant")
    keys = ["support.roller_radius", "vehicle.element.primary_*.y.stiffness"]
    found = rr.curving_sensitivity(case, keys, radius=600.0, deficiency=0.0)
    size = abs(found["value"] * found["lateral_derivative"]).max("wheelset")
    assert float(size[0]) < 1e-6 * float(size[1])


def test_numbers_by_default_are_stiffnesses_and_friction() -> None:
    keys = list(curving_parameters(rr.load_case("bogie_track")))
    assert "vehicle.element.primary_*.x.stiffness" in keys
    assert keys[-1] == "contact.friction.mu_0"
    assert not [key for key in keys if "damping" in key]
    two = rr.load_case("bogie_track").with_changes({"contact.gauge_face_friction": 0.1})
    assert list(curving_parameters(two)) == [*keys, "contact.gauge_face_friction"]


@pytest.mark.parametrize(
    ("key", "message"),
    [
        ("contact.friction.mu_1", "contact.friction.mu_1: there is no such number"),
        ("vehicle.element.primary_*.*.stiffness", "stands for 1.22e+06"),
    ],
)
def test_keys_that_are_no_numbers_are_refused(key: str, message: str) -> None:
    with pytest.raises(ConfigError) as problem:
        rr.curving_sensitivity("vehicle_curve", [key], **CURVE)
    assert message in str(problem.value)
    assert "\n" not in str(problem.value)


def test_a_curve_without_a_steady_state_says_why() -> None:
    with pytest.raises(rr.StartError, match=r"no steady state with R = 300 m .* of -500 mm: no speed between 1 and"):
        rr.curving_sensitivity("vehicle_curve", [], radius=300.0, deficiency=-0.5)
    with pytest.raises(rr.StartError, match=r"no steady state with R = 300 m .*: .*speed beyond overturning"):
        rr.curving_sensitivity("vehicle_curve", [], radius=300.0, deficiency=10.0)
