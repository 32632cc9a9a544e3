"""Derivatives of runs against Richardson-extrapolated central differences of whole runs: hunting, curving, traction."""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np
import pytest

import rollerrig as rr
from rollerrig.config import Case, ConfigError
from rollerrig.simulation import sensitivity as module
from rollerrig.simulation.sensitivity import Sensitivity, changed_case, changed_cases

FINE = {
    "time.relative_tolerance": 1e-9,
    "time.absolute_tolerance": 1e-12,
    "time.step": "0.2 ms",
    "time.output_step": "10 ms",
}
"""Steps of runs whose differences are good to about 1e-6."""
TOLERANCE = 1e-5
"""Over the largest derivative of the output."""


def of_whole_runs(case: Case, key: str, outputs: Sequence[str]) -> dict[str, np.ndarray]:
    """From four runs: central differences of 0.02 % and half of it, extrapolated; wider ones reach over knots of profiles."""
    value, _ = changed_cases(case, key)

    def difference(part: float) -> dict[str, np.ndarray]:
        above, below = (rr.simulate(changed_case(case, key, value * (1 + sign * part))) for sign in (1, -1))
        return {name: (above[name].values - below[name].values) / (2 * part * value) for name in outputs}

    wide, narrow = difference(2e-4), difference(1e-4)
    return {name: (4 * narrow[name] - wide[name]) / 3 for name in outputs}


def require_equal(case: Case, keys: Sequence[str], outputs: Sequence[str], tolerance: float = TOLERANCE) -> Sensitivity:
    found = rr.sensitivity(case, keys, outputs)
    for k, key in enumerate(keys):
        wanted = of_whole_runs(case, key, outputs)
        for name in outputs:
            off = np.abs(found.derivatives[name].values[k] - wanted[name]).max()
            assert off < tolerance * np.abs(wanted[name]).max(), (key, name, off / np.abs(wanted[name]).max())
    return found


@pytest.mark.slow
def test_hunting_on_rollers() -> None:
    case = rr.load_case("bogie_rollers_constant").with_changes({**FINE, "time.duration": "0.1 s"})
    require_equal(case, ["vehicle.element.primary_*.x.stiffness"], ["lateral", "yaw"])


@pytest.mark.slow
def test_numbers_of_every_kind() -> None:
    """A spring, a mass, friction, a radius, which enters by geometry, and the speed; until forces in contact jump."""
    case = rr.load_case("bogie_rollers_constant").with_changes({**FINE, "time.duration": "30 ms"})
    keys = [
        "vehicle.element.primary_*.x.stiffness",
        "vehicle.body.wheelset_*.mass",
        "contact.friction.mu_0",
        "support.roller_radius",
        "motion.speed",
    ]
    found = require_equal(case, keys, ["lateral", "yaw"])
    run = rr.simulate(case)
    assert np.array_equal(found.run["lateral"], run["lateral"]), "the run is that of simulate()"
    assert found.derivatives["lateral"].dims == ("parameter", "time", "body")
    assert list(found.derivatives["parameter"].values) == keys
    assert found.values == pytest.approx([31.391e6, 1813.0, 0.3, 0.725, 150 / 3.6])


@pytest.mark.slow
def test_normal_forces() -> None:
    """Stiffness of the contacts times a small difference of displacements: as exact as these, some 30 times as far off."""
    case = rr.load_case("bogie_rollers_constant").with_changes({**FINE, "time.duration": "25 ms"})
    keys = ["vehicle.element.primary_*.x.stiffness", "vehicle.body.wheelset_*.mass", "contact.friction.mu_0"]
    require_equal(case, keys, ["normal_force", "lateral_force"], 3e-5)


@pytest.mark.parametrize(
    ("speed", "key"),
    [("140 km/h", "support.roller_radius"), ("155 km/h", "vehicle.element.primary_*.x.stiffness")],
)
def test_steps_that_suffice_for_a_run_are_made_finer(speed: str, key: str) -> None:
    """With the case's 2 ms and 1e-5 normal forces are off by 0.85 and 0.36, displacements by 7e-3 and 1.4e-4."""
    case = rr.load_case("bogie_rollers_constant").with_changes({"time.duration": "0.1 s", "motion.speed": speed})
    found = rr.sensitivity(case, [key], ["lateral", "normal_force"]).derivatives
    fine = {"time.step": "0.1 ms", "time.relative_tolerance": 1e-10, "time.absolute_tolerance": 1e-13}
    value, changed = changed_cases(
        case.with_changes(fine), key, 4e-6
    )  # narrow: contacts stay between knots of profiles
    above, below = (rr.simulate(one) for one in changed)
    for name, allowed in (("lateral", TOLERANCE), ("normal_force", 2e-3)):
        wanted = (above[name].values - below[name].values) / (8e-6 * value)
        off = np.abs(found[name].values[0] - wanted).max()
        assert off < allowed * np.abs(wanted).max(), (name, off / np.abs(wanted).max())


def test_finer_steps_are_whole_parts_of_the_sampling_step() -> None:
    case = rr.load_case("adhesion_brake").with_changes({"time.sampling_step": "0.5 ms"})
    assert module.with_fine_steps(case).time.step == pytest.approx(0.5e-3 / 3)
    assert module.with_fine_steps(case.with_changes({"time.method": "rodas4"})).time.step == pytest.approx(0.5e-3 / 3)
    assert module.with_fine_steps(rr.load_case("bogie_rollers_constant")).time.step == pytest.approx(0.2e-3)
    assert module.with_fine_steps(rr.load_case("wheelset_rollers")).time.step == pytest.approx(0.2e-3)


def test_differences_in_few_columns_shake_contacts_no_more_than_the_exact_jacobian_does() -> None:
    """Twelve columns take J in dual numbers, one the difference of slopes; with 3e-8 m in place of 1e-8 m it is 4e-5 off."""
    case = rr.load_case("bogie_rollers_constant").with_changes({**FINE, "time.duration": "20 ms"})
    key = "vehicle.element.primary_*.x.stiffness"
    one, many = (rr.sensitivity(case, [key] * count, ["normal_force"]).derivatives for count in (1, 12))
    of_one, of_many = (found["normal_force"].values[0] for found in (one, many))
    assert np.abs(of_one - of_many).max() < 2.5e-5 * np.abs(of_many).max()


@pytest.mark.slow
def test_curving() -> None:
    curve = {"kind": "curve", "length": 500.0, "radius": 600.0, "direction": "left", "cant": 0.11}
    changes = {"support.segment": [curve], "disturbance": [{"body": "wheelset_1", "lateral": "0.5 mm"}]}
    case = rr.load_case("vehicle_curve").with_changes({**FINE, **changes, "time.duration": "0.05 s"})
    require_equal(case, ["vehicle.element.primary_*.y.stiffness"], ["lateral", "yaw"])


@pytest.mark.slow
def test_traction_on_free_rollers() -> None:
    """A torque whose table has corners: what it is there is a number, too."""
    torque = {"wheelset": "wheelset_1", "table": [[0.0, 0.0], [0.03, 0.0], [0.08, 2000.0], [10.0, 2000.0]]}
    case = rr.load_case("bogie_rollers_traction").with_changes(
        {**FINE, "time.step": None, "axle_torque": [torque], "time.duration": "0.1 s"}
    )
    require_equal(case, ["axle_torque.0.table.2.1"], ["pitch_rate", "longitudinal_creepage"])


@pytest.mark.slow
def test_sampled_controllers_and_motors() -> None:
    changes = {"wheel_slip_control": None, "traction.demand": [[0.0, 0.0], [0.05, 5000.0], [10.0, 5000.0]]}
    case = rr.load_case("locomotive_traction").with_changes({**FINE, **changes, "time.duration": "0.1 s"})
    require_equal(
        case, ["traction.motor.bandwidth", "rig_control.estimator.bandwidth"], ["roller_torque", "train_speed"]
    )


def test_a_number_beside_the_contacts_is_as_if_they_were_looked_for(monkeypatch: pytest.MonkeyPatch) -> None:
    """Springs and masses are differenced under the contact forces of the run; here also with contacts of their own."""
    case = rr.load_case("bogie_rollers_constant").with_changes({"time.duration": "40 ms"})
    keys = ["vehicle.element.primary_*.x.stiffness", "vehicle.body.front_frame.mass"]
    beside = rr.sensitivity(case, keys, ["lateral"]).derivatives["lateral"]
    monkeypatch.setattr(module, "_BESIDE_CONTACTS", re.compile("(?!)"))
    with_contacts = rr.sensitivity(case, keys, ["lateral"]).derivatives["lateral"]
    off = np.abs(beside.values - with_contacts.values).max((1, 2)) / np.abs(beside.values).max((1, 2))
    assert (off < TOLERANCE).all(), off


def test_a_number_that_changes_nothing_has_no_derivative() -> None:
    case = rr.load_case("wheelset_rollers").with_changes({"time.duration": "20 ms"})
    found = rr.sensitivity(case, ["support.roller_inertia.1"], ["lateral"])
    assert not found.derivatives["lateral"].values.any()


@pytest.mark.parametrize(
    ("key", "message"),
    [
        ("vehicle.body.wheelset_1.weight", "vehicle.body.wheelset_1.weight: there is no such number"),
        ("vehicle.body.wheelset_*.kind", "vehicle.body.wheelset_*.kind: is no number"),
        ("vehicle.element.primary_*.*.stiffness", "stands for 1.22e+06, 3.884e+06, 3.1391e+07; allowed: keys of equal"),
        ("support.profile.inclination", ""),
        ("vehicle.body.front_frame.position.1", "is 0; allowed: a number that is not 0"),
    ],
)
def test_keys_that_are_no_numbers_are_refused(key: str, message: str) -> None:
    case = rr.load_case("bogie_rollers_constant")
    if not message:
        assert changed_cases(case, key)[0] == 0.025
        return
    with pytest.raises(ConfigError) as problem:
        changed_cases(case, key)
    assert message in str(problem.value)


def test_what_switches_is_refused_by_name() -> None:
    with pytest.raises(ConfigError, match="wheel_slip_control: switches, or counts"):
        rr.sensitivity("locomotive_traction", [], ["lateral"])
    encoder = rr.load_case("eurosprinter_traction").with_changes(
        {"sensors.vehicle": {"kind": "encoder", "counts": 100}}
    )
    with pytest.raises(ConfigError, match=r"sensors\.vehicle: switches, or counts"):
        rr.sensitivity(encoder, [], ["lateral"])


def test_an_unknown_output_is_refused() -> None:
    with pytest.raises(ValueError, match="outputs: 'latral'; did you mean 'lateral'"):
        rr.sensitivity("wheelset_rollers", ["contact.friction.mu_0"], ["latral"])
