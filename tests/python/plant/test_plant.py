"""A plant that other tools drive is the run of `simulate`, step by step."""

from __future__ import annotations

import math

import numpy as np
import pytest
import xarray as xr

from rollerrig import _core, load_case, simulate
from rollerrig.assembly.actuators import assemble_with_actuators
from rollerrig.assembly.train_axles import train_mass
from rollerrig.config import Case, ConfigError
from rollerrig.interfaces.plant import assembled_model
from rollerrig.simulation.mechatronics import wheelset_inertia

OK = _core.status_codes["ok"]


def braked(duration: str = "0.1 s", **changes: object) -> Case:
    return load_case("adhesion_brake").with_changes({"time.duration": duration, **changes})


def started(case: Case, *external: str) -> _core.Plant:
    plant = _core.Plant(assembled_model(case, external=external))
    assert plant.start() == OK
    return plant


def recorded(run: xr.Dataset) -> dict[str, np.ndarray]:
    """Output of a plant -> its course in a run; what stands per body, per axle and of the train."""
    found = {
        f"{body}.{name}": run[name].sel(body=body).values
        for body in run["body"].values
        for name, _, _ in _core.body_fields
    }
    for axle in run["axle"].values if "axle" in run.dims else ():
        found |= {f"{axle}.{name}": run[name].sel(axle=axle).values for name, _, _ in _core.axle_fields}
        found |= {f"train.{name.removeprefix('train_')}": run[name].values for name, _, _ in _core.train_fields}
    for wheel in run["wheel"].values:
        found |= {f"{wheel}.{name}": run[name].sel(wheel=wheel).values for name, _, _ in _core.wheel_fields}
        y, q = (found[f"{wheel}.{name}"] for name in ("lateral_force", "vertical_force"))
        found[f"{wheel}.derailment_quotient"] = y / q
    return found


@pytest.mark.parametrize("name", ["adhesion_brake", "bogie_track", "adhesion_recovery"])
def test_outputs_are_those_of_a_run_bit_for_bit(name: str) -> None:
    case = load_case(name).with_changes({"time.duration": "0.1 s"})
    run = simulate(case)
    plant, courses = started(case), recorded(run)
    indices = [plant.find(name) for name in courses]
    assert min(indices) >= 0
    for k, t in enumerate(run["time"].values):
        assert plant.advance(t) == OK
        assert plant.time == t
        expected = np.array([course[k] for course in courses.values()])
        np.testing.assert_array_equal(plant.values(indices), expected)


def test_steps_do_not_depend_on_the_communication_step() -> None:
    """A time between two sampling steps is that of the last one."""
    case = braked()
    often, seldom = started(case), started(case)
    for t in np.arange(0.0, 0.0501, 0.00037):
        often.advance(t)
    often.advance(0.05)
    seldom.advance(0.05)
    every = [seldom.find(variable.name) for variable in seldom.variables]
    np.testing.assert_array_equal(often.values(every), seldom.values(every))
    assert often.advance(0.0504) == OK
    assert often.time == pytest.approx(0.05, abs=1e-12)


def test_a_command_acts_after_its_delay_from_when_it_is_set() -> None:
    """Not from the next sample of the controller, every 5 ms, whose place it takes."""
    case = braked(**{"slide_protection.delay": "2 ms"})
    assert case.slide_protection.sample_time == 5e-3
    plant = started(case, "slide_protection")
    command, valve = (plant.find(f"wheelset_1.{name}") for name in ("valve_command", "valve"))
    plant.advance(0.006)
    plant.set_input(command, 2.0)
    seen = {}
    for step in range(7, 11):
        plant.advance(1e-3 * step)
        seen[step] = plant.values([valve])[0]
    assert seen == {7: 0.0, 8: 0.0, 9: 2.0, 10: 2.0}


def test_inputs_act_from_their_instant_on() -> None:
    case = braked("1 s")
    plant, untouched = started(case), started(case)
    demand = plant.find("wheelset_1.brake_demand")
    plant.advance(0.01), untouched.advance(0.01)
    plant.set_input(demand, 2e5)
    plant.advance(0.5), untouched.advance(0.5)
    braking, other = (plant.find(f"wheelset_{n}.cylinder_pressure") for n in (1, 2))
    assert plant.get(braking) > untouched.get(braking) + 1e4
    assert plant.get(other) == untouched.get(other)


def test_valves_are_inputs_where_the_controller_is_outside() -> None:
    """What the controller sees are outputs; its command of one instant acts after the controller's delay."""
    case = braked("1 s")
    plant = started(case, "slide_protection")
    valve = plant.find("wheelset_1.valve_command")
    assert plant.get(plant.find("slide_protection.wheelset_1.axle_speed")) == pytest.approx(120 / 3.6 / 0.46, rel=0.01)
    for wrong in (0.5, 3.0):
        with pytest.raises(ValueError, match=r"value of wheelset_1\.valve_command must be a whole number"):
            plant.set_input(valve, wrong)
    plant.set_input(valve, 2.0)
    plant.advance(0.9)
    assert plant.get(plant.find("wheelset_1.valve")) == 2.0
    assert plant.get(plant.find("wheelset_1.cylinder_pressure")) < plant.get(plant.find("wheelset_2.cylinder_pressure"))


def test_torques_of_a_model_without_sampled_blocks_are_inputs() -> None:
    """The same torque as the case's own table and as an input, from its instant on."""
    case = load_case("bogie_rollers_traction").with_changes({"time.duration": "0.2 s"})
    zero = [["0 s", 0.0], ["1 s", 0.0]]
    table, tables = (
        [["0 s", 0.0], ["0.1 s", 0.0], ["0.1000001 s", 1e3], ["1 s", 1e3]],
        ("axle_torque.0.table", "axle_torque.1.table"),
    )
    given, from_outside = (
        started(case.with_changes(dict.fromkeys(tables, table))),
        started(case.with_changes(dict.fromkeys(tables, zero))),
    )
    for plant in (given, from_outside):
        plant.advance(0.1)
    for n in (1, 2):
        from_outside.set_input(from_outside.find(f"wheelset_{n}.axle_torque"), 1e3)
    speeds = []
    for plant in (given, from_outside):
        plant.advance(0.2)
        assert plant.time == 0.2
        speeds.append(plant.get(plant.find("wheelset_1.pitch_rate")))
    assert speeds[0] == pytest.approx(speeds[1], rel=1e-6)
    assert from_outside.get(from_outside.find("run.energy_work_of_torque")) == pytest.approx(
        given.get(given.find("run.energy_work_of_torque")), rel=1e-4
    )


@pytest.mark.parametrize("name", ["adhesion_brake", "adhesion_train", "adhesion_sanding", "bogie_track"])
def test_going_on_from_a_saved_state_is_going_on(name: str) -> None:
    """In the middle of a slide, in the same plant and in another: every variable bit for bit."""
    case = load_case(name)
    plant = started(case)
    every = [plant.find(variable.name) for variable in plant.variables]
    begin = 1.2 if case.sampled else 0.1
    plant.advance(begin)
    state = plant.save()

    def course(of: _core.Plant) -> np.ndarray:
        times = begin + 0.01 * np.arange(1, 11)
        return np.array([of.values(every) for t in times if of.advance(t) == OK])

    expected = course(plant)
    assert expected.shape == (10, len(every))
    plant.restore(state)
    np.testing.assert_array_equal(course(plant), expected)
    other = _core.Plant(assembled_model(case))
    other.restore(state)
    np.testing.assert_array_equal(course(other), expected)
    with pytest.raises(ValueError, match="restore: state must be"):
        other.restore(state[:-1])


def test_less_friction_of_the_rail_lets_braked_wheels_slide() -> None:
    case = load_case("adhesion_brake").with_changes({"adhesion.rail": "dry"})
    dry, wet = started(case), started(case)
    wet.set_input(wet.find("train.friction_change"), -0.95)
    for plant in (dry, wet):
        plant.advance(4.0)
    assert abs(dry.get(dry.find("wheelset_1.virtual_force"))) > 2 * abs(wet.get(wet.find("wheelset_1.virtual_force")))
    slip = {p: p.get(p.find("wheelset_1.virtual_speed")) - p.get(p.find("train.speed")) / 0.46 for p in (dry, wet)}
    assert slip[wet] < -0.5 < slip[dry]


def test_friction_under_a_wheel_bounds_its_creep_force() -> None:
    """A torque beyond the friction slides the axle: the force is then the factor times friction times load."""
    case = load_case("bogie_rollers_traction")
    plant = started(case)
    for side in ("left", "right"):
        plant.set_input(plant.find(f"wheelset_1_{side}.friction_change"), -0.99)
    plant.set_input(plant.find("wheelset_1.axle_torque"), 3000.0)
    plant.advance(0.2)
    force, load = (
        plant.get(plant.find(f"wheelset_1_left.{name}")) for name in ("longitudinal_creep_force", "vertical_force")
    )
    assert force == pytest.approx(0.01 * case.contact.friction.mu_0 * load, rel=0.05)


def test_a_force_on_the_train_speeds_it_up() -> None:
    case = braked()
    plant, untouched = started(case), started(case)
    plant.set_input(plant.find("train.force"), 1e4)
    plant.advance(0.1), untouched.advance(0.1)
    gained = plant.get(plant.find("train.acceleration")) - untouched.get(untouched.find("train.acceleration"))
    model = assemble_with_actuators(case)
    turning = len(model.axles) * wheelset_inertia(model) / case.vehicle.data.wheel.radius**2  # axles that speed up too
    assert gained == pytest.approx(1e4 / (train_mass(model) + turning), rel=0.01)


def test_only_inputs_take_only_what_is_allowed() -> None:
    plant = started(braked())
    demand = plant.find("wheelset_1.brake_demand")
    for value in (math.nan, math.inf, 1e9):
        with pytest.raises(ValueError, match="brake_demand must be in its limits"):
            plant.set_input(demand, value)
    for index in (plant.find("wheelset_1.lateral"), -1, 10**6):
        with pytest.raises(ValueError, match="index must be that of an input"):
            plant.set_input(index, 0.0)
    assert math.isnan(plant.get(-1))
    assert plant.find("wheelset_1.nothing") == -1


def test_variables_have_names_units_and_descriptions() -> None:
    variables = started(braked()).variables
    assert len({v.name for v in variables}) == len(variables)
    assert all(v.unit and v.description and v.least < v.most for v in variables)
    found = {v.name: v.unit for v in variables}
    assert found["wheelset_1_left.vertical_force"] == "N"
    assert found["wheelset_1.cylinder_pressure"] == "Pa"
    assert found["train.speed"] == "m/s"


def test_a_controller_in_python_is_refused_by_name() -> None:
    case = braked(**{"slide_protection.user": "module:Class"})
    with pytest.raises(ConfigError, match=r"slide_protection\.user"):
        assembled_model(case)
    with pytest.raises(ConfigError, match="wheel_slip_control"):
        assembled_model(braked(), external=["wheel_slip_control"])
    assert started(case, "slide_protection").find("wheelset_1.valve_command") >= 0
