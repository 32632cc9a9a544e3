"""Measures of a brake test that assessments rest on: oscillation of the drives, creep peak, valves that never move."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

import numpy as np
import pytest

from rollerrig import load_case, simulate
from rollerrig.analysis.slide_statistics import idle_valves, torque_ripple
from rollerrig.analysis.slide_statistics import test_record as record_of
from rollerrig.analysis.virtual_rail import creep_curve, patch_of, slipperiest_peak
from rollerrig.assembly.model import assemble
from rollerrig.cli.describe import actuator_lines
from rollerrig.results.summary import ATTRIBUTE, ContactLoss, contact_loss_warning
from rollerrig.study.runs.adhesion import keeps_contact


def test_an_oscillation_of_less_than_half_of_the_time_is_seen_and_its_spell_measured() -> None:
    time = np.arange(0.0, 20.0, 0.01)
    fast = 800.0 * np.sin(2.0 * np.pi * 25.0 * time)
    part = np.where((time >= 5.0) & (time < 9.0), fast, 0.0)  # a fifth of the time
    torque = np.stack([np.zeros_like(time), part], axis=1)
    ripple, spell, frequency = torque_ripple(time, torque, 100.0)
    assert ripple == pytest.approx(800.0 / math.sqrt(2.0), rel=0.03)  # the filter overshoots where it begins and ends
    assert spell == pytest.approx(4.0, abs=0.51)  # windows of 0.25 s, and the filter's ends
    assert frequency == pytest.approx(25.0, abs=1.0)  # resolution of one second
    broken = np.where((time >= 7.0) & (time < 7.5), 0.0, part)
    assert torque_ripple(time, broken[:, None], 100.0).spell == pytest.approx(2.0, abs=0.51)
    assert np.isnan(torque_ripple(time[:20], torque[:20])).all()


def test_the_peak_of_the_slipperiest_rail_is_that_of_its_creep_curve() -> None:
    case = load_case("adhesion_brake")
    patch = patch_of(assemble(case))
    slip, adhesion = slipperiest_peak(case, patch, case.motion.speed)
    around = slip * np.array([0.9, 0.99, 1.0, 1.01, 1.1])
    forces = creep_curve(case, patch, 0.08, around)[1]
    assert forces.max() <= adhesion * (1.0 + 1e-9)
    assert forces[2] == pytest.approx(adhesion, rel=1e-12)
    pieces = [{"distance": 50.0, "rail": "low"}, {"distance": 100.0, "rail": "wet"}]
    changing = case.with_changes({"adhesion.rail": "dry", "adhesion.piece": pieces})
    assert slipperiest_peak(changing, patch, case.motion.speed) == (slip, adhesion)
    assert slipperiest_peak(case.with_changes({"adhesion": None}), patch, 30.0)[0] == math.inf


def test_valves_that_a_fill_pulse_does_not_move_are_named_by_check() -> None:
    case = load_case("adhesion_valves")
    assert idle_valves(case) == []
    slow = case.with_changes({"brake.air.opening_time": "100 ms", "brake.air.closing_time": "100 ms"})
    (line,) = idle_valves(slow)
    assert line == "Dump valves never open in stepwise filling: 60 ms of fill, 100 ms until they open"
    assert line in actuator_lines(slow)
    assert idle_valves(slow.with_changes({"brake.air.least_pulse": "105 ms"})) == []
    assert idle_valves(load_case("adhesion_brake")) == []


def test_a_test_keeps_contact_exactly_where_its_run_does_not_warn_of_lost_contact() -> None:
    """Spells that are short each add up to more than a hundredth of the run: of each wheel, not of all together."""
    case = load_case("adhesion_brake").with_changes({"time.duration": "1 s", "contact.normal": "hertz"})
    run = simulate(case)
    for times, kept in (((0.008, 0.008), True), ((0.008, 0.012), False), ((0.012, 0.012), False)):
        losses = [ContactLoss("left", 1, 0.008, 0.008, 0.5, 1.0), ContactLoss("right", 2, times[1], times[0], 0.5, 1.0)]
        record = record_of(run.assign_attrs({ATTRIBUTE: json.dumps([asdict(loss) for loss in losses])}), case)
        assert keeps_contact(record) is kept
        assert (contact_loss_warning(losses, 1.0, on_rollers=True) == "") is kept


class Filling:
    """A protection of the user that does nothing."""

    sample_time = 5e-3

    def step(self, measurements: Mapping[str, Any]) -> dict[str, Any]:
        return {"valve": np.zeros(len(measurements["axle_speed"]))}


def test_a_protection_that_is_not_ours_has_no_reference_speed_and_no_error_of_it() -> None:
    case = load_case("adhesion_brake").with_changes({"time.duration": "1 s", "contact.normal": "hertz"})
    run = simulate(case)
    assert math.isfinite(record_of(run, case).measures["reference_speed_error_rms_mps"])
    foreign = simulate(case, controllers={"slide_protection": Filling()})
    assert np.isnan(foreign["reference_speed"]).all()
    assert np.isnan(foreign["reference_speed_error"]).all()
    measures = record_of(foreign, case).measures
    assert math.isnan(measures["reference_speed_error_rms_mps"])
    assert math.isnan(measures["reference_speed_error_largest_mps"])
    assert math.isnan(measures["odometer_error_m"])
    fast = run.assign(reference_speed_error=0.25 + 0.0 * run["reference_speed_error"])
    assert record_of(fast, case).measures["odometer_error_m"] == pytest.approx(0.25 * float(run["time"][-1]), rel=1e-9)
