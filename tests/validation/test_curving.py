"""The whole vehicle in curves against statics: forces that vanish, and loads that move to the outer rail."""

from __future__ import annotations

import json
import math
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

import rollerrig as rr
from rollerrig.analysis.curving import curving_case
from rollerrig.assembly.model import assemble
from rollerrig.config import Case
from rollerrig.results import summarise
from rollerrig.simulation.starting_state import equilibrium_dataset
from rollerrig.track import equilibrium_speed, plane_acceleration

RADIUS, CANT, BASE = 600.0, 0.110, 1.5
NOMINAL_RADIUS = 0.46


def in_the_curve(speed: float, direction: str = "left") -> Case:
    """The catalogue's curve without an end: steady curving from the start."""
    curve = {"kind": "curve", "length": 200.0, "radius": RADIUS, "cant": CANT, "direction": direction}
    return rr.load_case("vehicle_curve").with_changes({"support.segment": [curve], "motion.speed_mps": speed})


def steady(speed: float, direction: str = "left") -> xr.Dataset:
    return equilibrium_dataset(assemble(in_the_curve(speed, direction))).isel(time=0)


def mass_of(case: Case) -> float:
    return sum(body.mass for body in case.vehicle.data.body)


def test_at_the_equilibrium_speed_the_sum_of_lateral_forces_vanishes() -> None:
    """1e-3 of the weight: the bodies of a long vehicle lie 0.1 % beside the line's own direction and cant."""
    speed = equilibrium_speed(1 / RADIUS, CANT, BASE, 9.81)
    found = steady(speed)
    weight = 9.81 * mass_of(in_the_curve(speed))
    assert abs(float(found["lateral_force"].sum())) < 1e-3 * weight
    # and yet each wheelset steers: the wheels of an axle push against each other, the bogies' fronts outward
    assert float(np.abs(found["lateral_force"]).max()) > 1e3


@pytest.mark.parametrize("speed_kmh", [40.0, 100.0, 120.0])
def test_what_the_cant_leaves_acts_on_the_rails(speed_kmh: float) -> None:
    """Sum of Y = m a in the plane of the track; sum of Q the normal part of weight and centrifugal force."""
    speed = speed_kmh / 3.6
    found = steady(speed)
    mass, phi = mass_of(in_the_curve(speed)), math.asin(CANT / BASE)
    left_over = plane_acceleration(speed, 1 / RADIUS, CANT, BASE, 9.81)
    normal = 9.81 * math.cos(phi) + speed**2 / RADIUS * math.sin(phi)
    assert float(found["lateral_force"].sum()) == pytest.approx(mass * left_over, rel=5e-3, abs=50.0)
    assert float(found["vertical_force"].sum()) == pytest.approx(mass * normal, rel=1e-3)


@pytest.mark.parametrize("speed_kmh", [74.9, 120.0])
def test_the_load_moves_to_the_outer_rail_by_statics(speed_kmh: float) -> None:
    """Moments about the tangent in the vehicle's middle: all bodies where they stand, all wheels where they touch.

    A displacement counts from the track at the body's own place, which lies x^2 / (2 R) beside the tangent. A
    contact lies as far below the top of the rail as its rolling radius is larger than the nominal one. What is left is less than
    what the rails give way, 1 mm, times Q.
    """
    speed = speed_kmh / 3.6
    case = in_the_curve(speed)
    found = steady(speed)
    left_over = plane_acceleration(speed, 1 / RADIUS, CANT, BASE, 9.81)
    phi = math.asin(CANT / BASE)
    normal = 9.81 * math.cos(phi) + speed**2 / RADIUS * math.sin(phi)
    model = assemble(case)

    def beside_the_tangent(body: str) -> float:
        return float(found["lateral"].sel(body=body)) + model.positions[body][0] ** 2 / (2 * RADIUS) * math.cos(phi)

    outward = carried = 0.0
    for body in case.vehicle.data.body:
        height = body.position[2] + float(found["vertical"].sel(body=body.name))
        outward += body.mass * (left_over * height - normal * beside_the_tangent(body.name))
    for wheel in model.wheels:
        at = found.sel(wheel=wheel.name)
        side = 1.0 if wheel.side == "left" else -1.0
        y = side * (0.75 + float(at["contact_abscissa"])) + beside_the_tangent(wheel.wheelset)
        radius = float(at["rolling_radius"]) - NOMINAL_RADIUS
        height = float(found["vertical"].sel(body=wheel.wheelset)) - radius
        carried += height * float(at["lateral_force"]) - y * float(at["vertical_force"])
    weight = float(found["vertical_force"].sum())
    assert carried == pytest.approx(outward, abs=0.75 * 5e-3 * weight)


def test_a_curve_to_the_right_is_the_mirror_image() -> None:
    left, right = steady(30.0), steady(30.0, "right")
    swapped = right["vertical_force"].to_numpy().reshape(-1, 2)[:, ::-1].ravel()
    np.testing.assert_allclose(left["vertical_force"], swapped, rtol=1e-9)
    rails = [name for name in left["body"].to_numpy() if name.startswith("rail_")]
    other = [name.replace("left", "?").replace("right", "left").replace("?", "right") for name in rails]
    assert len(rails) == 8
    for one, twin in ((rails, other), (left["body"].to_numpy()[:7], left["body"].to_numpy()[:7])):
        for name in ("lateral", "roll"):
            np.testing.assert_allclose(left[name].sel(body=one), -right[name].sel(body=twin).to_numpy(), atol=1e-12)


@pytest.mark.slow
def test_the_catalogue_s_vehicle_comes_through_its_curve() -> None:
    run = rr.simulate(rr.load_case("vehicle_curve"))
    assert run.attrs["status"] == "ok"
    assert run.attrs["energy_relative_residual"] < 1e-6
    assert float(run["vertical_force"].min()) > 20e3  # no wheel comes near to lifting
    # settled in the middle of the curve, and back in the middle of the track behind it
    middle = run.isel(time=int(np.argmin(np.abs(run["distance"].to_numpy() - 290.0))))
    settled = steady(100.0 / 3.6)
    total = float(settled["lateral_force"].sum())
    assert float(middle["lateral_force"].sum()) == pytest.approx(total, rel=0.05)
    np.testing.assert_allclose(run["lateral"].isel(time=-1), 0.0, atol=0.5e-3)


def test_a_vehicle_that_lifts_its_wheels_is_told_with_place_and_quotient() -> None:
    """Just below the speed at which statics overturns it, a short transition does the rest."""
    case = rr.load_case("vehicle_curve").with_changes(
        {
            "support.segment": [
                {"kind": "straight", "length": 20.0},
                {"kind": "transition", "length": 10.0},
                {"kind": "curve", "length": 200.0, "radius": 150.0, "direction": "right"},
            ],
            "motion.speed": "95 km/h",
            "support.foundation": None,
            "time.duration": "6 s",
            "contact.normal": "hertz",
        }
    )
    run = rr.simulate(case)
    assert run.attrs["status"] == "contact_lost"
    assert run.attrs["stopped_segment"] == "segment[2], a curve of radius 150 m to the right"
    assert 30.0 < run.attrs["stopped_at_m"] < 60.0
    assert run.attrs["stopped_quotient"] > 1.0
    message = run.attrs["status_message"]
    place = r"3\d\.\d+ m \(segment\[2\], a curve of radius 150 m to the right\), wheelset_1_right: "
    assert re.match(r"t = 1\.\d+ s, " + place, message)
    touch = r"It last touched at t = 1\.0\d* s: its profile \(s1002\) at S = 1\d\.\d mm, the rail \(UIC60 .*\) at y = -2\.\d mm, "
    assert re.search(touch + r"field side, contact angle 0 degrees, Y 0\.\d kN, Q 0\.\d kN", message)
    assert re.search(
        r"Largest unfiltered \|Y\|/Q of its wheelset in the 0\.5 s before: 1\.\d\d at wheelset_1_left\.$", message
    )
    assert run.sizes["time"] > 200  # what was computed is kept
    summary = summarise(run)
    assert summary["stopped_quotient"] == run.attrs["stopped_quotient"]
    assert summary["stopped_segment"] == run.attrs["stopped_segment"]


RIGID, FLEXIBLE = "rigid", "flexible"
ROADS = [
    (radius, deficiency) for radius in (150.0, 250.0, 300.0, 500.0, 1000.0) for deficiency in (-0.06, 0.0, 0.075, 0.15)
]
WAGON = Path(__file__).parents[1] / "python" / "two_axle_wagon.toml"


def on_a_curve(case: Case, radius: float, deficiency: float, friction: float, rails: str = RIGID) -> Case:
    """Out of the straight, through a transition, the curve and back."""
    cant = 0.1 if radius < 1000.0 or deficiency < 0.0 else 0.05
    speed = math.sqrt((cant + deficiency) * 9.81 * radius / BASE)
    transition = {"kind": "transition", "length": 60.0}
    curve = {"kind": "curve", "length": 120.0, "radius": radius, "cant": cant, "direction": "left"}
    segments = [
        {"kind": "straight", "length": 50.0},
        transition,
        curve,
        transition,
        {"kind": "straight", "length": 60.0},
    ]
    foundation = rr.load_case("vehicle_curve").with_changes({"support.use": "flexible_track"}).support.data.foundation
    changes = {
        "support.segment": segments,
        "support.foundation": foundation if rails == FLEXIBLE else None,
        "motion.speed_mps": speed,
        "time.duration": 320.0 / speed,
        "time.step": "1 ms" if rails == RIGID else "0.25 ms",
        "contact.friction.mu_0": friction,
    }
    return case.with_changes(changes)


def through_a_curve(case: Case, radius: float, deficiency: float, friction: float, rails: str = RIGID) -> xr.Dataset:
    """A run `on_a_curve` that comes to its end, and its energy closes."""
    run = rr.simulate(on_a_curve(case, radius, deficiency, friction, rails))
    assert run.attrs["status"] == "ok"
    assert run.attrs["energy_relative_residual"] < 1e-5
    return run


def sampled(curves: list[tuple[Any, ...]], sample: set[tuple[Any, ...]]) -> list[Any]:
    """All of them with --long, without it a sample."""
    return [curve if curve in sample else pytest.param(*curve, marks=pytest.mark.long) for curve in curves]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("radius", "deficiency", "friction"),
    sampled([(*road, mu) for road in ROADS for mu in (0.4, 0.1)], {(300.0, 0.075, 0.4), (150.0, 0.15, 0.1)}),
)
def test_the_coach_comes_through_curves_on_rigid_rails(radius: float, deficiency: float, friction: float) -> None:
    """Dry and lubricated: no wheel leaves the rail."""
    run = through_a_curve(rr.load_case("vehicle_curve"), radius, deficiency, friction)
    assert run.attrs["energy_relative_residual"] < 1e-6  # measured 2e-9 to 1.3e-7
    assert float(run["vertical_force"].min()) > 25e3  # of 54.5 kN; measured 28 to 44 kN


OTHERS = [
    (name, *road, mu, rails)
    for name in ("two_axle_wagon", "locomotive")
    for road in ROADS
    for mu in (0.4, 0.1)
    for rails in (RIGID, FLEXIBLE)
]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "radius", "deficiency", "friction", "rails"),
    sampled(OTHERS, {("two_axle_wagon", 300.0, 0.075, 0.4, RIGID), ("locomotive", 1000.0, 0.15, 0.1, RIGID)}),
)
def test_a_wagon_and_a_locomotive_come_through_curves(
    name: str, radius: float, deficiency: float, friction: float, rails: str
) -> None:
    """A wheelbase of 8 m under stiff springs and axles of 21 t, on rails that are rigid or give way."""
    run = through_a_curve(other_vehicle(name), radius, deficiency, friction, rails)
    assert lightest(run) > 0.4  # measured on rigid rails: wagon 0.47 to 0.86
    assert longest_loss(run) == 0.0


@pytest.mark.long
def test_dry_flange_friction_shakes_a_stiff_wagon_on_rigid_rails_alone() -> None:
    """Friction 0.5 in 150 m: an inner wheel that touches with tread and flange vibrates at 130 Hz on the contacts' springs.

    It leaves its rail for less than 1 ms, and steps of a quarter do not change that; on rails that give way it does not begin.
    """
    run = through_a_curve(other_vehicle("two_axle_wagon"), 150.0, -0.06, 0.5)
    assert lightest(run) < 0.1
    assert longest_loss(run) < 1e-3
    assert lightest(through_a_curve(other_vehicle("two_axle_wagon"), 150.0, -0.06, 0.5, FLEXIBLE)) > 0.4


@pytest.mark.long
def test_a_run_whose_wheels_hop_on_rigid_rails_says_so() -> None:
    """The locomotive in 300 m with 150 mm of cant deficiency and friction 0.5; on rails that give way its wheels stay down."""
    curve = (other_vehicle("locomotive"), 300.0, 0.15, 0.5)
    hopping = rr.simulate(on_a_curve(*curve).with_changes({"time.duration": "5.5 s"}))
    lost, *others = hopping.attrs["warnings"].splitlines()
    assert lost.startswith("wheels lost contact: wheelset_1_left without contact ")
    assert "flexible_track" in lost
    assert any("steps have an error above the tolerance" in other for other in others)
    calm = through_a_curve(*curve, FLEXIBLE)
    assert longest_loss(calm) == 0.0
    assert lightest(calm) > 0.5  # measured 0.58


def other_vehicle(name: str) -> Case:
    """The tutorial's wagon, or the catalogue's locomotive, whole and with nothing that acts on it."""
    case = curving_case(rr.load_case(WAGON if name == "two_axle_wagon" else "locomotive_traction"))
    method = {"time.method": "exponential_adams", "time.step": "1 ms", "time.output_step": "5 ms"}
    return case.with_changes({**method, "contact.creep": "table", "contact.friction": 0.3})


def lightest(run: xr.Dataset) -> float:
    """Least load of a wheel over its static one."""
    forces = rr.wheel_forces(run)
    return float((forces["wheel_load"] / forces["static_wheel_load"]).min())


def longest_loss(run: xr.Dataset) -> float:
    """Longest spell without contact [s]."""
    return max((loss["longest_s"] for loss in json.loads(run.attrs["contact_losses"])), default=0.0)
