"""Rails that change along the track, or differ left and right: against tracks that are so everywhere, statics, and the mirror."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

import rollerrig as rr
from rollerrig.config import Case

STRAIGHT, RAMP = {"kind": "straight", "length": 10.0}, {"kind": "transition", "length": 20.0}
QUIET = {"disturbance": [], "motion.speed": "20 m/s", "time.duration": "9 s"}
WHEELSET = "wheelset_1"


def bogie() -> Case:
    return rr.load_case("bogie_track").with_changes(QUIET)


def changing(to: dict[str, object], length: float = 20.0) -> dict[str, object]:
    return {"support.segment": [STRAIGHT, {**RAMP, "length": length}, {**STRAIGHT, "length": 100.0, **to}]}


def at_end(run: xr.Dataset, name: str = "vertical", body: str = WHEELSET) -> float:
    return float(run[name].sel(body=body)[-1])


@pytest.mark.parametrize(
    ("segment", "everywhere"),
    [
        ({"gauge": "1447 mm"}, {"support.gauge": "1447 mm"}),
        ({"inclination": "1:20"}, {"support.profile": "uic60_benchmark_1_20"}),
        (
            {"gauge": "1442 mm", "inclination": "1:20"},
            {"support.gauge": "1442 mm", "support.profile": "uic60_benchmark_1_20"},
        ),
    ],
)
def test_beyond_the_transition_a_vehicle_runs_as_on_a_track_that_is_so_everywhere(
    segment: dict[str, object], everywhere: dict[str, object]
) -> None:
    before, behind, there = (
        rr.simulate(bogie().with_changes(change)) for change in ({}, changing(segment), everywhere)
    )
    # The springs settle to nanometres in the 7.5 s left.
    assert at_end(behind) == pytest.approx(at_end(there), abs=3e-9)
    assert abs(at_end(there) - at_end(before)) > 50e-6
    load = behind["vertical_force"].isel(time=-1).to_numpy()
    np.testing.assert_allclose(load, there["vertical_force"].isel(time=-1), rtol=6e-5)  # 3 nm under 1e9 N/m
    assert behind.attrs["energy_relative_residual"] < 1e-6


def test_over_a_slow_ramp_the_wheelset_stands_as_statics_has_it_at_each_gauge() -> None:
    """2 mm of widening per second: at every place the height of the wheels is that of a track of this gauge."""
    run = rr.simulate(bogie().with_changes({**changing({"gauge": "1443 mm"}, 60.0), "time.duration": "3.5 s"}))
    for distance in (25.0, 40.0, 55.0):
        now = run.isel(time=int(np.argmin(np.abs(run["distance"].to_numpy() - distance))))
        gauge = 1.435 + 2 * float(now["rail_lateral"].sel(wheel=f"{WHEELSET}_left"))
        assert 1.436 < gauge < 1.4425
        static = rr.simulate(bogie().with_changes({"support.gauge": gauge, "time.duration": "10 ms"}))
        height = float(static["vertical"].sel(body=WHEELSET)[0])
        # What is left is inertia and damping: the wheel sinks by 0.1 mm a second.
        assert float(now["vertical"].sel(body=WHEELSET)) == pytest.approx(height, abs=2e-6)


def test_the_same_head_named_for_the_right_changes_not_a_bit() -> None:
    case = rr.load_case("bogie_track").with_changes({"time.duration": "0.3 s"})
    plain, named = (
        rr.simulate(case.with_changes(change)) for change in ({}, {"support.right_profile": "uic60_benchmark_1_40"})
    )
    for name in plain.data_vars:
        np.testing.assert_array_equal(plain[name], named[name], err_msg=str(name))


@pytest.mark.parametrize("name", ["bogie_track", "bogie_rollers_constant"])
def test_heads_that_change_sides_mirror_the_motion(name: str) -> None:
    case = rr.load_case(name).with_changes(
        {"time.duration": "0.5 s", "disturbance": [{"body": WHEELSET, "lateral": 1e-3}]}
    )
    heads = ("en_60e1_1_20", "en_60e1_1_40")
    runs = [
        rr.simulate(
            case.with_changes(
                {
                    "support.profile": heads[side],
                    "support.right_profile": heads[1 - side],
                    "disturbance": [{"body": WHEELSET, "lateral": (-1) ** side * 1e-3}],
                }
            )
        )
        for side in (0, 1)
    ]
    size = float(np.abs(runs[0]["lateral"]).max())
    np.testing.assert_allclose(runs[0]["lateral"], -runs[1]["lateral"], atol=1e-9 * size)
    np.testing.assert_allclose(runs[0]["vertical"], runs[1]["vertical"], atol=1e-9 * size)
    assert float(np.abs(runs[0]["lateral"].sel(body=WHEELSET)[-100:]).mean()) > 1e-5  # it does not stand in the middle
    assert runs[0].attrs["energy_relative_residual"] < 1e-5


def on_arcs(radius: float, **more: object) -> Case:
    """The bogie with cones 1:20 on round rail heads: each wheel stands where the head has the slope of the cone."""
    arc = {"kind": "arc", "radius": radius}
    return bogie().with_changes(
        {"vehicle.wheel.profile": {"kind": "cone", "conicity": 0.05}, "support.profile": arc, **more}
    )


def test_between_two_heads_lies_the_head_of_the_mean_curvature() -> None:
    """Heads of 300 and 150 mm: half way z is that of 200 mm, on which the wheels stand 1/20^2 R / 2 higher than on a flat one."""
    worn = {"profile": {"kind": "arc", "radius": 0.15}}
    case = on_arcs(0.3, **changing(worn, 60.0), **{"time.duration": "4.5 s"})
    run = rr.simulate(case)
    place = run["distance"].to_numpy() + 1.28  # of the leading wheelset
    for distance, radius in ((5.0, 0.3), (40.0, 0.2), (85.0, 0.15)):
        height = float(run["vertical"].sel(body=WHEELSET)[int(np.argmin(np.abs(place - distance)))])
        static = rr.simulate(on_arcs(radius).with_changes({"time.duration": "10 ms"}))
        # 3 um/s of sinking; circles against the parabola between them: y^4 / (8 R^3) = 1e-8 m; 4 mm of the output step
        assert height == pytest.approx(float(static["vertical"].sel(body=WHEELSET)[0]), abs=1e-6), distance
    heights = run["vertical"].sel(body=WHEELSET)
    assert abs(float(heights[0] - heights[-1])) > 50e-6
    assert run.attrs["energy_relative_residual"] < 1e-6


@pytest.mark.parametrize(("name", "value"), [("profile", "en_60e1_1_20"), ("right_profile", "en_60e1_1_20")])
def test_beyond_the_transition_to_another_head_a_vehicle_runs_as_on_that_head(name: str, value: str) -> None:
    behind, there = (
        rr.simulate(bogie().with_changes({**change, "time.duration": "16 s"}))
        for change in (changing({name: value}), {f"support.{name}": value})
    )
    for direction in ("lateral", "vertical"):
        # The lateral motion has decayed to 1e-4 of 3 mm.
        assert at_end(behind, direction) == pytest.approx(at_end(there, direction), abs=1e-6)


def test_a_spot_comes_round_once_a_turn_and_lowers_the_wheels_by_its_depth() -> None:
    spot = {"start": 0.5, "length": 0.6, "ramp": 0.4, "depth": "0.2 mm"}
    case = rr.load_case("bogie_rollers_constant").with_changes(
        {"motion.speed": "2 m/s", "disturbance": [], "support.spot": spot, "time.duration": "3.2 s"}
    )
    run = rr.simulate(case)
    fallen = run["vertical"].sel(body=WHEELSET) - float(run["vertical"].sel(body=WHEELSET)[0])
    turn = 2 * np.pi * case.support.data.roller_radius  # type: ignore[union-attr]
    for distance, depth in ((0.4, 0.0), (1.2, -0.2e-3), (2.5, 0.0), (turn + 0.4, 0.0), (turn + 1.2, -0.2e-3)):
        now = fallen[int(np.argmin(np.abs(run["distance"].to_numpy() - distance)))]
        assert float(now) == pytest.approx(depth, abs=2e-6)
    left = rr.simulate(case.with_changes({"support.spot.sides": "left", "time.duration": "0.6 s"}))
    rolled = float(left["roll"].sel(body=WHEELSET)[-1])
    assert rolled == pytest.approx(-0.2e-3 / 1.5, rel=0.03)  # the left wheel is the lower one
    assert run.attrs["energy_relative_residual"] < 1e-5
