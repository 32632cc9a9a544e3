"""Factors of the strategies against the algebra of similitude."""

from __future__ import annotations

import math

import pytest

from rollerrig import ConfigError
from rollerrig.similitude import STRATEGIES, Similitude, similitude
from rollerrig.similitude.factors import UnknownUnitError, exponents


@pytest.mark.parametrize(
    ("unit", "powers"),
    [
        ("1", (0, 0, 0)),
        ("rad", (0, 0, 0)),
        ("N", (1, 1, -2)),
        ("kg m^2", (1, 2, 0)),
        ("N m s/rad", (1, 2, -1)),
        ("N s^2/m^2", (1, -1, 0)),
        ("m^2/J", (-1, 0, 2)),
        ("Pa/s", (1, -1, -3)),
        ("s/m", (0, -1, 1)),
        ("1/s", (0, 0, -1)),
        ("km/h", (0, 1, -1)),
    ],
)
def test_a_unit_is_made_of_mass_length_and_time(unit: str, powers: tuple[int, int, int]) -> None:
    assert exponents(unit) == powers


@pytest.mark.parametrize("unit", ["bananas", "N m s/ rad cd", "m^x", "A"])
def test_an_unknown_unit_is_refused(unit: str) -> None:
    with pytest.raises(UnknownUnitError):
        exponents(unit)


@pytest.mark.parametrize("name", STRATEGIES)
def test_factors_keep_the_laws_of_mechanics(name: str) -> None:
    """F = m a, M = F l, E = F l, P = F v, p = F/l^2, k = F/l, c = F/v: whatever the three factors are."""
    f = similitude(name, length=7.0).factor
    exact = pytest.approx(1.0, rel=1e-14)  # products of powers: round-off
    assert f("N") / (f("kg") * f("m/s^2")) == exact
    assert f("N m") / (f("N") * f("m")) == exact
    assert f("kg m^2") / (f("kg") * f("m") ** 2) == exact
    assert f("W") / (f("N") * f("m/s")) == exact
    assert f("Pa") / (f("N") / f("m") ** 2) == exact
    assert f("N/m") / (f("N") / f("m")) == exact
    assert f("N s/m") / (f("N") / f("m/s")) == exact
    assert f("Hz") * f("s") == exact


@pytest.mark.parametrize(
    ("name", "length", "time", "density", "speed", "acceleration", "force", "pressure"),
    [
        ("mmu", 5, 1, 1, 5, 5, 625, 25),
        ("dlr", 5, math.sqrt(5), 0.5, math.sqrt(5), 1, 62.5, 2.5),
        ("inrets", 4, 4, 1, 1, 0.25, 16, 1),
    ],
)
def test_the_strategies_as_published(
    name: str,
    length: float,
    time: float,
    density: float,
    speed: float,
    acceleration: float,
    force: float,
    pressure: float,
) -> None:
    f = similitude(name)
    found = (f.length, f.time, f.density, f.factor("m/s"), f.factor("m/s^2"), f.factor("N"), f.factor("Pa"))
    assert found == pytest.approx((length, time, density, speed, acceleration, force, pressure), rel=1e-14)


def test_gravity_and_the_same_material_together_need_light_matter() -> None:
    """phi_a = 1 and phi_F = phi_l^2 hold together only with phi_rho = 1/phi_l."""
    both = Similitude(length=5.0, time=math.sqrt(5.0), density=1.0 / 5.0)
    assert both.factor("m/s^2") == pytest.approx(1.0, rel=1e-14)
    assert both.factor("Pa") == pytest.approx(1.0, rel=1e-14)
    for name in STRATEGIES:
        f = similitude(name)
        assert abs(f.factor("m/s^2") - 1) > 0.1 or abs(f.factor("Pa") - 1) > 0.1


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"strategy": "mmmu"}, "strategy: 'mmmu'; allowed: mmu, dlr, inrets; did you mean 'mmu'?"),
        ({"strategy": "dlr", "length": 0.0}, "length: 0.0; allowed: a factor full scale over model"),
        ({"strategy": "dlr", "time": -1.0}, "time: -1.0; allowed"),
        ({"strategy": "dlr", "density": math.nan}, "density: nan; allowed"),
    ],
)
def test_what_is_no_similitude_is_refused(arguments: dict[str, object], message: str) -> None:
    with pytest.raises(ConfigError) as caught:
        similitude(**arguments)  # type: ignore[arg-type]
    assert message in str(caught.value)
