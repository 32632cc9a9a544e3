"""The rollers' speed as an input: an ideal drive that keeps it, and a drive with limits whose control goes to it."""

from __future__ import annotations

import numpy as np
import pytest

from rollerrig import _core, load_case
from rollerrig.config import Case
from rollerrig.interfaces.plant import assembled_model

OK = _core.status_codes["ok"]


def started(case: Case, *external: str) -> _core.Plant:
    plant = _core.Plant(assembled_model(case, external=external))
    assert plant.start() == OK
    return plant


def value(plant: _core.Plant, name: str) -> float:
    index = plant.find(name)
    assert index >= 0, name
    return plant.get(index)


# ---------------------------------------------------------------------------------------------------- ideal


@pytest.fixture(scope="module")
def steady() -> Case:
    return load_case("bogie_rollers_constant").with_changes({"time.duration": "2 s", "disturbance": []})


def roller_of(plant: _core.Plant) -> str:
    return next(v.name for v in plant.variables if "roller" in v.name and v.name.endswith(".pitch_rate"))


def test_rollers_go_to_the_speed_on_a_straight_line_and_stay_there(steady: Case) -> None:
    plant = started(steady)
    spin, start = roller_of(plant), steady.motion.speed
    radius = start / abs(value(plant, spin))
    command, rise = plant.find("run.speed_command"), plant.find("run.speed_rise_time")
    assert plant.get(command) == start
    plant.advance(0.1)
    plant.set_input(rise, 0.5)
    plant.set_input(command, start + 1.0)
    for t, gained in ((0.35, 0.5), (0.6, 1.0), (0.8, 1.0)):
        assert plant.advance(t) == OK
        # round-off of an integrated constant
        assert abs(value(plant, spin)) * radius == pytest.approx(start + gained, rel=1e-9)
    rows = [(0.0, start), (0.1, start), (0.6, start + 1.0), (1.0, start + 1.0)]
    table = steady.with_changes({"motion.speed_table": [[time, f"{speed} m/s"] for time, speed in rows]})
    by_table = started(table)
    by_table.advance(0.8)
    for name in ("wheelset_1.pitch_rate", "wheelset_1_left.vertical_force", "wheelset_2_right.longitudinal_creepage"):
        # two adaptive runs whose steps differ
        assert value(plant, name) == pytest.approx(value(by_table, name), rel=1e-4)
    assert by_table.find("run.speed_command") < 0  # the case's own table says it


def test_a_new_command_begins_where_the_last_one_has_come(steady: Case) -> None:
    """A staircase is followed as a low pass of first order does; its speed never jumps."""
    plant = started(steady)
    spin, start = roller_of(plant), steady.motion.speed
    radius = start / abs(value(plant, spin))
    command, speeds = plant.find("run.speed_command"), []
    for k in range(50):  # 2 m/s^2, rise time 0.1 s
        plant.set_input(command, start + 0.02 * k)
        plant.advance(0.01 * (k + 1))
        speeds.append(abs(value(plant, spin)) * radius)
    assert max(np.abs(np.diff(speeds))) <= 0.0201
    assert start + 0.02 * 50 - speeds[-1] == pytest.approx(2.0 * 0.1, rel=0.15)  # late by the rise time


def test_going_on_from_a_saved_state_in_a_ramp_is_going_on(steady: Case) -> None:
    plant, other = started(steady), _core.Plant(assembled_model(steady))
    plant.advance(0.05)
    plant.set_input(plant.find("run.speed_command"), steady.motion.speed + 0.5)
    plant.advance(0.1)
    state = plant.save()
    other.restore(state)
    every = [plant.find(v.name) for v in plant.variables]
    for t in (0.12, 0.2):
        assert plant.advance(t) == other.advance(t) == OK
        np.testing.assert_array_equal(plant.values(every), other.values(every))


# ---------------------------------------------------------------------------------------------------- a drive with limits


@pytest.fixture(scope="module")
def outside() -> Case:
    return load_case("adhesion_brake").with_changes({"time.duration": "4 s", "brake.demand": [[0.0, 0.0], [1.0, 0.0]]})


def ramped(plant: _core.Plant, rate: float, until: float, from_time: float = 0.5) -> tuple[np.ndarray, np.ndarray]:
    """Commanded and measured speed of the first roller on a ramp [rad/s]."""
    axles = [v.name.rpartition(".")[0] for v in plant.variables if v.name.endswith(".roller_speed_command")]
    first = value(plant, f"{axles[0]}.roller_speed_command")
    for axle in axles:
        plant.set_input(plant.find(f"{axle}.roller_speed_control"), 1.0)
    asked, found = [], []
    for t in np.arange(0.0, until, 0.005):
        wanted = first + rate * max(0.0, t - from_time)
        for axle in axles:
            plant.set_input(plant.find(f"{axle}.roller_speed_command"), wanted)
        assert plant.advance(t + 0.005) == OK
        asked.append(wanted)
        found.append(value(plant, f"{axles[0]}.roller_speed"))
    return np.array(asked), np.array(found)


def test_a_drive_follows_a_ramp_of_speed(outside: Case) -> None:
    plant = started(outside, "rig_control")
    asked, found = ramped(plant, 2.0, 3.0)
    assert asked[-1] - asked[0] == pytest.approx(5.0, rel=0.01)
    # behind a ramp an integral action leaves no error; sample, delay and lag of the torque loop are some 30 ms
    assert found[-1] == pytest.approx(asked[-1], abs=2.0 * 0.05)
    assert np.ptp(found[:90]) < 0.05  # it held the speed before


def test_a_drive_goes_no_faster_than_its_torque_allows(outside: Case) -> None:
    least = started(outside.with_changes({"rig_control.motor.largest_torque": "200 N m"}), "rig_control")
    asked, found = ramped(least, 20.0, 1.5)
    assert asked[-1] - found[-1] > 5.0
    assert abs(value(least, "wheelset_1.roller_torque")) <= 200.0 * (1 + 1e-9)


def test_without_speed_control_the_command_is_a_torque(outside: Case) -> None:
    """As before: a speed is asked for, but nothing goes to it; the torque asked for acts, and beside speed control too."""
    plant, torque = started(outside, "rig_control"), "wheelset_1.roller_torque_command"
    plant.set_input(plant.find("wheelset_1.roller_speed_command"), 1.0)
    plant.set_input(plant.find(torque), 300.0)
    plant.advance(0.5)
    assert value(plant, "wheelset_1.roller_torque") == pytest.approx(300.0, rel=1e-6)


def test_a_rig_without_feedback_has_no_speed_control(outside: Case) -> None:
    plant = started(outside.with_changes({"rig_control.feedback": "none"}), "rig_control")
    assert plant.find("wheelset_1.roller_speed_command") < 0
    assert plant.find("wheelset_1.roller_torque_command") >= 0
