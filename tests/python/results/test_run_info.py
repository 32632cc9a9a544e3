"""Metadata of a run: typed, the same after a file, refused where they are missing or of another version."""

from __future__ import annotations

import dataclasses
import json
from pathlib import Path

import h5netcdf
import pytest
import xarray as xr

import rollerrig as rr
from rollerrig.assembly.model import assemble
from rollerrig.results import ResultsError, RunInfo
from rollerrig.results.run_info import BodyInfo, LowerBody, describe


@pytest.fixture(scope="module")
def vehicle() -> RunInfo:
    return describe(assemble(rr.load_case("bogie_track").with_changes({"vehicle.cut": "vehicle"})))


def test_what_is_written_is_what_is_read(vehicle: RunInfo) -> None:
    again = RunInfo.of(xr.Dataset(attrs={"run_info": vehicle.to_json()}))
    assert again == vehicle
    assert isinstance(again.bodies[0], BodyInfo)
    assert isinstance(again.bodies[0].position, tuple)


def test_who_carries_whom(vehicle: RunInfo) -> None:
    car_body, frame = vehicle.body("car_body"), vehicle.body("front_frame")
    assert [below.body for below in car_body.lower_bodies] == ["front_frame", "rear_frame"]
    assert [below.body for below in frame.lower_bodies] == ["wheelset_1", "wheelset_2"]
    assert frame.lower_bodies[0] == LowerBody("wheelset_1", 0.46)
    assert [body.name for body in vehicle.sprung] == ["car_body", "front_frame", "rear_frame"]


def test_wheels_carry_the_whole_vehicle(vehicle: RunInfo) -> None:
    case = rr.load_case("bogie_track")
    weight = case.gravity * sum(body.mass for body in case.vehicle.data.body)
    assert 2 * sum(body.wheel_load or 0.0 for body in vehicle.wheelsets) == pytest.approx(weight, rel=1e-12)


def test_rollers_fixed_bodies_and_actuators_are_told_apart() -> None:
    info = describe(assemble(rr.load_case("adhesion_brake")))
    roles = {body.name: body.role for body in info.bodies}
    assert roles["roller_1"] == "roller"
    assert roles["wheelset_1"] == "wheelset"
    assert info.body("car_body").fixed
    assert "car_body" not in info.moving
    assert "roller_1" not in info.moving
    assert info.actuators == ("adhesion", "brake", "slide_protection", "rig_control")
    assert (info.support, info.roller_radius) == ("rig", 0.725)


def test_every_length_speed_and_load_is_mapped() -> None:
    info = describe(assemble(rr.load_case("bogie_rollers_constant")))
    mapped = info.mapped(lambda unit: {"m": 2.0, "m/s": 3.0, "m/s^2": 5.0, "N": 7.0}.get(unit, 1.0))
    assert mapped.wheel_radius == 2 * info.wheel_radius
    assert mapped.roller_radius == 2 * (info.roller_radius or 0.0)
    assert (mapped.speed, mapped.gravity) == (3 * info.speed, 5 * info.gravity)
    frame, before = mapped.body("front_frame"), info.body("front_frame")
    assert frame.position == tuple(2 * x for x in before.position)
    assert frame.lower_bodies[0].height == 2 * before.lower_bodies[0].height
    assert mapped.wheelsets[0].wheel_load == 7 * (info.wheelsets[0].wheel_load or 0.0)
    assert (mapped.friction, mapped.flange_angle) == (info.friction, info.flange_angle)


def test_results_without_metadata_or_of_another_version_are_refused(vehicle: RunInfo) -> None:
    with pytest.raises(ValueError, match="no attribute run_info"):
        RunInfo.of(xr.Dataset())
    text = json.dumps({k: v for k, v in json.loads(vehicle.to_json()).items() if k != "friction"})
    with pytest.raises(ValueError, match="results of another version of rollerrig: run the case again"):
        RunInfo.of(xr.Dataset(attrs={"run_info": text}))


def test_an_old_file_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "old.nc"
    with h5netcdf.File(path, "w") as file:
        file.attrs["rollerrig_version"] = "0.0.9"
    with pytest.raises(ResultsError, match=r"old.nc: results of another version \(rollerrig 0.0.9, format none\)"):
        rr.load_run(path)


def test_it_is_constant(vehicle: RunInfo) -> None:
    with pytest.raises(dataclasses.FrozenInstanceError):
        vehicle.friction = 0.1  # type: ignore[misc]
