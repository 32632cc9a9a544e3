"""A wheel held by its brake in `rollerrig control`: growth of its loop by estimator, and what is read off a run."""

from __future__ import annotations

import math

import numpy as np
import pytest

from rollerrig import load_case
from rollerrig.study.control import QUANTITIES, study_case
from rollerrig.study.loop_stability import (
    held_blocks,
    held_growth,
    held_jobs,
    held_numbers,
    held_ripple,
)
from rollerrig.study.report import Table
from rollerrig.study.runs.control import ESTIMATORS

CASE = study_case(load_case("adhesion_brake").with_changes({"contact.normal": "hertz"}), 5.0)


def test_each_estimator_has_a_line_and_a_case_without_brake_none() -> None:
    jobs = held_jobs(CASE)
    assert list(jobs) == [f"held wheel, {label}" for label in ESTIMATORS]
    assert held_jobs(CASE.with_changes({"brake": None, "slide_protection": None})) == {}
    assert held_numbers({}) is None


def test_the_loop_of_a_held_wheel_grows_with_some_estimators_and_has_none_with_exact_torque() -> None:
    rates = {kind: held_growth(CASE.with_changes({"rig_control.estimator.kind": kind}))[0]
             for kind in ("observer", "kalman", "filtered_derivative")}  # fmt: skip
    assert rates["kalman"] > 1.0
    assert rates["filtered_derivative"] < rates["observer"] < rates["kalman"]
    assert math.isnan(held_growth(CASE.with_changes({"rig_control.estimator": {"kind": "exact"}}))[0])


def test_the_run_of_the_worst_estimator_does_not_ring_and_stands_in_the_report() -> None:
    """Kalman filter: its linear loop would grow, with (D15) the drives are quiet."""
    name = "held wheel, kalman"
    work = held_jobs(CASE)[name]
    numbers = held_numbers({name: work.function(*work.arguments)})
    assert numbers is not None
    assert numbers["kalman"]["held_s"] > 3.0
    assert numbers["kalman"]["held_ripple_nm"] < 100.0
    assert QUANTITIES.unexplained({"held_wheel": numbers}) == []
    table = held_blocks(numbers, QUANTITIES)[1]
    assert isinstance(table, Table)
    assert len(table.rows[0]) == 1 + len(QUANTITIES.below("held_wheel"))


def test_ripple_is_that_of_the_last_time_in_which_all_wheels_stood() -> None:
    time = np.arange(0.0, 10.0, 2e-3)
    rolling = np.where(time[:, None] > [4.0, 5.0], 0.0, 20.0)
    torque = np.where(time < 5.4, 1e4, 100.0) * np.sin(2.0 * math.pi * 20.0 * time)
    found = held_ripple(time, rolling, np.full_like(time, 25.0), torque[:, None], CASE)
    assert found == pytest.approx((5.0, 100.0 / math.sqrt(2.0)), rel=0.02)
    never = held_ripple(time, rolling + 20.0, np.full_like(time, 25.0), torque[:, None], CASE)
    assert never[0] == 0.0
    assert math.isnan(never[1])
