"""Absurd values that run: each has a line beside the results, and nothing of the catalogue has one."""

from __future__ import annotations

import pytest

import rollerrig as rr
from rollerrig.catalog import catalog_names

SHORT = {"time.duration": "0.02 s"}


@pytest.mark.parametrize(
    ("changes", "line"),
    [
        ({"vehicle.body.wheelset_1.mass": "2e5 kg"}, "wheelset_1 stands on its rails with "),
        (
            {"time.method": "rodas4", "time.step": None, "time.absolute_tolerance": 1.0},
            "the absolute tolerance, 1e+03 mm, is",
        ),
        ({"vehicle.element.primary_1_left.y.stiffness": 1e12}, "primary_1_left has a mode of "),
    ],
)
def test_what_hardly_anybody_means_is_said(changes: dict[str, object], line: str) -> None:
    run = rr.simulate(rr.load_case("wheelset_rollers").with_changes(SHORT | changes))
    assert any(one.startswith(line) for one in run.attrs["warnings"].splitlines()), run.attrs["warnings"]


@pytest.mark.parametrize(
    "name", ["wheelset_rollers", "bogie_track", "scaled_brake", "contact_benchmark_track", "adhesion_brake"]
)
def test_nothing_is_said_of_the_cases_that_ship(name: str) -> None:
    assert name in catalog_names("case")
    assert "stands on its rails" not in (
        warnings := rr.simulate(rr.load_case(name).with_changes(SHORT)).attrs["warnings"]
    )
    assert "tolerance" not in warnings
    assert "mode of" not in warnings
