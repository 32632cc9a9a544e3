"""Published benchmarks of hunting, and a closed form, beside the program; docs/benchmarks.md."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from validation import write_benchmarks
from validation.test_page import differences
from validation.write_benchmarks import (
    LARGE,
    ORBIT,
    PUBLISHED,
    REST,
    SMALL,
    amplitude,
    critical,
    equations,
    wheelset_formula,
)
from validation.write_measured import section as section_of


@pytest.mark.slow
@pytest.mark.parametrize("section", write_benchmarks.SECTIONS, ids=lambda section: section.__name__)
def test_the_page_is_what_the_program_gives(section: Callable[[], str]) -> None:
    today = section()
    page = write_benchmarks.PAGE.read_text(encoding="utf-8")
    assert page.startswith(write_benchmarks.INTRODUCTION)
    assert differences(section_of(page, today.splitlines()[0]), today) == []


def test_cooperrider_s_bogie_becomes_unstable_where_published() -> None:
    speeds = [speed for speed, _ in equations().values()]
    assert speeds[0] == pytest.approx(
        PUBLISHED, rel=3e-4
    )  # the equations as published: the numbers are the benchmark's
    # Beyond them: elastic contacts and the load of the springs.
    assert critical()[0] == pytest.approx(speeds[-1], rel=0.012)
    assert critical()[0] == pytest.approx(PUBLISHED, rel=0.012)


def test_a_large_disturbance_ends_in_an_orbit_above_and_at_rest_below() -> None:
    middle, end = amplitude(*ORBIT)
    assert 9.1 < end == pytest.approx(middle, rel=1e-3)  # mm: against the flange, and settled
    middle, end = amplitude(*REST)
    assert end < 0.01 * middle < 0.01


def test_it_loses_its_stability_hard() -> None:
    assert LARGE[0] == SMALL[0] < critical()[0]
    middle, end = amplitude(*LARGE)
    assert end > 9.1  # mm: against the flange
    assert end > middle  # after it had fallen
    middle, end = amplitude(*SMALL)
    assert end < 0.9 * middle < 0.9


def test_the_wheelset_on_springs_has_the_closed_form_s_critical_speed() -> None:
    # The wheelset rolls as it moves sideways, as the closed form's does not: terms of the order of the conicity squared.
    assert critical("suspended_wheelset")[0] == pytest.approx(wheelset_formula(), rel=4e-3)
