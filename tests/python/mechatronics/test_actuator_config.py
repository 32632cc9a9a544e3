"""Tables of actuators and controllers: what they refuse, and with which words."""

from __future__ import annotations

import pytest

from rollerrig import ConfigError, load_case
from rollerrig.cases import on_track
from rollerrig.config import case_from_toml
from rollerrig.simulation.controllers import COMMANDS


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        (
            {"adhesion.rail": {"friction": 1.6}},
            "adhesion.rail.friction.mu_0: 1.6; allowed: a number, from 0 to 1.5",
        ),
        ({"adhesion.rail": "soapy"}, "allowed: dry, eurosprinter, wet, low, very_low, or a table"),
        (
            {"adhesion.piece": [{"distance": "50 m", "rail": "dry"}, {"distance": "20 m", "rail": "low"}]},
            "pieces in ascending order",
        ),
        (
            {"adhesion.blend": "0.1 s"},
            "adhesion.blend: '0.1 s'; allowed: a number in m or a text with a unit like '460 mm', from 0 to 100000 m, as the "
            "pieces begin at a distance",
        ),
        (
            {"adhesion.piece": [{"time": "1 s", "rail": "dry"}], "adhesion.blend": "2 m"},
            "adhesion.blend: '2 m'; allowed: a number in s or a text with a unit like '10 ms', from 0 to 100000 s, as the pieces "
            "begin at a time",
        ),
        (
            {"adhesion.rail": {"friction": 0.1, "k_A": 0.3, "k_S": 0.4}},
            "adhesion.rail.k_S: 0.4; allowed: at most k_A, 0.3",
        ),
        (
            {"adhesion.piece": [{"distance": "50 m", "time": "1 s", "rail": "dry"}]},
            "each piece with `distance`, or each with `time`",
        ),
        (
            {"rig_control.motor.envelope": [[0, 1e4], [50, 1e4], [50, 5e3]]},
            "rig_control.motor.envelope: [[0, 10000.0], [50, 10000.0], [50, 5000.0]]; allowed: rows in ascending order"
            " of their first column, each once; 50 follows 50",
        ),
        (
            {"rig_control.motor.envelope": [[0, 1e4], [50, 1e4], [20, 5e3]]},
            "allowed: rows in ascending order of their first column, each once; 20 follows 50",
        ),
        (
            {"rig_control.motor.envelope": [[0, 1e4]]},
            "rig_control.motor.envelope: [[0, 10000.0]]; allowed: at least two rows",
        ),
        (
            {"traction": {"suspension": "axle"}},
            "traction.link: missing; needed, about 1 m, for suspension = 'axle'",
        ),
        ({"traction": {"link": "1 m"}}, "allowed only with suspension = 'axle'"),
        ({"rig_control.estimator.kind": "oracle"}, "rig_control.estimator.kind: 'oracle'; allowed: "),
        ({"sensors.roller_torque": {"noise": -1.0}}, "sensors.roller_torque.noise: -1"),
        (
            {"slide_protection.sample_time": "2.5 ms"},
            "slide_protection.sample_time: 2.5 ms; allowed: a multiple of time.sampling_step, 1 ms; the nearest is 2 ms",
        ),
        ({"rig_control.delay": "0.4 ms"}, "rig_control.delay: 0.4 ms; allowed: a multiple of time.sampling_step, 1 ms"),
        ({"time.output_step": "0.5 ms"}, "time.output_step: 0.5 ms; allowed: a multiple of time.sampling_step"),
        ({"time.sampling_step": "5 ms"}, "time.sampling_step: 5 ms; allowed: at most 2 ms"),
        ({"motion.drive": "speed_controlled"}, "motion.drive: 'speed_controlled'; allowed with [rig_control]: 'free'"),
        ({"brake.by_traction_motors": True}, "brake.by_traction_motors: true; needed: [traction]"),
        ({"wheel_slip_control": {}}, "wheel_slip_control: a table; allowed only with [traction]"),
        (
            {"brake.electrodynamic": {"on_slide": "slip_control"}},
            "brake.electrodynamic.on_slide: 'slip_control'; allowed with [wheel_slip_control]",
        ),
        ({"slide_protection.return_speed": "4 km/h"}, "slide_protection.return_speed: "),
        ({"rig_control": None}, "adhesion: a table; allowed on rollers with [rig_control]"),
        ({"brake.demand": [[0, 0], [1, -1e5]]}, "brake.demand"),
        ({"train.mass": "6 t"}, "train.mass: 6000 kg; allowed: at least what is under test, 6241 kg"),
        (
            {"train.mass": "100 t", "vehicle.cut": "vehicle"},
            "train.mass: 100000 kg; allowed where a body of the vehicle is fixed; 'vehicle' is the train itself",
        ),
        (
            {"rig_control.load_transfer": "dynamic"},
            "rig_control.load_transfer: 'dynamic'; allowed: 'quasi_static', 'none', or a list with a number in kg for each axle",
        ),
        (
            {"rig_control.load_transfer": [1.0]},
            "rig_control.load_transfer: [1.0]; allowed: 'quasi_static', 'none', or 2 n",
        ),
    ],
)
def test_what_does_not_fit_is_refused_with_key_and_reason(changes: dict[str, object], message: str) -> None:
    with pytest.raises(ConfigError) as caught:
        load_case("adhesion_brake").with_changes(changes)
    assert message in str(caught.value)


def test_reductions_of_polach_s_law_that_a_rail_replaces_are_refused_on_track() -> None:
    """On rollers they are those of the rollers; the same case on track has those of the rail alone."""
    wet = {"contact.creep": {"kind": "polach", "k_A": 0.3, "k_S": 0.1}}
    rig = load_case("adhesion_brake").with_changes(wet)
    assert on_track(rig).contact.creep == on_track(load_case("adhesion_brake")).contact.creep
    with pytest.raises(
        ConfigError, match=r"contact\.creep: k_A = 0\.3, k_S = 0\.1; allowed on track with \[adhesion\]: 1"
    ):
        load_case("eurosprinter_traction").with_changes(wet)


def test_a_blend_is_a_length_or_a_time_as_the_pieces() -> None:
    case = load_case("adhesion_brake")
    by_time = {"adhesion.piece": [{"time": "1 s", "rail": "dry"}], "adhesion.blend": "100 ms"}
    by_place = {"adhesion.piece": [{"distance": "1 m", "rail": "dry"}], "adhesion.blend": "5 mm"}
    for changes, value in ((by_time, 0.1), (by_place, 5e-3)):
        changed = case.with_changes(changes)
        assert changed.adhesion is not None
        assert changed.adhesion.blend == value
        assert case_from_toml(changed.to_toml()) == changed


@pytest.mark.parametrize(
    "name", ["adhesion_brake", "adhesion_start", "adhesion_step", "adhesion_recovery", "adhesion_valves"]
)
def test_a_case_with_actuators_survives_its_own_toml(name: str) -> None:
    case = load_case(name)
    assert case.sampled
    assert case_from_toml(case.to_toml()) == case


def test_every_role_has_a_table() -> None:
    assert set(COMMANDS) <= set(type(load_case("adhesion_brake")).model_fields)
