"""Variants of a case from several starting points: names, what is done already, means with errors."""

from __future__ import annotations

import pytest

from rollerrig import load_case
from rollerrig.study.ensemble import means, recorded, start_jobs, start_name, started, starts
from rollerrig.study.jobs import job


def test_every_variant_runs_from_the_same_starts_and_a_longer_ensemble_goes_on() -> None:
    case = load_case("adhesion_brake")
    cases = {"a": case, "b": case.with_changes({"time.duration": 5.0})}
    jobs = start_jobs(cases, lambda one, _: job(recorded, one), 3)
    assert list(jobs) == [f"{name}, start {k}" for name in "ab" for k in (1, 2, 3)]
    speeds = [[jobs[start_name(name, k)].arguments[0].motion.speed for k in range(3)] for name in "ab"]
    assert speeds[0] == speeds[1] == [one.motion.speed for one in starts(case, 3)]
    more = start_jobs(cases, lambda one, _: job(recorded, one), 5, 3)
    assert list(more) == [f"{name}, start {k}" for name in "ab" for k in (4, 5)]


def test_what_is_there_ends_with_the_first_that_is_missing() -> None:
    done = {start_name("a", k): k for k in (1, 2, 4)}
    assert started(done, "a") == []
    assert started(done, "a", ["whole"]) == ["whole", 1, 2]


def test_means_and_errors_are_those_of_each_variant() -> None:
    found = means([{"x": 1.0}, {"x": 3.0}], ["x"])
    assert list(found) == ["x", "x_standard_error"]
    assert found["x"] == 2.0
    assert found["x_standard_error"] == pytest.approx(1.0)  # s = sqrt(2), over sqrt(2)
    assert means([{"x": 5.0}, {"x": 5.0}], ["x"])["x_standard_error"] == 0.0
