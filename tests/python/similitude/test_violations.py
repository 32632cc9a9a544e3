"""What a real model violates, against the closed forms and against the contact computed on both rigs."""

from __future__ import annotations

import math

import pytest

import rollerrig as rr
from rollerrig.assembly.model import assemble
from rollerrig.config import Case
from rollerrig.similitude import (
    STRATEGIES,
    Requirement,
    distortion,
    requirements,
    scale_case,
    similitude,
)
from rollerrig.simulation.starting_state import equilibrium_dataset

CASE = rr.load_case("adhesion_brake")


def found(strategy: str, keep: tuple[str, ...]) -> dict[str, Requirement]:
    model = scale_case(CASE, similitude(strategy), strategy=strategy, keep=keep)
    return {one.name: one for one in requirements(CASE, model)}


@pytest.mark.parametrize("strategy", STRATEGIES)
def test_an_ideal_model_violates_nothing(strategy: str) -> None:
    assert all(one.met for one in found(strategy, ()).values())


@pytest.mark.parametrize(
    ("strategy", "gravity", "modulus"), [("mmu", 4.0, 24.0), ("dlr", 0.0, 1.5), ("inrets", -0.75, 0.0)]
)
def test_gravity_and_steel_as_published(strategy: str, gravity: float, modulus: float) -> None:
    """phi_a - 1, and phi_F/phi_l^2 - 1: the strategies keep what they are chosen for."""
    rows = found(strategy, ("gravity", "material"))
    assert rows["weight against inertia (Froude)"].deviation == pytest.approx(gravity, abs=1e-12)
    assert rows["elasticity of the contact (Hertz)"].deviation == pytest.approx(modulus, abs=1e-12)
    assert rows["friction"].met


def contact_at_rest(case: Case) -> tuple[float, float, float]:
    """Load [N], sqrt(a b) [m] and largest pressure [Pa] of the first wheel, which has one patch, in steady running."""
    rest = equilibrium_dataset(assemble(case)).isel(time=0, wheel=0, patch=0)
    load, a, b = (float(rest[name]) for name in ("patch_normal", "patch_a", "patch_b"))
    return load, math.sqrt(a * b), 1.5 * load / (math.pi * a * b)


@pytest.mark.parametrize("strategy", STRATEGIES)
def test_the_contact_at_rest_is_distorted_as_the_closed_form_says(strategy: str) -> None:
    """On cones, where each wheel has one patch that keeps its place: (w/e)^(1/3) for its size, w for its load.

    The load of a leaning patch depends on its share of lateral creep force, 0.3 %; Hertz' ellipse on the place it takes, 1 %.
    """
    changes = {"vehicle.wheel.profile": "cone_1_40"}
    full = rr.load_case("bogie_rollers_constant").with_changes(changes)
    model = scale_case(full, similitude(strategy), strategy=strategy)
    (weight, modulus), factors = distortion(full, model), similitude(strategy)
    size = (weight / modulus) ** (1.0 / 3.0)
    load, axis, pressure = (
        one / there for one, there in zip(contact_at_rest(model), contact_at_rest(full), strict=True)
    )
    assert load * factors.factor("N") == pytest.approx(weight, rel=3e-3)
    assert axis * factors.length == pytest.approx(size, rel=1e-2)
    assert pressure * factors.factor("Pa") == pytest.approx(weight / size**2, rel=2e-2)


def test_a_kept_clock_and_kept_drives_are_told() -> None:
    rows = found("inrets", ("clock", "drives"))
    clock = rows["clock of the slide protection"]
    assert (clock.required, clock.actual) == pytest.approx((1.25e-3, 5e-3))
    assert clock.effect == "the slide protection is asked 0.25 times as often as needed"
    assert rows["lag of the drives of the rollers"].deviation == pytest.approx(-0.75)
    assert found("mmu", ("clock", "drives"))["clock of the slide protection"].met


def test_motors_that_stand_in_for_the_brakes_are_a_lag_of_their_own() -> None:
    changes = {"brake.by_traction_motors": True, "traction.motor.bandwidth": "100 Hz"}
    model = scale_case(CASE, similitude("inrets"), strategy="inrets", keep=("material",), changes=changes)
    violated = [one for one in requirements(CASE, model) if not one.met]
    assert [one.name for one in violated] == ["brake torque at once"]
    assert violated[0].actual == pytest.approx(1.59e-3, rel=1e-2)
