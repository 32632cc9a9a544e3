"""Stability of real cases: what is computed agrees with itself, with runs and with closed forms."""

from __future__ import annotations

import math

import numpy as np
import pytest

from rollerrig.analysis import modes as linear_modes
from rollerrig.analysis.control_loop import slow_wavelength
from rollerrig.analysis.critical_speed import bracket, scan_linear
from rollerrig.analysis.hunting import HuntingSettings, hunting_run
from rollerrig.analysis.mode_table import diverging, modes_over_speed, stability, zero_crossings
from rollerrig.analysis.modes import Lineariser, eigensystem, oscillates
from rollerrig.analysis.signals import half_waves
from rollerrig.config import Case, load_case
from rollerrig.study.jobs import job, run_rounds


def largest_growth_rate(lineariser: Lineariser, speed: float) -> float:
    """Largest real part of the oscillatory modes [1/s]."""
    values = eigensystem(lineariser.at(speed).matrix).values
    return float(values[oscillates(values)].real.max())


@pytest.fixture(scope="module")
def bogie() -> Case:
    return load_case("bogie_rollers_constant")


@pytest.fixture(scope="module")
def modes(bogie):
    return stability(bogie, [180.0, 220.0, 240.0, 260.0])


def test_the_critical_speed_is_where_damping_vanishes(bogie, modes) -> None:
    critical = modes.attrs["linear_critical_speed_kmh"]
    assert 215 < critical < 232
    assert modes.attrs["linear_critical_mode"] == "hunting"
    assert largest_growth_rate(Lineariser(bogie), critical / 3.6) == pytest.approx(0.0, abs=1e-5)
    hunting = modes["growth_rate"].sel(mode="hunting").to_numpy()
    assert hunting[0] < 0 < hunting[2]


def test_frequency_and_damping_belong_to_the_eigenvalue(modes) -> None:
    value = modes["growth_rate"] + 1j * modes["angular_frequency"]
    assert np.allclose(modes["damping"], -value.real / np.abs(value))
    assert np.allclose(modes["frequency"], value.imag / (2 * np.pi))
    assert float(modes["shape_amplitude"].max()) == pytest.approx(1.0)
    assert np.allclose(modes["energy_share"].sum(["body", "direction"]), 1.0)


def test_no_mode_is_counted_twice_and_driven_rollers_have_none(bogie) -> None:
    linear = Lineariser(bogie).at(60.0)
    values = np.linalg.eigvals(linear.matrix)
    assert not np.any(np.abs(values) < 1e-6), "a neutral eigenvalue is left"
    assert not any(body.startswith("roller") for body, _ in linear.rate_rows)


def test_a_run_grows_as_the_linear_model_says(bogie) -> None:
    """0.1 mm stays where the linear model holds; 250 km/h is above the critical speed."""
    run = hunting_run(
        (
            bogie,
            250 / 3.6,
            HuntingSettings(
                disturbance=1e-5, duration=1.5, absolute_tolerance=1e-10, relative_tolerance=1e-6, longest=1.5
            ),
        )
    )
    lateral = run.motion["lateral"].sel(body="front_frame")
    expected = largest_growth_rate(Lineariser(bogie), 250 / 3.6)
    # other modes have died out after 0.6 s; amplitude stays below 0.1 mm, where curvature of the profiles changes little
    late = lateral.sel(time=slice(0.6, 1.5))
    waves = half_waves(late["time"].to_numpy(), late.to_numpy(), 1e-9)
    measured = np.polyfit(waves.time, np.log(waves.amplitude), 1)[0]
    assert measured == pytest.approx(expected, rel=0.02)
    modes = stability(bogie, [250.0])
    frequency = modes["frequency"].sel(mode=modes.attrs["hunting_mode"]).item()
    assert 0.5 / float(np.mean(waves.duration)) == pytest.approx(frequency, rel=2e-3)


def test_below_the_critical_speed_a_run_dies_out_and_above_it_goes_on(bogie) -> None:
    quick = HuntingSettings(duration=2.0)
    found = bracket([hunting_run((bogie, v / 3.6, quick)) for v in (100.0, 250.0)], quick.disturbance)
    assert [run.persists for run in found.runs] == [False, True]
    assert 3.6 * found.decays == pytest.approx(100.0)
    assert 3.6 * found.persists == pytest.approx(250.0)
    limit_cycle = found.runs[1].final
    assert 2e-3 < limit_cycle.amplitude < 6e-3  # within the flangeway
    assert 3.0 < limit_cycle.frequency < 7.0


def test_track_is_stable_to_a_higher_speed_than_rollers(bogie) -> None:
    speeds = [200.0, 250.0, 300.0, 350.0]
    rig = scan_linear(bogie, speeds).onset
    track = scan_linear(load_case("bogie_track"), speeds).onset
    assert rig is not None
    assert track is not None
    assert track.speed > rig.speed


@pytest.mark.slow
def test_critical_speeds_of_many_cases_are_those_of_each(bogie) -> None:
    cases = {
        "0.46 m": bogie.with_changes({"support.roller_radius": 0.46}),
        "0.725 m": bogie,
        "10 m": bogie.with_changes({"support.roller_radius": 10.0}),
        "never": load_case("wheelset_rollers"),
    }
    jobs = {name: job(scan_linear, case, [60.0, 350.0]) for name, case in cases.items()}
    found = list(run_rounds(lambda _done: iter([jobs]), None, (1.0,), 2, None)[0].values())
    speeds = [scan.speed_kmh for scan in found if scan is not None]
    assert speeds[0] < speeds[1] < speeds[2]
    assert found[3].onset is None
    assert math.isnan(speeds[3])
    alone = scan_linear(bogie, [60.0, 350.0])
    assert alone.speed_kmh == speeds[1]  # the same to the last bit, on another process


def test_a_case_without_equilibrium_is_told_by_the_scan(bogie) -> None:
    torque = {"wheelset": "wheelset_1", "reacts_on": "none", "constant": 60_000.0}  # friction holds 0.46 m * 33 kN
    found = scan_linear(bogie.with_changes({"axle_torque": [torque]}), [60.0, 100.0])
    assert "no rolling equilibrium" in found.problem
    assert math.isnan(found.speed_kmh)


@pytest.mark.parametrize("kind", ["steel", "paper"])
def test_modes_over_speed_are_not_those_of_round_off(kind: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Overdamped motions become oscillations and meet each other: which is which is the same in matrices that differ by 1e-13."""
    chance, solve = np.random.default_rng(0), linear_modes.eigensystem
    changes = {"contact.material": kind, "contact.normal": "hertz", "contact.creep": "kalker_saturated"}
    case = load_case("bogie_track").with_changes({"vehicle.cut": "leading_bogie", **changes})
    speeds = [v / 3.6 for v in range(20, 401, 20)]
    exact = modes_over_speed(case, speeds)
    monkeypatch.setattr(
        linear_modes, "eigensystem", lambda a: solve(a * (1.0 + 1e-13 * chance.standard_normal(a.shape)))
    )
    for _ in range(4):
        found = modes_over_speed(case, speeds)
        assert found.names == exact.names
        assert np.abs(found.values - exact.values).max() < 1e-5 * np.abs(exact.values).max()


def test_all_crossings_are_told_with_their_modes() -> None:
    """The two bogies of a vehicle hunt in two ways, which begin to grow one after the other."""
    vehicle = load_case("bogie_rollers_constant").with_changes(
        {"vehicle.cut": "vehicle", "vehicle.body.car_body.locked": ["x"]}
    )
    modes = modes_over_speed(vehicle, [200 / 3.6, 300 / 3.6])
    found = zero_crossings(modes)
    assert [one.name for one in found] == ["hunting, bogies in phase", "hunting, bogies out of phase"]
    assert all(one.grows_above for one in found)
    for one in found:  # brentq's tolerance 1e-4 km/h times a slope of the growth rate well below 1 1/s per km/h
        values = np.linalg.eigvals(modes.lineariser.at(one.speed).matrix)
        assert np.min(np.abs(values - 2j * np.pi * one.frequency)) < 1e-4


def test_actuators_do_not_change_the_vehicles_own_stability(bogie) -> None:
    """A case with actuators has the modes of its vehicle on the same rollers."""
    braked = load_case("adhesion_brake").with_changes({"contact.pure_rolling": True})
    bare = bogie.with_changes(
        {
            "contact.creepage_regularisation_speed": braked.contact.creepage_regularisation_speed,
            "contact.creep": braked.contact.creep,
        }
    )
    own, plain = (stability(case, [180.0]) for case in (braked, bare))
    np.testing.assert_array_equal(own["damping"], plain["damping"])


def test_a_free_vehicle_rolls_off_its_rollers() -> None:
    """Nothing holds it on their tops: a motion along the track that grows without oscillating is told, and only then."""
    vehicle = load_case("bogie_rollers_constant").with_changes({"vehicle.cut": "vehicle"})
    (found,) = diverging(modes_over_speed(vehicle, [20.0]))
    assert "longitudinal" in str(found["name"])
    held = vehicle.with_changes({"vehicle.body.car_body.locked": ["x"]})
    assert diverging(modes_over_speed(held, [20.0])) == []


def test_a_warm_start_changes_no_mode(bogie) -> None:
    lineariser = Lineariser(bogie)
    lineariser.at(20.0)
    warm, cold = lineariser.at(60.0).matrix, Lineariser(bogie).at(60.0).matrix
    # equilibria agree to 1e-7 N, of stiffnesses around 1e9 N/m
    assert warm == pytest.approx(cold, rel=1e-7, abs=1e-6 * np.abs(cold).max())


def test_bad_speeds_are_refused(bogie) -> None:
    for speeds in ([], [0.0], [100.0, 80.0], [math.nan]):
        with pytest.raises(ValueError, match="speeds_kmh"):
            stability(bogie, speeds)


def test_a_vehicle_free_along_its_track_hunts_like_one_that_is_fixed() -> None:
    """It coasts against a rolling resistance of newtons, which is no equilibrium but changes no lateral mode."""
    free = load_case("bogie_track").with_changes({"vehicle.cut": "vehicle"})
    held = free.with_changes({"vehicle.body.car_body.locked": ["x"]})
    speed = 300 / 3.6  # where hunting is the least damped motion of several hertz
    modes = [np.linalg.eigvals(Lineariser(case).at(speed).matrix) for case in (free, held)]
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


def test_a_winding_bumpy_track_counts_as_it_begins() -> None:
    """Stability is that of a smooth track that goes on for ever as it begins."""
    plain = load_case("bogie_track")
    winding = plain.with_changes(
        {
            "support.segment": [
                {"kind": "straight", "length": 50.0},
                {"kind": "transition", "length": 50.0},
                {"kind": "curve", "length": 100.0, "radius": 800.0},
            ],
            "support.irregularity": {"kind": "ore_b176", "level": "high"},
        }
    )
    assert np.array_equal(Lineariser(winding).at(60.0).matrix, Lineariser(plain).at(60.0).matrix)


def test_without_dampers_the_bogie_bounces_undamped_at_its_natural_frequency(bogie) -> None:
    primary = [f"primary_{number}_{side}" for number in (1, 2) for side in ("left", "right")]
    secondary = [f"secondary_vertical_damper_front_{side}" for side in ("left", "right")]
    nearly_none = {f"vehicle.element.{name}.z.damper.damping": 1e-3 for name in (*primary, *secondary)}
    modes = stability(bogie.with_changes(nearly_none), [100.0, 200.0]).sel(mode="bogie bounce")
    stiffness, mass = 4 * 1.22e6 + 2 * 430e3, 2615.0
    # the wheels' Hertz springs, a thousand times as stiff, stand in series
    assert modes["frequency"].to_numpy() == pytest.approx(math.sqrt(stiffness / mass) / (2 * math.pi), rel=3e-3)
    assert np.all(np.abs(modes["damping"].to_numpy()) < 1e-4)
