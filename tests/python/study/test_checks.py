"""Checks: a number passes or fails; an interval may leave the outcome open, and is never replaced by its middle."""

from __future__ import annotations

import math

import pytest

from rollerrig.study.assessment import Check, Interval, check_table, counts, counts_text


def test_checks_pass_and_fail() -> None:
    good = Check("a", 1.01, 1.0, 0.02, "reason", relative=True)
    bad = Check("b", 1.1, 1.0, 0.02, "reason", "N")
    nothing = Check("c", math.nan, 1.0, 0.02, "reason")
    unlimited = Check("d", math.nan, 1.0, 0.02, "reason", kind="at most")
    assert good.passed
    assert bad.outcome == "failed"
    assert [one.outcome for one in (nothing, unlimited)] == ["not decided"] * 2  # what is no number
    assert not nothing.passed
    assert Check("e", 0.3, 0.0, 0.1, "reason", relative=True).outcome == "failed"  # not zero, against zero
    rows = check_table([good, bad]).rows
    assert rows[0][0] == "✔ pass"
    assert rows[1][0] == "✘ FAIL"
    assert good.as_dict()["deviation"] == pytest.approx(0.01)


@pytest.mark.parametrize(
    ("low", "high", "outcome"),
    [
        (95.0, 105.0, "passed"),
        (90.0, 110.0, "passed"),
        (100.0, 160.0, "not decided"),
        (80.0, 120.0, "not decided"),  # its middle would agree exactly
        (112.0, 113.0, "failed"),
        (-math.inf, 100.0, "not decided"),
        (111.0, math.inf, "failed"),
    ],
)
def test_an_interval_passes_as_a_whole_or_not_at_all(low: float, high: float, outcome: str) -> None:
    assert Check("a", Interval(low, high), 100.0, 0.1, "reason", relative=True).outcome == outcome


@pytest.mark.parametrize(
    ("low", "high", "outcome"),
    [
        (-math.inf, 253.0, "passed"),
        (100.0, 253.0, "passed"),
        (200.0, math.inf, "not decided"),
        (254.0, 300.0, "failed"),
    ],
)
def test_a_bound_holds_for_the_whole_interval(low: float, high: float, outcome: str) -> None:
    assert Check("a", Interval(low, high), 253.1, 0.0, "reason", kind="at most").outcome == outcome


def test_the_counts_say_how_many_were_decided() -> None:
    checks = [
        Check("a", 1.0, 1.0, 0.1, "reason"),
        Check("b", 2.0, 1.0, 0.1, "reason"),
        Check("c", Interval(0.0, 2.0), 1.0, 0.1, "reason"),
    ]
    assert counts(checks) == {"checks_passed": 1, "checks_failed": 1, "checks_not_decided": 1}
    assert counts_text(checks).startswith("2 of 3 checks are decided: 1 passed, 1 failed. Not decided are")
    assert checks[2].as_dict()["value"] == [0.0, 2.0]


@pytest.mark.parametrize(
    ("interval", "text"),
    [
        (Interval(164.44, 166.67), "164.4 … 166.7 km/h"),
        (Interval(160.0, math.inf), "above 160.0 km/h"),
        (Interval(-math.inf, 100.0), "at most 100.0 km/h"),
        (Interval(-math.inf, math.inf), "–"),
        (Interval(253.1, 253.1), "253.1 km/h"),
    ],
)
def test_an_interval_is_shown_with_both_its_ends(interval: Interval, text: str) -> None:
    assert interval.text("km/h", 1) == text


def test_intervals_are_compared_as_a_whole() -> None:
    narrow, wide = Interval(137.8, 140.0), Interval(100.0, 200.0)
    assert wide.distance(150.0) == Interval(0.0, 50.0)
    assert narrow.distance(100.0) == Interval(pytest.approx(37.8), pytest.approx(40.0))
    ratio = narrow.over(Interval(175.6, 177.8))
    assert (ratio.low, ratio.high) == (pytest.approx(137.8 / 177.8), pytest.approx(140.0 / 175.6))
