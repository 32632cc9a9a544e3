"""One starting state: that of `simulate`, of a plant and of an FMU, untouched or with parameters, is the same to the last bit."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import rollerrig as rr
from rollerrig import _core, load_case
from rollerrig.assembly.actuators import assemble_with_actuators
from rollerrig.assembly.model import assemble
from rollerrig.config import Case
from rollerrig.interfaces.plant import assembled_model
from rollerrig.simulation.run import prepare

CASES = sorted(path.stem for path in (Path(rr.__file__).parent / "catalog" / "cases").glob("*.toml"))
UNSEEN = ("rig_control.assumed.roller_inertia", "wheel_slip_control.wheel_radius", "brake.control_valve.volume")
"""Parameters that the equilibrium does not feel."""


def started(case: Case, **parameters: float) -> dict[str, float]:
    """Every output of a plant at its start; names of parameters with __ for the dot."""
    plant = _core.Plant(assembled_model(case))
    for name, value in parameters.items():
        index = plant.find(name.replace("__", "."))
        assert index >= 0, name
        plant.set_parameter(index, value)
    plant.start()
    outputs = [v.name for v in plant.variables if v.causality == "output"]
    return dict(zip(outputs, plant.values([plant.find(name) for name in outputs]), strict=True))


def assert_same_bits(first: dict[str, float], second: dict[str, float]) -> None:
    assert first.keys() == second.keys()
    np.testing.assert_array_equal(list(first.values()), list(second.values()))


@pytest.mark.parametrize("name", CASES)
def test_a_run_a_plant_and_a_changed_plant_start_alike(name: str) -> None:
    case = load_case(name)
    assembled = assembled_model(case)
    run = prepare(assemble_with_actuators(case) if case.sampled else assemble(case))
    np.testing.assert_array_equal(run.state, assembled.x0)
    again = _core.read_model(_core.write_model(assembled))  # with its disturbances
    found = _core.starting_state(again.model, again.t0, again.disturbances)
    assert found["found"] == "ok"
    np.testing.assert_array_equal(found["x"], assembled.x0)
    plant = _core.Plant(assembled)
    present = [v for v in plant.variables if v.causality == "parameter" and v.variability == "fixed"]
    own = {v.name: v.start for v in present}
    unseen = {one: 1.1 * own[one] for one in UNSEEN if one in own}
    for changed in (own, unseen):
        first, second = started(case), started(case, **changed)
        if changed is unseen and case.sampled and case.sensors.roller_torque is not None:
            for one in (first, second):  # of the flange's torque the estimate takes the assumed inertia's part
                assert [one.pop(key) for key in list(one) if ".estimated_" in key]
        assert_same_bits(first, second)


@pytest.mark.parametrize(
    ("name", "parameters", "changes"),
    [
        ("bogie_rollers_constant", {"rollers.radius": 0.9}, {"support.roller_radius": 0.9}),
        ("wheelset_rollers", {"rollers.radius": 0.5}, {"support.roller_radius": 0.5}),
        ("vehicle_rollers", {"*.friction.mu_0": 0.25}, {"contact.friction": 0.25}),
        ("bogie_track", {"*.friction.mu_0": 0.25}, {"contact.friction": 0.25}),
        ("vehicle_curve", {"*.friction.mu_0": 0.25}, {"contact.friction": 0.25}),
        (
            "bogie_rollers_traction",
            {"primary_1_left.x_stiffness": 2e7},
            {"vehicle.element.primary_1_left.x.stiffness": 2e7},
        ),
        ("adhesion_lateral", {"rollers.radius": 0.9}, {"support.roller_radius": 0.9}),
    ],
)
def test_a_plant_with_a_parameter_starts_as_the_case_with_that_number(
    name: str, parameters: dict[str, float], changes: dict[str, object]
) -> None:
    case = load_case(name)
    names = [v.name for v in _core.Plant(assembled_model(case)).variables if v.causality == "parameter"]
    given = {
        one: value
        for key, value in parameters.items()
        for one in (names if key.startswith("*") else [key])
        if one == key or (key.startswith("*") and one.endswith(key[1:]))
    }
    assert given
    changed = started(case, **given)
    assert_same_bits(changed, started(case.with_changes(changes)))
    assert changed != started(case)


@pytest.mark.slow
def test_a_wheelset_on_its_flange_starts_alike() -> None:
    flange = {"disturbance": [{"body": "wheelset_1", "lateral": "7.5 mm", "yaw": "2 mrad"}]}
    case = load_case("bogie_rollers_constant").with_changes(flange)
    changed = started(case, rollers__radius=0.9)
    assert_same_bits(changed, started(case.with_changes({"support.roller_radius": 0.9})))
    rest = started(case.with_changes({"disturbance": []}), rollers__radius=0.9)
    assert changed["wheelset_1.lateral"] - rest["wheelset_1.lateral"] == pytest.approx(7.5e-3, rel=1e-12)
    assert changed["wheelset_1.yaw"] - rest["wheelset_1.yaw"] == pytest.approx(2e-3, rel=1e-12)
