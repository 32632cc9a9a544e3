"""Stability of real cases: what is computed agrees with itself, with runs and with closed forms."""

from __future__ import annotations

import math

import numpy as np
import pytest

from rollerrig.analysis import (
    HuntingSettings,
    Lineariser,
    growth_rate,
    hunting_run,
    linear_critical_speed,
    linearise,
    nonlinear_critical_speed,
    stability,
)
from rollerrig.analysis.contact_state import slow_wavelength
from rollerrig.analysis.stability import largest_growth_rate
from rollerrig.config import Case, load_case


@pytest.fixture(scope="module")
def bogie() -> Case:
    return load_case("bogie_rollers_constant")


@pytest.fixture(scope="module")
def modes(bogie):
    return stability(bogie, [180.0, 220.0, 240.0, 260.0])


def test_the_critical_speed_is_where_damping_vanishes(bogie, modes) -> None:
    critical = modes.attrs["linear_critical_speed_kmh"]
    assert 240 < critical < 260
    assert modes.attrs["linear_critical_mode"] == "hunting"
    assert largest_growth_rate(Lineariser(bogie), critical / 3.6) == pytest.approx(0.0, abs=1e-5)
    hunting = modes["growth_rate"].sel(mode="hunting").to_numpy()
    assert hunting[2] < 0 < hunting[3]


def test_frequency_and_damping_belong_to_the_eigenvalue(modes) -> None:
    value = modes["growth_rate"] + 1j * modes["angular_frequency"]
    assert np.allclose(modes["damping"], -value.real / np.abs(value))
    assert np.allclose(modes["frequency"], value.imag / (2 * np.pi))
    assert float(modes["shape_amplitude"].max()) == pytest.approx(1.0)
    assert np.allclose(modes["energy_share"].sum(["body", "direction"]), 1.0)


def test_no_mode_is_counted_twice_and_driven_rollers_have_none(bogie) -> None:
    linear = linearise(bogie, 60.0)
    values = np.linalg.eigvals(linear.matrix)
    assert not np.any(np.abs(values) < 1e-6), "a neutral eigenvalue is left"
    assert not any(body.startswith("roller") for body, _ in linear.rate_rows)


def test_a_run_grows_as_the_linear_model_says(bogie) -> None:
    """0.1 mm stays where the linear model holds; 280 km/h is above the critical speed."""
    run = hunting_run(
        (
            bogie,
            280 / 3.6,
            HuntingSettings(disturbance=1e-5, duration=1.5, absolute_tolerance=1e-10, relative_tolerance=1e-6),
        )
    )
    lateral = run.motion["lateral"].sel(body="front_frame")
    expected = largest_growth_rate(Lineariser(bogie), 280 / 3.6)
    # other modes have died out after 0.6 s; amplitude stays below 0.1 mm, where curvature of the profiles changes little
    measured = growth_rate(lateral.sel(time=slice(0.6, 1.5)), least_amplitude=1e-9)
    assert measured == pytest.approx(expected, rel=0.02)


def test_below_the_critical_speed_a_run_dies_out_and_above_it_goes_on(bogie) -> None:
    quick = HuntingSettings(duration=2.0)
    found = nonlinear_critical_speed(bogie, [100.0, 220.0], quick, tolerance_kmh=1000.0)
    assert [run.sustained for run in found.runs] == [False, True]
    assert 3.6 * found.dies_out == pytest.approx(100.0)
    assert 3.6 * found.goes_on == pytest.approx(220.0)
    limit_cycle = found.runs[1].ending
    assert 2e-3 < limit_cycle.amplitude < 6e-3  # within the flangeway
    assert 3.0 < limit_cycle.frequency < 7.0


def test_track_is_stable_to_a_higher_speed_than_rollers(bogie) -> None:
    speeds = [v / 3.6 for v in (200.0, 250.0, 300.0, 350.0)]
    rig = linear_critical_speed(bogie, speeds)
    track = linear_critical_speed(load_case("bogie_track"), speeds)
    assert rig is not None
    assert track is not None
    assert track.speed > rig.speed


def test_bad_speeds_are_refused(bogie) -> None:
    for speeds in ([], [0.0], [100.0, 80.0], [math.nan]):
        with pytest.raises(ValueError, match="speeds_kmh"):
            stability(bogie, speeds)


def test_a_vehicle_free_along_its_track_hunts_like_one_that_is_held() -> None:
    """It coasts against a rolling resistance of newtons, which is no equilibrium but changes no lateral mode."""
    free = load_case("bogie_track").with_changes({"vehicle.cut": "vehicle"})
    held = free.with_changes({"vehicle.body.car_body.locked": ["x"]})
    speed = 300 / 3.6  # where hunting is the least damped motion of several hertz
    modes = [np.linalg.eigvals(linearise(case, speed).matrix) for case in (free, held)]
    hunting = [max(m[(m.imag > 25) & (m.imag < 60)], key=lambda z: z.real) for m in modes]
    assert hunting[0] == pytest.approx(hunting[1], rel=1e-3)  # symmetric: lateral and longitudinal motion do not couple


@pytest.mark.parametrize("name", ["contact_benchmark_track", "contact_benchmark_rollers"])
def test_a_conical_wheelset_weaves_with_klingels_wavelength(name: str) -> None:
    """2 pi sqrt(r l0 / conicity): also on rollers, where a straight cone keeps its contact at one place of the roller."""
    conicity = 1 / 40
    case = load_case(name).with_changes({"vehicle.wheel.profile": {"kind": "cone", "conicity": conicity}})
    half_distance = 0.755  # where the rail has the slope of the cone
    expected = 2 * math.pi * math.sqrt(0.46 * half_distance / conicity)
    # the formula is the limit of small conicity; spin creepage and, on rollers, the tilt with yaw are left out of it
    assert slow_wavelength(Lineariser(case), 2.0) == pytest.approx(expected, rel=0.01)
