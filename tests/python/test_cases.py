"""Cases made from cases: what each transformation changes, and that it changes nothing else."""

from __future__ import annotations

import pytest

from rollerrig import cases
from rollerrig.config import Case, ConfigError, Rig, Track, load_case

CONTROLLED = "adhesion_brake"
"""On free rollers, with adhesion, brake, slide protection and a controller of the rig."""


def differences(one: Case, other: Case) -> set[str]:
    return {key for key in Case.model_fields if getattr(one, key) != getattr(other, key)}


def test_on_track_keeps_head_gauge_speed_and_actuators() -> None:
    rig = load_case(CONTROLLED)
    track = cases.on_track(rig)
    assert differences(rig, track) == {"support", "motion", "rig_control"}
    assert isinstance(track.support.data, Track)
    for key in ("profile", "gauge", "gauge_depth"):
        assert getattr(track.support.data, key) == getattr(rig.support.data, key)
    assert track.motion.drive == "speed_controlled"
    assert track.motion.speed == rig.motion.speed
    assert track.brake == rig.brake
    assert track.rig_control is None
    assert cases.on_track(track) == track


def test_on_track_ends_the_assumption_of_pure_rolling() -> None:
    assert not cases.on_track(load_case(CONTROLLED).with_changes({"contact.pure_rolling": True})).contact.pure_rolling


def test_on_rig_of_a_track_has_its_head_and_the_radius_asked_for() -> None:
    track = load_case("bogie_track").with_changes({"support.gauge": "1433 mm"})
    rig = cases.on_rig(track, radius=2.0)
    assert isinstance(rig.support.data, Rig)
    assert rig.support.data.roller_radius == 2.0
    assert rig.support.data.gauge == 1.433
    assert differences(rig, track) == {"support"}


def test_on_rig_keeps_a_rig_but_for_the_radius() -> None:
    case = load_case("bogie_rollers_constant")
    assert cases.on_rig(case) == case
    assert cases.on_rig(case, 1.0) == case.with_changes({"support.roller_radius": 1.0})


@pytest.mark.parametrize(("part", "held"), [("leading_wheelset", False), ("leading_bogie", False), ("vehicle", True)])
def test_a_part_with_a_fixed_body_needs_no_coupler_rod(part: str, held: bool) -> None:
    support = cases.part_of(load_case("vehicle_rollers"), part).support.data
    assert isinstance(support, Rig)
    assert (support.restraint is not None) == held


def test_without_actuators_leaves_vehicle_support_and_drive() -> None:
    case = load_case(CONTROLLED)
    bare = cases.without_actuators(case)
    assert not bare.sampled
    assert bare.motion == case.motion
    assert differences(bare, case) <= {*cases.ACTUATORS, "contact"}
    plain = load_case("bogie_track")
    assert cases.without_actuators(plain) is plain


@pytest.mark.parametrize("name", [CONTROLLED, "bogie_rollers_ramp", "vehicle_curve", "vehicle_track_irregular"])
def test_at_speed_is_steady_and_smooth(name: str) -> None:
    steady = cases.at_speed(load_case(name), 20.0)
    assert steady.motion.speed == 20.0
    assert steady.motion.drive == "speed_controlled"
    assert steady.motion.speed_table is None
    assert not steady.sampled
    assert steady.support.data.irregularity is None
    assert len(getattr(steady.support.data, "segment", ())) <= 1
    assert cases.at_speed(steady) == steady


def test_at_speed_refuses_what_a_case_file_would() -> None:
    with pytest.raises(ConfigError, match=r"motion.speed"):
        cases.at_speed(load_case("bogie_track"), -1.0)


def test_leading_wheelset_is_the_foremost_of_the_part() -> None:
    case = load_case("bogie_track").with_changes({"vehicle.cut": "vehicle"})
    assert cases.leading_wheelset(case).name == "wheelset_1"
    assert [body.name for body in cases.wheelsets(case)] == [f"wheelset_{k}" for k in (1, 2, 3, 4)]
    assert len(cases.wheelsets(cases.part_of(case, "leading_bogie"))) == 2


def test_displaced_starts_from_one_offset_only() -> None:
    case = load_case("bogie_rollers_traction")
    moved = cases.displaced(case, 4e-3)
    assert [(d.body, d.lateral) for d in moved.disturbance] == [("wheelset_1", 4e-3)]
    assert moved.axle_torque == ()


def test_parts_are_restrained_along_the_track_once() -> None:
    def locked(case: Case) -> list[str]:
        return [b.name for b in case.vehicle.data.body if "x" in b.locked]

    free = {"vehicle.cut": "vehicle", "vehicle.body.car_body.locked": []}
    whole = cases.restrained_along_track(load_case("bogie_track").with_changes(free))
    assert locked(whole) == ["car_body"]
    assert cases.restrained_along_track(whole) is whole
    bogie = cases.part_of(whole, "leading_bogie")
    assert not locked(bogie)  # its car body is fixed
    assert cases.on_track(bogie).vehicle.cut == "leading_bogie"
    assert locked(cases.part_of(bogie, "vehicle")) == ["car_body"]
