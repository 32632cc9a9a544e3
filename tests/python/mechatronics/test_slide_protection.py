"""The two laws of slide protection, chosen by name; limits of the roller drives."""

from __future__ import annotations

import numpy as np
import pytest

from rollerrig import ConfigError, load_case, simulate
from rollerrig.cli.describe import actuator_lines
from rollerrig.config import case_from_toml


@pytest.mark.parametrize("kind", ["slip_and_deceleration", "threshold_table"])
def test_each_law_keeps_the_wheels_turning_and_knows_the_train_s_speed(kind: str) -> None:
    case = load_case("adhesion_brake").with_changes({"slide_protection": {"kind": kind}, "time.duration": "8 s"})
    assert case_from_toml(case.to_toml()) == case
    run = simulate(case)
    assert float(run["axle_speed"].min()) * 0.46 > 10.0, "no wheel locks"
    assert float(run["dump_cycles"].isel(time=-1).sum()) >= 4
    assert set(np.unique(run["valve"])) == {0.0, 1.0, 2.0}, "fill, hold and vent"
    error = run["reference_speed_error"]
    difference = abs(error - (run["reference_speed"] - run["train_speed"]))
    assert float(difference.max()) < 1e-5, "single precision of results"
    assert float(abs(error).max()) < 6.0, "3 s between releases, at 1.6 m/s^2 where the train slows at 0.6"


def test_both_laws_tell_the_studies_from_which_slip_they_fill_and_vent() -> None:
    protections = [
        load_case("adhesion_brake").with_changes({"slide_protection": {"kind": kind}}).slide_protection
        for kind in ("slip_and_deceleration", "threshold_table")
    ]
    assert [(p.fill_slip, p.vent_slip) for p in protections if p is not None] == [(0.06, 0.12), (0.05, 0.2)]


def test_the_laws_differ() -> None:
    case = load_case("adhesion_brake").with_changes({"time.duration": "4 s"})
    ours, table = (simulate(case.with_changes({"slide_protection": k})) for k in ({}, {"kind": "threshold_table"}))
    assert not np.array_equal(ours["valve"], table["valve"])


@pytest.mark.parametrize(
    ("protection", "message"),
    [
        ({"kind": "fuzzy"}, "slide_protection.kind: 'fuzzy'; allowed: "),
        (
            {"kind": "threshold_table", "slip_thresholds": [0.1]},
            "slide_protection.entries: allowed: 2 rows of 4 entries, one for each band between",
        ),
        (
            {"kind": "threshold_table", "acceleration_thresholds": [-1.0, -4.0, 0.5]},
            "slide_protection.acceleration_thresholds: allowed: ascending thresholds, each once",
        ),
        ({"kind": "threshold_table", "vent_slip": 0.1}, "slide_protection.vent_slip"),
    ],
)
def test_what_no_protection_has_is_refused_by_name(protection: dict[str, object], message: str) -> None:
    with pytest.raises(ConfigError) as caught:
        load_case("adhesion_brake").with_changes({"slide_protection": protection})
    text = str(caught.value)
    assert all(part in text for part in message.split(": allowed: ", 1)), text


def test_a_drive_gives_no_more_than_its_power_and_its_torque() -> None:
    limits = {"rig_control.motor.largest_power": 3e4, "rig_control.motor.largest_torque": 1500.0}
    case = load_case("adhesion_brake").with_changes({**limits, "time.duration": "3 s"})
    run = simulate(case)
    assert float(abs(run["roller_torque"]).max()) <= 1500.0 * (1 + 1e-6)
    # limited at each sample's speed, then followed with the loop's lag: a wheel's speed changes a little meanwhile
    assert float(abs(run["roller_power"]).max()) <= 3e4 * 1.05
    free = simulate(
        case.with_changes({"rig_control.motor.largest_power": None, "rig_control.motor.largest_torque": None})
    )
    assert float(abs(free["roller_power"]).max()) > 4e4
    assert float(abs(run["roller_power"] - run["roller_torque"] * run["roller_speed"]).max()) < 1e-6 * 3e4


def test_check_says_what_a_full_brake_asks_of_the_roller_drives() -> None:
    case = load_case("adhesion_brake")
    lines = actuator_lines(case.with_changes({"motion.speed": "300 km/h"}))
    assert any(
        "a full brake at 300 km/h asks for" in line and "they have 20 kN m and 1000 kW" in line for line in lines
    )
    limited = actuator_lines(case.with_changes({"rig_control.motor.largest_power": "500 kW"}))
    assert any("they have 20 kN m and 500 kW" in line for line in limited)
