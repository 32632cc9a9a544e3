"""Numbers of a model that a tool changes: the run is that of the case with these numbers, in equilibrium from its start."""

from __future__ import annotations

import numpy as np
import pytest

from rollerrig import _core, load_case
from rollerrig.config import Case
from rollerrig.interfaces.plant import assembled_model

OK = _core.status_codes["ok"]
TUNABLE = (
    *("slide_protection.", "wheel_slip_control."),
    *(f"rig_control.{law}." for law in ("estimator", "axle_torque", "feedback", "drive_command")),
)
WHEELS = [f"wheelset_{n}_{side}" for n in (1, 2) for side in ("left", "right")]


def plant_of(case: Case, **parameters: float) -> _core.Plant:
    """Begun, with some parameters; their names with __ for the dot."""
    plant = _core.Plant(assembled_model(case))
    for name, value in parameters.items():
        plant.set_parameter(plant.find(name.replace("__", ".")), value)
    assert plant.start() == OK
    return plant


def value(plant: _core.Plant, name: str) -> float:
    assert plant.find(name) >= 0, name
    return plant.get(plant.find(name))


@pytest.fixture(scope="module")
def bogie() -> Case:
    return load_case("bogie_rollers_constant").with_changes({"time.duration": "1 s"})


@pytest.mark.parametrize(
    "name", ["adhesion_brake", "adhesion_start", "adhesion_valves", "bogie_track", "vehicle_curve"]
)
def test_every_parameter_says_its_unit_limits_and_start(name: str) -> None:
    plant = _core.Plant(assembled_model(load_case(name)))
    parameters = [v for v in plant.variables if v.causality == "parameter"]
    assert len(parameters) > 50
    for v in parameters:
        assert v.unit, v.name
        assert v.description
        assert v.least <= v.start <= v.most, v.name
        assert v.variability == ("tunable" if v.name.startswith(TUNABLE) else "fixed"), v.name
        assert plant.get(plant.find(v.name)) == v.start


def test_every_number_of_a_controller_is_a_parameter() -> None:
    names = {v.name for v in _core.Plant(assembled_model(load_case("adhesion_brake"))).variables}
    law = load_case("adhesion_brake").slide_protection
    numbers = {name for name, number in law if isinstance(number, float) and name not in ("sample_time", "delay")}
    assert {f"slide_protection.{name}" for name in numbers} <= names


AIR = ("fill_rate", "vent_rate")
RESERVOIR = (
    *("fill_conductance", "vent_conductance", "charging_conductance", "critical_ratio", "relay_band", "opening_time"),
    *(
        "closing_time",
        "least_pulse",
        "reservoir_volume",
        "reservoir_pressure",
        "main_pipe_pressure",
        "reference_pressure",
    ),
)
VALVE = ("application_rate", "release_rate", "follow_rate", "ambient_pressure", "volume")
CONDITION = ("A", "B", "mu_0", "k_A", "k_S")
TRAIN = ("gradient", "gravity", "mass", "resistance_constant", "resistance_linear", "resistance_quadratic")
WHEELS_AND_ROLLERS = ("roller_inertia", "roller_radius", "wheel_radius", "wheelset_inertia")
NUMBERS: dict[str, dict[str, tuple[str, ...]]] = {
    "adhesion_brake": {
        "rollers": ("radius",),
        "wheelset_1_left.friction": ("mu_0",),
        "adhesion": ("recovery_constant",),
        "adhesion.degraded": CONDITION,
        "adhesion.recovered": CONDITION,
        "rig_control": ("largest", "locked_speed"),
        "rig_control.assumed": WHEELS_AND_ROLLERS,
        "rig_control.estimator": ("bandwidth", "damping_ratio"),
        "rig_control.axle_torque": ("bandwidth", "brake_friction"),
        "rig_control.feedback": ("bandwidth", "damping_ratio"),
        "rig_control.drive_command": ("ahead",),
        "rig_control.train": (*TRAIN, "wheel_radius", "wheelset_inertia"),
        "brake.control_valve": VALVE,
        "brake.air": AIR,
    },
    "adhesion_valves": {"brake.control_valve": VALVE, "brake.air": RESERVOIR},
    "adhesion_sanding": {"adhesion": ("sand_constant",), "adhesion.sanded": CONDITION},
    "adhesion_step": {"adhesion.piece_2": ("recovery_constant",), "adhesion.piece_2.degraded": CONDITION},
}
"""Parameters of shipped cases, but for bodies and elements, controllers' laws of [slide_protection] and the like."""


@pytest.mark.parametrize("name", NUMBERS)
def test_every_number_of_a_law_is_a_parameter(name: str) -> None:
    names = {v.name for v in _core.Plant(assembled_model(load_case(name))).variables if v.causality == "parameter"}
    assert {f"{owner}.{number}" for owner, numbers in NUMBERS[name].items() for number in numbers} <= names
    sand = {one for one in names if one.startswith("adhesion") and "sand" in one}
    assert bool(sand) == (name == "adhesion_sanding")  # no sand falls elsewhere: it would act on nothing


def test_numbers_that_a_case_may_leave_out_are_parameters_where_it_gives_them() -> None:
    changes: dict[str, object] = {
        "contact.gauge_face_friction": 0.15,
        "rig_control.estimator": {"kind": "kalman", "force_change": "1 kN", "torque_change": "500 N m"},
    }
    given, left_out = (
        {v.name: v.unit for v in _core.Plant(assembled_model(load_case("adhesion_brake").with_changes(c))).variables}
        for c in (changes, {"rig_control.estimator": "kalman"})
    )
    assert given.keys() - left_out.keys() == {
        "rig_control.estimator.force_change",
        "rig_control.estimator.torque_change",
        *(f"{wheel}.friction.gauge_face" for wheel in WHEELS),
    }
    assert given["rig_control.estimator.torque_change"] == "N m"


def test_numbers_of_the_pipes_are_parameters_where_the_air_has_them() -> None:
    case = load_case("adhesion_valves")
    names = {v.name for v in _core.Plant(assembled_model(case)).variables}
    piped = case.with_changes({"brake.air": {"kind": "reservoir", "pipe": {"length": "4 m"}}})
    given = {v.name: v.start for v in _core.Plant(assembled_model(piped)).variables if v.causality == "parameter"}
    assert {name for name in given if name not in names} == {
        f"brake.air.pipe.{number}" for number in ("length", "diameter", "relay_conductance")
    }
    narrow = pressure_after(plant_of(piped, brake__air__pipe__diameter=0.004), 1.0)
    assert narrow < 0.6 * pressure_after(plant_of(piped), 1.0)


def test_parameters_of_air_act_on_the_run() -> None:
    """In the first second the pressure rises as the control valve lets it, later it is what the conductance lets through."""
    case = load_case("adhesion_valves")
    given = plant_of(case)
    rate = value(given, "brake.control_valve.application_rate")
    slow = plant_of(case, brake__control_valve__application_rate=0.5 * rate)
    choked = plant_of(case, brake__air__fill_conductance=0.01 * value(given, "brake.air.fill_conductance"))
    full, half, little = (pressure_after(plant, 1.0) for plant in (given, slow, choked))
    assert 0.4 < half / full < 0.6
    assert little < 0.6 * full


def pressure_after(plant: _core.Plant, time: float) -> float:
    assert plant.advance(time) == OK
    return value(plant, "wheelset_1.cylinder_pressure")


def test_more_mass_stands_on_the_rollers_from_the_start(bogie: Case) -> None:
    given = plant_of(bogie)
    mass = value(given, "front_frame.mass")
    heavy = plant_of(bogie, front_frame__mass=mass + 1000.0)
    stand = [sum(value(plant, f"{wheel}.vertical_force") for wheel in WHEELS) for plant in (given, heavy)]
    assert 0.5 < (stand[1] - stand[0]) / (1000.0 * 9.81) < 1.0  # the car body is held and carries the rest
    for plant in (given, heavy):
        assert abs(value(plant, "front_frame.vertical_acceleration")) < 1e-4
    assert value(heavy, "front_frame.vertical") < value(given, "front_frame.vertical")


def test_a_radius_of_the_rollers_is_that_of_the_case(bogie: Case) -> None:
    radius = 0.9
    changed = plant_of(bogie, rollers__radius=radius)
    case = plant_of(bogie.with_changes({"support.roller_radius": radius}))
    for name in (
        "wheelset_1_left.vertical_force",
        "wheelset_1.vertical",
        "roller_1.pitch_rate",
        "wheelset_1_left.rolling_radius",
    ):
        assert value(changed, name) == pytest.approx(value(case, name), rel=1e-6), name
    for plant in (changed, case):
        assert plant.advance(0.2) == OK
    assert value(changed, "wheelset_1.lateral") == pytest.approx(value(case, "wheelset_1.lateral"), rel=1e-3, abs=1e-7)


def test_friction_is_that_of_the_case() -> None:
    base = load_case("bogie_rollers_traction")
    changed = plant_of(base, **{f"{wheel}__friction__mu_0": 0.2 for wheel in WHEELS})
    case = plant_of(base.with_changes({"contact.friction": 0.2}))
    for plant in (changed, case):
        assert plant.advance(0.3) == OK
    for name in ("wheelset_1.lateral", "wheelset_1_left.longitudinal_creep_force"):
        assert value(changed, name) == pytest.approx(value(case, name), rel=1e-4, abs=1e-8), name


def test_a_parameter_at_its_start_changes_no_bit(bogie: Case) -> None:
    given = plant_of(bogie)
    same = plant_of(bogie, front_frame__mass=value(given, "front_frame.mass"))
    every = [given.find(v.name) for v in given.variables]
    for plant in (given, same):
        plant.advance(0.1)
    np.testing.assert_array_equal(given.values(every), same.values(every))


def test_tunable_parameters_act_from_the_next_sample_on_and_fixed_ones_wait_for_the_start() -> None:
    case = load_case("adhesion_brake")
    plant, untouched = plant_of(case), plant_of(case)
    with pytest.raises(ValueError, match=r"front_frame\.mass is fixed in a run"):
        plant.set_parameter(plant.find("front_frame.mass"), 5000.0)
    with pytest.raises(ValueError, match="in its limits"):
        plant.set_parameter(plant.find("slide_protection.filter_time"), -1.0)
    for one in (plant, untouched):
        one.set_input(one.find("train.friction_change"), -0.5)
        one.advance(1.0)
    for name in ("vent_slip", "vent_slip_speed", "vent_deceleration"):
        plant.set_parameter(plant.find(f"slide_protection.{name}"), 1e3)  # it vents no more
    state = plant.save()
    for one in (plant, untouched):
        assert one.advance(5.0) == OK
    assert value(untouched, "wheelset_1.dump_cycles") > value(plant, "wheelset_1.dump_cycles")
    untouched.restore(state)  # with the parameters of the plant that was saved
    assert value(untouched, "slide_protection.vent_slip") == 1e3
    untouched.advance(5.0)
    assert value(untouched, "wheelset_1.dump_cycles") == value(plant, "wheelset_1.dump_cycles")


@pytest.mark.parametrize(
    ("change", "name", "number"),
    [
        ({}, "feedback.bandwidth", 12.0),
        ({"rig_control.feedback.proportional": 3e3}, "feedback.proportional", 9e3),
        ({}, "estimator.bandwidth", 30.0),
    ],
)
def test_gains_of_the_rig_act_as_from_the_start(change: dict[str, object], name: str, number: float) -> None:
    case = load_case("adhesion_brake").with_changes(change)
    before, after, untouched = (
        plant_of(case, **given) for given in ({f"rig_control__{name.replace('.', '__')}": number}, {}, {})
    )
    after.set_parameter(after.find(f"rig_control.{name}"), number)
    for one in (before, after, untouched):
        one.set_input(one.find("train.friction_change"), -0.5)
        one.advance(1.5)
    speeds = [value(one, "wheelset_1.axle_speed") for one in (before, after, untouched)]
    assert abs(speeds[0] - speeds[1]) < 0.01 * abs(
        speeds[1] - speeds[2]
    )  # but for the first sample, at the start itself


def test_a_kalman_filter_has_its_gain_from_the_start() -> None:
    plant = _core.Plant(assembled_model(load_case("adhesion_brake").with_changes({"rig_control.estimator": "kalman"})))
    assert {v.variability for v in plant.variables if v.name.startswith("rig_control.estimator.")} == {"fixed"}


def test_without_an_equilibrium_there_is_no_start(bogie: Case) -> None:
    plant = _core.Plant(assembled_model(bogie))
    plant.set_parameter(plant.find("front_frame.mass"), 1e12)
    with pytest.raises(ValueError, match="parameters: the model has no equilibrium"):
        plant.start()


def test_a_number_that_acts_on_nothing_is_no_parameter() -> None:
    """The car body of a bogie alone is held: its weight is in the springs' preload. Rollers on rigid bearings only spin."""
    plant = _core.Plant(assembled_model(load_case("adhesion_brake")))
    names = [v.name for v in plant.variables if v.causality == "parameter"]
    assert {"front_frame.mass", "front_frame.inertia_x", "wheelset_1.mass", "roller_1.inertia_y"} <= set(names)
    assert not [name for name in names if name.startswith("car_body.")]
    assert not {"roller_1.mass", "roller_1.inertia_x", "roller_1.inertia_z"} & set(names)
