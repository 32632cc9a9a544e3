"""A case at another scale: every number with a dimension is scaled, and the ideal model is full scale again once mapped back."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from typing import Annotated, Any, get_args, get_origin

import numpy as np
import pytest
import xarray as xr
from pydantic import BaseModel

import rollerrig as rr
from rollerrig.analysis.critical_speed import scan_linear
from rollerrig.config import ConfigError, case_from_toml
from rollerrig.config.schema.adhesion import Adhesion
from rollerrig.config.schema.base import Table
from rollerrig.results import RunInfo
from rollerrig.similitude import STRATEGIES, factors_of, map_back, scale_case, similitude
from rollerrig.similitude.factors import exponents
from rollerrig.similitude.scale_case import SPECIAL, NoUnitError, own_quantity

NO_DIMENSION = ("window", "seed", "axles_per_relay_valve")
"""Whole numbers that count."""


OF_NO_CASE = ("rollerrig.config.schema.programme", "rollerrig.config.schema.plan", "rollerrig.config.schema.fit")
"""Their tables are no part of a case: nobody scales a test programme or the plan of a sweep or fit."""


def tables(root: type[BaseModel] = Table) -> Iterator[type[BaseModel]]:
    for table in root.__subclasses__():
        if table.__module__.startswith("rollerrig.") and table.__module__ not in OF_NO_CASE:
            yield table
            yield from tables(table)


@pytest.mark.parametrize("table", sorted(set(tables()), key=lambda t: t.__name__), ids=lambda t: t.__name__)
def test_every_number_of_the_configuration_says_how_it_scales(table: type[BaseModel]) -> None:
    """A new key with a bare number, or with a unit hidden in its description, fails here."""
    known = {(Adhesion, "blend"), *SPECIAL}
    for name, field in table.model_fields.items():
        where = f"{table.__name__}.{name}"
        units = units_of(Annotated[field.annotation, *field.metadata] if field.metadata else field.annotation, where)
        if field.annotation is int:
            assert name in NO_DIMENSION, f"{where}: a whole number with a dimension? use Quantity"
        hidden = "1" in units and re.search(r"\[(m|s|N|kg|Pa|J|Hz)\b[\],/ ^]", field.description or "")
        assert not hidden or any((c, name) in known for c in table.__mro__), (
            f"{where}: its unit stands in the description"
        )


def units_of(annotation: Any, where: str) -> list[str]:
    """Units of all numbers that a field may hold, tables of its own left out."""
    if annotation is float:
        raise NoUnitError(f"{where}: a number without a unit; annotate it with Quantity")
    unit = own_quantity(annotation)
    if unit is not None:
        exponents(unit)
        return [unit]
    if get_origin(annotation) is Annotated:
        return units_of(get_args(annotation)[0], where)
    return [unit for part in get_args(annotation) for unit in units_of(part, where)]


def test_a_number_without_a_unit_is_found() -> None:
    with pytest.raises(NoUnitError, match="without a unit"):
        units_of(tuple[float, ...] | None, "Sample.key")


def compare(full: xr.Dataset, mapped: xr.Dataset, tolerance: float) -> None:
    """All variables, each against its own largest value; what is zero but for round-off against the largest of its unit."""
    assert full.sizes == mapped.sizes
    largest: dict[str, float] = {}
    for name in full.data_vars:
        values = np.abs(np.nan_to_num(full[name].to_numpy().astype(float)))
        unit = str(full[name].attrs.get("units"))
        largest[unit] = max(largest.get(unit, 0.0), float(values.max(initial=0.0)))
    for name in full.data_vars:
        if name == "energy_residual":  # itself an error of integration
            continue
        a, b = full[name].to_numpy().astype(float), mapped[name].to_numpy().astype(float)
        assert np.array_equal(np.isnan(a), np.isnan(b)), name
        size = max(float(np.nanmax(np.abs(a), initial=0.0)), 1e-6 * largest[str(full[name].attrs.get("units"))])
        error = float(np.nanmax(np.abs(a - b), initial=0.0))
        assert error <= tolerance * size, f"{name}: {error / size:.2g}" if size else str(name)
    np.testing.assert_allclose(full["time"], mapped["time"], rtol=1e-12)


SAME_STEPS = {"time.method": "exponential_rk4", "time.step": "1 ms"}
"""Of a method that takes no decisions by its error, whose absolute tolerance has another weight in a model."""
BRAKE = {
    **SAME_STEPS,
    "time.duration": "4 s",
    "disturbance": [{"body": "wheelset_1", "lateral": "1 mm"}],  # else lateral motion is round-off
}
HUNTING = {
    "motion.speed": "260 km/h",
    "disturbance": [{"body": "wheelset_1", "lateral": "0.2 mm"}],
    "time.duration": "1.2 s",
    "time.output_step": "10 ms",
}


@pytest.mark.slow
@pytest.mark.parametrize("strategy", STRATEGIES)
@pytest.mark.parametrize(("name", "changes"), [("adhesion_brake", BRAKE), ("bogie_rollers_constant", HUNTING)])
def test_a_model_that_meets_all_requirements_is_full_scale_once_mapped_back(
    strategy: str, name: str, changes: dict[str, object]
) -> None:
    """With steps in proportion both runs make the same steps: what is left is round-off, and the tolerances of iterations
    that are absolute (virtual train). 1e-6 is what the project asks for."""
    case = rr.load_case(name).with_changes(changes)
    model = scale_case(case, similitude(strategy), strategy=strategy, keep=())
    run = rr.simulate(model)
    full = rr.simulate(case)
    assert full.attrs["status"] == run.attrs["status"] == "ok"
    if name == "adhesion_brake":
        assert float(full["dump_cycles"].max()) >= 1  # the slide protection is at work
    mapped = map_back(run)
    compare(full, mapped, 1e-6)
    assert not np.allclose(run["speed"], full["speed"]) or strategy == "inrets"  # mapping back did something
    assert mapped.attrs["stopped_at_s"] == pytest.approx(full.attrs["stopped_at_s"], rel=1e-12)


@pytest.mark.parametrize("strategy", STRATEGIES)
def test_linear_critical_speed_scales_with_speed(strategy: str) -> None:
    case = rr.load_case("bogie_rollers_constant")
    factors = similitude(strategy)
    model = scale_case(case, factors, strategy=strategy, keep=())
    speeds = [216.0, 252.0, 288.0]
    full = scan_linear(case, speeds).onset
    found = scan_linear(model, [v / factors.factor("m/s") for v in speeds]).onset
    assert full is not None
    assert found is not None
    # the root is found to 1e-4 km/h, of 250 km/h or, mmu, of 50 km/h: 2e-6; Brent's last step is far smaller
    assert found.speed * factors.factor("m/s") == pytest.approx(full.speed, rel=1e-6)
    assert found.frequency / factors.time == pytest.approx(full.frequency, rel=1e-6)


def test_modes_over_speed_are_mapped_back_with_their_attributes() -> None:
    case = rr.load_case("bogie_rollers_constant")
    model = scale_case(case, similitude("mmu"), strategy="mmu", keep=())
    full = rr.stability(case, [200, 240])
    mapped = map_back(rr.stability(model, [40, 48]))
    np.testing.assert_allclose(mapped["speed"], full["speed"], rtol=1e-12)
    np.testing.assert_allclose(mapped["frequency"], full["frequency"], rtol=1e-6)
    key = "linear_critical_speed_kmh"
    assert mapped.attrs[key] == pytest.approx(full.attrs[key], rel=1e-6)
    crossings = (json.loads(run.attrs["crossings"])[0]["speed_kmh"] for run in (mapped, full))
    assert next(crossings) == pytest.approx(next(crossings), rel=1e-6)


@pytest.mark.slow
def test_other_vehicles_supports_and_tables_scale_too() -> None:
    """Irregular rollers, a whole vehicle, recovery by cleaning, traction with wheel-slip control: 1 s each, one strategy."""
    for name, changes in (
        ("vehicle_rollers", {"time.method": "exponential_rk4", "time.step": "0.25 ms", "time.maximum_step": None}),
        ("adhesion_recovery", {**SAME_STEPS, "disturbance": [{"body": "wheelset_1", "lateral": "1 mm"}]}),
        ("adhesion_start", {**SAME_STEPS, "disturbance": [{"body": "wheelset_1", "lateral": "1 mm"}]}),
    ):
        case = rr.load_case(name).with_changes({**changes, "time.duration": "1 s"})
        model = scale_case(case, similitude("dlr"), strategy="dlr", keep=())
        compare(rr.simulate(case), map_back(rr.simulate(model)), 1e-6)


def test_what_is_kept_stays_and_the_rest_is_scaled() -> None:
    case = rr.load_case("adhesion_brake")
    model = scale_case(case, similitude("inrets"), strategy="inrets", keep=("gravity", "material", "clock", "drives"))
    assert model.gravity == case.gravity
    assert model.contact.material == case.contact.material
    assert model.time.sampling_step == case.time.sampling_step
    assert model.slide_protection is not None
    assert model.slide_protection.sample_time == 5e-3
    assert model.slide_protection.filter_time == pytest.approx(0.01)
    assert model.rig_control is not None
    assert model.rig_control.motor.bandwidth == 50.0
    assert model.rig_control.estimator.bandwidth == pytest.approx(80.0)
    assert model.vehicle.data.wheel.radius == pytest.approx(0.115)
    assert model.vehicle.data.wheel.profile.length_scale == 0.25
    assert model.vehicle.data.wheel.profile.step == 5e-5  # of the drawing
    assert model.support.data.roller_mass == pytest.approx(2980 / 64)  # type: ignore[union-attr]
    assert model.brake is not None
    assert model.brake.demand[-1] == pytest.approx((0.15, 3.8e5))


def test_the_model_is_an_ordinary_case() -> None:
    case = rr.load_case("adhesion_brake")
    model = scale_case(
        case,
        similitude("dlr"),
        strategy="dlr",
        changes={"traction.motor.bandwidth": "100 Hz", "brake.by_traction_motors": True},
    )
    assert case_from_toml(model.to_toml()) == model
    assert model.brake is not None
    assert model.brake.by_traction_motors
    assert model.similitude is not None
    assert model.similitude.case == "adhesion_brake"
    assert factors_of(model).length == 5.0


def test_mapped_back_the_metadata_show_what_was_kept() -> None:
    case = rr.load_case("bogie_rollers_constant")
    model = scale_case(case, similitude("inrets"), strategy="inrets").with_changes({"time.duration": "10 ms"})
    info = RunInfo.of(map_back(rr.simulate(model)))
    assert info.gravity == pytest.approx(9.81 / 4)
    assert info.wheel_radius == pytest.approx(0.46)
    assert info.roller_radius == pytest.approx(0.725)
    assert info.speed == pytest.approx(case.motion.speed)
    assert info.friction == case.contact.friction.mu_0
    body = next(body for body in case.vehicle.data.body if body.name == "front_frame")
    assert info.body("front_frame").position[2] == pytest.approx(body.position[2])
    assert info.scaled_from is not None
    assert info.scaled_from.case == case.name


@pytest.mark.parametrize(
    ("name", "keep", "message"),
    [
        ("bogie_track", (), "support: a track; allowed: rollers"),
        (
            "adhesion_brake",
            ("gravty",),
            "keep: 'gravty'; allowed: gravity, material, clock, drives; did you mean 'gravity'?",
        ),
    ],
)
def test_what_cannot_be_scaled_is_refused(name: str, keep: tuple[str, ...], message: str) -> None:
    with pytest.raises(ConfigError) as caught:
        scale_case(rr.load_case(name), similitude("dlr"), strategy="dlr", keep=keep)
    assert message in str(caught.value)


def test_a_model_is_not_scaled_again() -> None:
    model = scale_case(rr.load_case("adhesion_brake"), similitude("dlr"), strategy="dlr")
    with pytest.raises(ConfigError, match="a model of adhesion_brake already"):
        scale_case(model, similitude("dlr"), strategy="dlr")


def test_only_a_model_is_mapped_back() -> None:
    run = rr.simulate(rr.load_case("bogie_rollers_constant").with_changes({"time.duration": "10 ms"}))
    with pytest.raises(ConfigError, match="similitude: missing; needed: a case made by `rollerrig scale`"):
        map_back(run)


def test_samples_that_do_not_fit_a_kept_clock_are_refused_with_their_key() -> None:
    case = rr.load_case("adhesion_brake").with_changes({"slide_protection.sample_time": "3 ms"})
    model = scale_case(case, similitude("dlr"), strategy="dlr", keep=("clock",))
    assert model.time.sampling_step == 1e-3
    assert model.time.output_step == pytest.approx(4e-3)  # 10 ms / sqrt(5), on the grid


def test_a_model_with_rollers_smaller_than_its_patch_is_refused() -> None:
    rubber = {"name": "rubber", "young_modulus": "10 MPa", "poisson_ratio": 0.49}
    case = rr.load_case("bogie_rollers_constant")
    with pytest.raises(ConfigError) as caught:
        scale_case(case, similitude("mmu"), strategy="mmu", changes={"support.roller_radius": "1 mm"})
    assert "support.roller_radius: 1 mm; the patch between wheel and roller is about" in str(caught.value)
    with pytest.raises(ConfigError, match=r"radius: 92 mm; the patch .* allowed: up to 0.1 of the radius"):
        scale_case(case, similitude("mmu"), strategy="mmu", changes={"contact.material": rubber})
