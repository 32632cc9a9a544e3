"""Absurd values that run: each has a line beside the results, and nothing of the catalogue has one."""

from __future__ import annotations

import json

import pytest

import rollerrig as rr
from rollerrig.cases import displaced
from rollerrig.catalog import catalog_names

SHORT = {"time.duration": "0.02 s"}


@pytest.mark.parametrize(
    ("changes", "line"),
    [
        ({"vehicle.body.wheelset_1.mass": "2e5 kg"}, "wheelset_1 stands on its rails with "),
        (
            {"time.method": "rodas4", "time.step": None, "time.absolute_tolerance": 1.0},
            "the absolute tolerance, 1e+03 mm, is larger than the largest lateral motion, ",
        ),
        ({"vehicle.element.primary_1_left.y.stiffness": 1e12}, "primary_1_left has a mode of "),
        (
            {"motion.speed": "4e-14 m/s"},
            "at 4e-14 m/s the run covers 8e-16 m, less than a turn of a wheel: the speed or units",
        ),
        (
            {"contact.friction.mu_0": 3e-4, "disturbance": []},
            "a coefficient of friction of 0.0003 is less than that of any rail",
        ),
    ],
)
def test_what_hardly_anybody_means_is_said(changes: dict[str, object], line: str) -> None:
    run = rr.simulate(rr.load_case("wheelset_rollers").with_changes(SHORT | changes))
    assert any(one.startswith(line) for one in run.attrs["warnings"].splitlines()), run.attrs["warnings"]


@pytest.mark.slow
@pytest.mark.parametrize(("tolerance", "said"), [(1e-3, False), (1e-6, True)])
def test_steps_that_cannot_be_short_enough_are_counted(tolerance: float, said: bool) -> None:
    """A wheelset dropped on its flange bounces: a 32nd of 2 ms does not resolve that to a millionth."""
    case = displaced(rr.load_case("bogie_rollers_constant"), 8e-3).with_changes(
        {
            "motion.speed": "138 km/h",
            "time.duration": "0.1 s",
            "time.step": "2 ms",
            "time.relative_tolerance": tolerance,
            "time.absolute_tolerance": 1e-3 * tolerance,
        }
    )
    assert case.time.method == "exponential_adams"
    run = rr.simulate(case)
    counted = json.loads(run.attrs["solver_statistics"])
    assert (counted["coarse_steps"] > 0) is said
    assert (counted["largest_error"] > 1.0) is said
    line = f"{counted['coarse_steps']} of {counted['steps']} steps have an error above the tolerance, up to "
    assert (line in run.attrs["warnings"]) is said


@pytest.mark.parametrize(
    "name", ["wheelset_rollers", "bogie_track", "scaled_brake", "contact_benchmark_track", "adhesion_brake"]
)
def test_nothing_is_said_of_the_cases_that_ship(name: str) -> None:
    assert name in catalog_names("case")
    assert "stands on its rails" not in (
        warnings := rr.simulate(rr.load_case(name).with_changes(SHORT)).attrs["warnings"]
    )
    assert "tolerance" not in warnings
    assert "may not be what is meant" not in warnings
    assert "mode of" not in warnings
