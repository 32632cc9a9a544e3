"""Where rigid profiles first touch: S1002 on UIC60 1:40, rail and roller of radius 500 mm.

Reference: rigid_touch.csv, dense sampling of both surfaces and polishing, independent of this code. Its frame: y to the
right, z down, right wheel. Positions are compared in the track; its rail datum 760.5326 mm is the origin of the profile's
point file, which lies 0.006 mm inside the highest point that is our origin.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import pytest

from rollerrig import _core
from validation.reference import benchmark_contact, mm, rows

#: The wheel's contact angle beyond which a contact counts as one of the flange.
FLANGE_ANGLE = 0.25


@pytest.fixture(scope="module")
def contacts() -> dict[str, _core.StaticWheelsetContact]:
    return {"rail": benchmark_contact(None), "roller": benchmark_contact(0.5)}


@dataclass(frozen=True)
class Difference:
    """Ours minus the reference for one pose [mm]."""

    row: dict
    height: float
    s: float
    x: float
    y: float
    z: float
    flange: bool
    second_s: float = math.nan
    second_height: float = math.nan


def compare(contact: _core.StaticWheelsetContact, row: dict) -> Difference:
    y, yaw, x = -row["y_ws"] * mm, -row["yaw"], row["x_ws"] * mm
    z = contact.touch_height(x, y, yaw, 0.0, True)
    first = max(contact.minima(x, y, z, yaw, 0.0, True, 0.5 * mm), key=lambda patch: patch.approach)
    point = [value / mm for value in first.point]
    second: dict[str, float] = {}
    if not math.isnan(row["gap2"]):
        # gap2 is the vertical way from the first touch to the second: lowered by it, the second point just touches too.
        lowered = contact.minima(x, y, z - row["gap2"] * mm, yaw, 0.0, True, 0.05 * mm)
        near = min(lowered, key=lambda patch: abs(patch.wheel_s / mm - row["yw2"]), default=None)
        if near is not None:
            second = {
                "second_s": near.wheel_s / mm - row["yw2"],
                "second_height": near.approach / mm / near.direction[2],
            }
    return Difference(
        row=row,
        height=-z / mm - row["z_ws"],
        s=first.wheel_s / mm - row["yw"],
        x=point[0] - row["x_tr"],
        y=-point[1] - row["y_tr"],
        z=-point[2] - row["z_tr"],
        flange=abs(row["angle_wheel"]) > FLANGE_ANGLE,
        **second,
    )


@pytest.fixture(scope="module")
def differences(contacts: dict[str, _core.StaticWheelsetContact]) -> list[Difference]:
    return [compare(contacts[row["cfg"]], row) for row in rows("rigid_touch.csv")]


def worst(differences: list[Difference], support: str, flange: bool, *names: str) -> float:
    found = [d for d in differences if d.row["cfg"] == support and d.flange == flange]
    assert len(found) > 30
    return max(abs(getattr(d, name)) for d in found for name in names)


@pytest.mark.parametrize("support", ["rail", "roller"])
def test_points_of_first_touch_on_the_tread(differences: list[Difference], support: str) -> None:
    # Near y = 0.5 mm wheel and rail are almost conformal: a difference of the profiles of 1e-5 mm (printed digits)
    # moves the point by 0.009 mm. The median is 4e-5 mm.
    assert worst(differences, support, False, "s", "x", "y", "z") < 0.01


@pytest.mark.parametrize("support", ["rail", "roller"])
def test_points_of_first_touch_on_the_flange(differences: list[Difference], support: str) -> None:
    # x is the worst, 0.033 mm: on a steep flange the contact runs ahead of the axle, and turns with the slope.
    assert worst(differences, support, True, "s", "x", "y", "z") < 0.1


@pytest.mark.parametrize("support", ["rail", "roller"])
@pytest.mark.parametrize(("flange", "tolerance"), [(False, 2e-5), (True, 1e-3)])
def test_heights_of_first_touch(differences: list[Difference], support: str, flange: bool, tolerance: float) -> None:
    # The reference agrees with CONTACT to 5.5e-5 mm (median); a height is stationary in the point's position.
    assert worst(differences, support, flange, "height") < tolerance


def test_every_second_contact_of_the_reference_is_found(differences: list[Difference]) -> None:
    listed = [d for d in differences if not math.isnan(d.row["gap2"])]
    assert len(listed) == 64
    missing = [d.row for d in listed if math.isnan(d.second_s)]
    assert not missing
    # yw2 is a point of the reference's sampling, not polished: it stays the same where the pose moves it. Its height is
    # good to the square of that.
    assert max(abs(d.second_s) for d in listed) < 0.1
    assert max(abs(d.second_height) for d in listed) < 1e-3
