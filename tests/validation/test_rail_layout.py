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
    np.testing.assert_allclose(load, there["vertical_force"].isel(time=-1), rtol=1e-5)
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
