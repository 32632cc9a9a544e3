"""What is read off a run: closed forms, equilibrium, mirror images, energy."""

from __future__ import annotations

import doctest
import importlib
import math
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

import rollerrig as rr
from catalogued import profile_table
from rollerrig.analysis.assessment import accelerations, assess, limits, ride, table
from rollerrig.analysis.signals import low_pass
from rollerrig.analysis.wheel_rail_forces import (
    filtered,
    prudhomme_limit,
    statistics,
    wheel_forces,
)
from rollerrig.assembly.model import assemble
from rollerrig.profiles import flange_angle
from rollerrig.track import nadal_limit

GRAVITY = 9.81


def bogie(side: float = 1.0) -> xr.Dataset:
    """A bogie on track after a push to the left, or its mirror image."""
    push = [
        {"body": "wheelset_1", "lateral": 3e-3 * side, "yaw": 1e-3 * side},
        {"body": "front_frame", "roll": 2e-3 * side},
    ]
    changes = {"time.duration": "1 s", "time.output_step": "2 ms", "disturbance": push}
    return rr.simulate(rr.load_case("bogie_track").with_changes(changes))


@pytest.fixture(scope="module")
def run() -> xr.Dataset:
    return bogie()


@pytest.fixture(scope="module")
def read(run: xr.Dataset) -> xr.Dataset:
    return wheel_forces(run)


@pytest.mark.parametrize("case", ["wheelset_rollers", "bogie_track"])
def test_in_equilibrium_the_wheels_carry_the_weight_and_push_the_track_nowhere(case: str) -> None:
    changes = {"time.duration": "0.2 s", "disturbance": []}
    chosen = rr.load_case(case).with_changes(changes)
    read = wheel_forces(rr.simulate(chosen))
    weight = sum(assemble(chosen).axle_loads.values())
    total = read["wheel_load"].sum("wheel").to_numpy()
    # What is held above stays where it is by design: the contacts give way by 0.2 mm under springs of 2.4 MN/m an axle.
    assert total == pytest.approx(weight, rel=6e-3)
    assert float(read["static_wheel_load"].sum()) == pytest.approx(weight, rel=1e-12)
    assert np.abs(read["guiding_force_sum"]).max() < 1e-3 * weight
    assert (read["guiding_force"] > 0).all()  # cones push their rails apart


def test_a_free_vehicle_in_equilibrium_carries_its_weight_exactly() -> None:
    changes = {"vehicle.cut": "vehicle", "time.duration": "0.1 s", "disturbance": []}
    chosen = rr.load_case("bogie_track").with_changes(changes)
    read = wheel_forces(rr.simulate(chosen))
    weight = GRAVITY * sum(body.mass for body in chosen.vehicle.data.body)
    assert read["wheel_load"].sum("wheel").to_numpy() == pytest.approx(weight, rel=1e-6)
    assert np.abs(read["wheel_unloading"]).max() < 1e-3


def test_in_a_curve_the_track_bears_what_cant_does_not_balance() -> None:
    speed, radius, cant, base = 30.0, 600.0, 0.1, 1.5
    curve = {"kind": "curve", "length": "500 m", "radius": radius, "cant": cant}
    changes = {"vehicle.cut": "vehicle", "motion.speed_mps": speed, "time.duration": "0.2 s", "disturbance": []}
    track = {"support.segment": [curve], "support.cant_base": base}
    chosen = rr.load_case("bogie_track").with_changes({**changes, **track})
    run = rr.simulate(chosen)
    read = wheel_forces(run)
    mass = sum(body.mass for body in chosen.vehicle.data.body)
    tilt = math.asin(cant / base)
    inwards = speed**2 / radius
    excess = inwards * math.cos(tilt) - GRAVITY * math.sin(tilt)
    pressing = GRAVITY * math.cos(tilt) + inwards * math.sin(tilt)
    # Every body runs on its own radius and the wheelsets of a bogie pull in directions 4 mrad apart: 1e-4 of either part.
    assert read["guiding_force_sum"].sum("wheelset").to_numpy() == pytest.approx(-mass * excess, rel=5e-4)
    assert read["wheel_load"].sum("wheel").to_numpy() == pytest.approx(mass * pressing, rel=1e-5)
    outer = [wheel for wheel in read["wheel"].values if wheel.endswith("right")]
    assert (read["wheel_unloading"].sel(wheel=outer) < 0).all()
    felt = accelerations(run)["acceleration"].sel(point="car_body, centre", direction="lateral")
    assert float(felt[-1]) > excess  # the car body leans outwards on its springs


def test_signs_and_sums(run: xr.Dataset, read: xr.Dataset) -> None:
    """Y outwards is the negative of what pushes a left wheel to the left, and that of a right one as it is."""
    for number in (1, 2):
        left, right = (f"wheelset_{number}_{side}" for side in ("left", "right"))
        force = run["lateral_force"]
        assert np.array_equal(read["guiding_force"].sel(wheel=left), -force.sel(wheel=left))
        assert np.array_equal(read["guiding_force"].sel(wheel=right), force.sel(wheel=right))
        total = read["guiding_force_sum"].sel(wheelset=f"wheelset_{number}").to_numpy()
        assert total == pytest.approx(-(force.sel(wheel=left) + force.sel(wheel=right)).to_numpy(), abs=1e-9)


def test_a_mirrored_run_mirrors_the_forces(read: xr.Dataset) -> None:
    mirrored = wheel_forces(bogie(-1.0))
    swapped = {w: w.replace("left", "R").replace("right", "left").replace("R", "right") for w in read["wheel"].values}
    other = mirrored.sel(wheel=list(swapped.values())).assign_coords(wheel=read["wheel"])
    for name in ("guiding_force", "wheel_load", "derailment_quotient", "wear_number"):
        scale = float(np.abs(read[name]).max())
        assert other[name].to_numpy() == pytest.approx(read[name].to_numpy(), abs=1e-6 * scale)
    assert other["guiding_force_sum"].to_numpy() == pytest.approx(-read["guiding_force_sum"].to_numpy(), abs=1e-3)


def test_the_wear_number_is_the_creep_power_over_the_speed(run: xr.Dataset, read: xr.Dataset) -> None:
    power = run["creep_power"] / run["rolling_speed"]
    largest = float(power.max())
    # Each patch is divided by its own rolling speed, the sum by their mean: they differ as the rolling radii, 1e-3.
    assert read["wear_number"].to_numpy() == pytest.approx(power.to_numpy(), abs=1e-3 * largest)
    heat = run["energy_dissipated_creep"]
    way = float(read["distance"][-1])
    per_metre = float(np.trapezoid(read["wear_number"].sum("wheel"), read["distance"])) / way
    # Trapezoids of 2 ms over what the integrator sums up in its own steps.
    assert per_metre == pytest.approx(float(heat[-1] - heat[0]) / way, rel=2e-3)


def test_nadal() -> None:
    angle, friction = math.radians(70.0), 0.3
    # On a flank at the angle δ a load Q and a side force Y just slide down: along it Q sin δ - Y cos δ = μ (Q cos δ + Y sin δ).
    limit = nadal_limit(angle, friction)
    assert math.sin(angle) - limit * math.cos(angle) == pytest.approx(
        friction * (math.cos(angle) + limit * math.sin(angle))
    )
    assert nadal_limit(angle, 0.0) == pytest.approx(math.tan(angle))
    assert math.isnan(nadal_limit(math.atan(0.05), 0.3))


def test_the_flange_of_s1002_is_as_steep_as_its_definition_says() -> None:
    wheel = profile_table("s1002", "wheel")
    # EN 13715's straight flank, 1.3 mm long; the spline swings by 2e-4 where the curvature of its arcs jumps.
    assert flange_angle(wheel) == pytest.approx(math.atan(2.747477419), abs=2e-4)


def test_prudhomme(read: xr.Dataset) -> None:
    assert prudhomme_limit(0.0) == 10e3
    assert prudhomme_limit(60e3, 0.85) == pytest.approx(0.85 * 50e3)
    load = float(read["static_wheel_load"][0])
    assert read["guiding_force_sum_limit"].to_numpy() == pytest.approx(10e3 + 2 * load / 3)


def test_statistics_of_a_known_distribution() -> None:
    ramp = np.linspace(-1.0, 3.0, 40001)[:, None] * [[1.0, np.nan]]
    values = xr.DataArray(ramp, {"wheel": ["a", "b"]}, ["time", "wheel"])
    found = statistics(values).sel(wheel="a")
    assert found.sel(statistic="quasi_static") == pytest.approx(1.0)
    assert found.sel(statistic="percentile_0_15") == pytest.approx(-1.0 + 4 * 0.0015)
    assert found.sel(statistic="percentile_99_85") == pytest.approx(3.0 - 4 * 0.0015)
    assert found.sel(statistic="rms") == pytest.approx(math.sqrt(28 / 12), rel=1e-4)  # mean square of the ramp
    assert found.sel(statistic="largest") == 3.0
    assert np.isnan(statistics(values).sel(wheel="b")).all()


def test_filters_keep_what_is_slow_and_say_what_they_did(read: xr.Dataset) -> None:
    slow = filtered(read)
    assert slow["wheel_load"].attrs["filter"] == "20 Hz"
    assert slow["guiding_force_sum"].attrs["filter"] == "20 Hz, mean over 2 m"
    assert float(slow["wheel_load"].mean()) == pytest.approx(float(read["wheel_load"].mean()), rel=1e-3)
    from_end = np.minimum(read["time"] - read["time"][0], read["time"][-1] - read["time"]).to_numpy()
    known = from_end >= 0.05  # a period of 20 Hz: before, what is filtered depends on how the run goes on
    assert (np.isfinite(slow["guiding_force"].to_numpy()).all(axis=1) == known).all()
    distance = read["distance"].to_numpy()
    ends = (distance < distance[known][0] + 0.99) | (distance > distance[known][-1] - 0.99)
    assert np.isnan(slow["derailment_quotient"].to_numpy()[ends]).all()
    assert np.isfinite(slow["derailment_quotient"].to_numpy()[~ends][5:-5]).all()
    quotient = slow["guiding_force"] / slow["wheel_load"]
    inside = slow["derailment_quotient"].dropna("time")
    assert float(np.abs(inside).max()) <= float(np.abs(quotient).max())


@pytest.mark.slow
def test_what_is_filtered_hangs_not_on_where_a_run_ends() -> None:
    """Of hunting, whose contacts vibrate: percentiles of Y were off by up to 8 %, of a frame's acceleration by 21 %."""
    case = rr.load_case("bogie_rollers_constant").with_changes({"motion.speed": "260 km/h", "time.duration": "4 s"})
    whole = rr.simulate(case)
    for function, name in ((lambda run: filtered(wheel_forces(run)), "guiding_force"), (_ride, "acceleration")):
        longer, worst = function(whole)[name], 0.0
        for end in np.linspace(2.8, 3.8, 40):
            shorter = function(whole.sel(time=slice(0.0, end)))[name]
            difference = np.abs(shorter - longer.sel(time=shorter["time"])).max("time")
            worst = max(worst, float((difference / np.abs(longer).max("time")).max()))
        assert worst < 4e-3


def _ride(run: xr.Dataset) -> xr.Dataset:
    return ride(accelerations(run))


def test_distance_is_the_way_run_on_track_and_on_rollers(run: xr.Dataset, read: xr.Dataset) -> None:
    assert read["distance"].to_numpy() == pytest.approx(
        float(run["speed"][0]) * run["time"].to_numpy(), rel=1e-9, abs=1e-9
    )
    rig = rr.simulate(rr.load_case("wheelset_rollers").with_changes({"time.duration": "0.1 s"}))
    assert float(wheel_forces(rig)["distance"][-1]) == pytest.approx(0.1 * float(rig["speed"][0]), rel=1e-3)


def test_measured_rails_need_not_be_there_any_more(tmp_path: Path) -> None:
    rails = tmp_path / "rails.csv"
    rows = [f"{s},{1e-4 * (s % 7)},0,0,0" for s in range(60)]
    rails.write_text("\n".join(["distance [m],alignment [m],vertical [m],cross_level [m],gauge [m]", *rows]))
    changes = {"support.irregularity": {"kind": "file", "path": str(rails)}, "time.duration": "0.1 s"}
    run = rr.simulate(rr.load_case("bogie_track").with_changes(changes))
    rails.unlink()
    assert np.isfinite(wheel_forces(run)["guiding_force"]).all()


def test_the_example_of_the_docstring_runs() -> None:
    results = doctest.testmod(importlib.import_module("rollerrig.analysis.wheel_rail_forces"))
    assert results.attempted > 5
    assert results.failed == 0


def test_a_run_that_cannot_be_filtered_is_read_off_unfiltered_and_says_so(run: xr.Dataset) -> None:
    dense = [str(name) for name in run.variables if str(name).startswith("reading_")]
    coarse = assess(run.drop_vars(dense).isel(time=slice(0, None, 15)))
    assert "with an output_step of at most 20 ms" in coarse.notes[0]
    assert "needs an output_step of at most 5 ms" in assess(run.drop_vars(dense).isel(time=slice(0, None, 5))).notes[0]
    assert {row.filter for row in table(coarse) if row.quantity != "lateral_acceleration"} >= {"none"}
    empty = table(assess(run.isel(time=slice(0))))
    assert all(math.isnan(value) for row in empty for value in row.statistics.values())


def test_every_row_has_its_limit(run: xr.Dataset) -> None:
    rows = table(assess(run))
    quotient = next(row for row in rows if row.quantity == "derailment_quotient")
    assert quotient.limit == 0.8  # below Nadal's 1.34
    assert 0.0 < quotient.part_of_limit < 0.2
    assert math.isnan(next(row for row in rows if row.quantity == "wheel_load").part_of_limit)
    assert [row.place for row in rows if row.quantity == "guiding_force_sum"] == ["wheelset_1", "wheelset_2"]


def with_sum(run: xr.Dataset, amplitude: float, frequency: float, duration: float = 4.0) -> xr.Dataset:
    """Forces of a run of 160 m whose first wheelset is pushed by a sine [N, Hz], read every 2 ms."""
    time = np.arange(0.0, duration, 2e-3)
    read = wheel_forces(run.drop_vars([str(n) for n in run.variables if str(n).startswith("reading_")]))
    long = read.isel(time=np.zeros(len(time), dtype=int)).assign_coords(time=time)
    long["distance"] = ("time", 40.0 * time, read["distance"].attrs)
    force = np.zeros((len(time), 2))
    force[:, 0] = 2e3 + amplitude * np.sin(2 * np.pi * frequency * time)
    long["guiding_force_sum"] = (("time", "wheelset"), force, read["guiding_force_sum"].attrs)
    return long


@pytest.mark.parametrize("frequency", [3.0, 4.0, 9.0])
def test_the_instability_criterion_of_a_sine_is_its_r_m_s(run: xr.Dataset, frequency: float) -> None:
    """EN 14363: r.m.s. over 100 m of what oscillates about the main frequency; its mean and slow changes do not count."""
    found = filtered(with_sum(run, 10e3, frequency))["guiding_force_sum_rms"]
    assert found.attrs["filter"].endswith(f"to {frequency + 2.0:.1f} Hz, r.m.s. over 100 m")
    inside = found.sel(wheelset="wheelset_1").dropna("time")
    assert 55 < float(inside["time"].size) * 2e-3 * 40.0 < 65  # 160 m less 50 m at either end
    assert inside.to_numpy() == pytest.approx(10e3 / math.sqrt(2.0), rel=0.03)  # the band takes 2 %, the ends ring
    assert float(found.sel(wheelset="wheelset_2").max()) < 1.0


def test_the_limit_of_instability_is_half_of_prud_homme_s(run: xr.Dataset) -> None:
    assessed = assess(run)
    assert "guiding_force_sum_rms" not in assessed.assessed  # 1 s is not 100 m
    assert any("instability criterion" in note for note in assessed.notes)
    found = limits(filtered(with_sum(run, 10e3, 4.0)), "guiding_force_sum_rms")
    wheel_load = float(assessed.forces["static_wheel_load"][0])
    assert found["wheelset_1"] == pytest.approx(0.5 * prudhomme_limit(wheel_load))


def test_a_wear_number_does_not_ring_below_zero(run: xr.Dataset) -> None:
    read = with_sum(run, 0.0, 4.0)
    pulse = np.zeros(read["wear_number"].shape)
    pulse[1000:1020] = 400.0
    read["wear_number"] = (read["wear_number"].dims, pulse, read["wear_number"].attrs)
    through = filtered(read)["wear_number"]
    assert float(through.min()) == 0.0
    assert float(low_pass(read["wear_number"], 20.0).min()) < -5.0
    assert through.attrs["filter"] == "20 Hz, not below 0"
