"""What `check` says of a case: loads that do not add up have a reason."""

from __future__ import annotations

import rollerrig as rr
from rollerrig.cli.describe import describe_case

DIRECTIONS = ["x", "y", "z", "roll", "pitch", "yaw"]


def test_a_locked_body_carries_what_the_wheels_do_not() -> None:
    """A bogie below a car body that is locked: its springs carry nothing, the lock holds its weight of 313.9 kN."""
    springs = {
        f"vehicle.element.secondary_spring_{end}_{side}.carries_load": False
        for end in ("front", "rear")
        for side in ("left", "right")
    }
    held = {"vehicle.cut": "vehicle", "vehicle.body.car_body.locked": DIRECTIONS, **springs}
    lines = describe_case(rr.load_case("bogie_track").with_changes(held))
    assert lines[-2].endswith("(difference -3.1e+05 N)")
    assert lines[-1] == "the difference is what holds car_body, whose z is locked"


def test_where_loads_add_up_nothing_more_is_said() -> None:
    assert "(difference " in describe_case(rr.load_case("bogie_track"))[-1]
