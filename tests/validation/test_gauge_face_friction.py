"""Friction of its own on the gauge face: the limits of one friction, and what lubrication there does in a tight curve."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

import rollerrig as rr
from rollerrig.analysis.curving import curving_case, curving_speed, follow, recorded, solve

TOP, FACE = 0.4, 0.1


def in_a_tight_curve(top: float, face: float | None, radius: float = 300.0) -> tuple[xr.Dataset, xr.Dataset]:
    """The coach in a curve to the left without an end: its numbers, and what a run records."""
    changes = {"contact.friction": top, "contact.gauge_face_friction": face, "support.foundation": None}
    case = curving_case(rr.load_case("vehicle_curve").with_changes(changes))
    end = np.array([1 / radius, 0.1, curving_speed(case, radius, 0.1, 0.06)])
    last, why = follow(case, solve(case, end * [0.0, 0.0, 1.0], "left"), end, "left")
    assert why == ""
    run = recorded([last])
    return rr.wheel_forces(run).isel(time=0), run.isel(time=0)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["bogie_rollers_constant", "bogie_track"])
def test_the_friction_of_the_top_on_the_gauge_face_changes_no_bit_of_a_run(name: str) -> None:
    case = rr.load_case(name).with_changes(
        {"disturbance": [{"body": "wheelset_1", "lateral": "7 mm"}], "time.duration": "0.2 s"}
    )
    one, same, slippery = (
        rr.simulate(case.with_changes({"contact.gauge_face_friction": mu}))
        for mu in (None, case.contact.friction.mu_0, FACE)
    )
    assert float(abs(one["patch_contact_angle"]).max()) > 0.7  # the flange touches
    assert one["lateral"].values.tobytes() == same["lateral"].values.tobytes()
    assert one["wear_number"].values.tobytes() == same["wear_number"].values.tobytes()
    assert float(abs(one["lateral"] - slippery["lateral"]).max()) > 1e-6


@pytest.mark.parametrize("radius", [300.0, 150.0])
def test_sliding_patches_carry_the_friction_of_their_contact_angle(radius: float) -> None:
    """(F6) written out again; leading wheelsets slide, their inner wheels on the tread, outer ones on flange and root."""
    _, run = in_a_tight_curve(TOP, FACE, radius)
    leading = run.sel(wheel=["wheelset_1_left", "wheelset_1_right", "wheelset_3_left", "wheelset_3_right"])
    angle, normal = (leading[f"patch_{name}"].to_numpy() for name in ("contact_angle", "normal"))
    low, high = np.sin(np.radians([20.0, 40.0]))
    part = np.clip((np.sin(abs(angle)) - low) / (high - low), 0.0, 1.0)
    friction = TOP + part**2 * (3 - 2 * part) * (FACE - TOP)
    used = np.hypot(leading["patch_creep_force_x"], leading["patch_creep_force_y"]).to_numpy() / normal / friction
    assert np.nanmax(used) < 1.005  # interpolation in the table of the exact theory; measured 1.0009
    assert np.nanmin(used) > 0.95  # measured 0.970


def test_a_lubricated_gauge_face_takes_wear_from_the_flange() -> None:
    """In newtons 371, 140, 56 at the leading outer wheel and 1254, 847, 241 in all: dry, lubricated there, lubricated all over.

    The treads push outwards as before, the flange turns the wheelset no longer: Y of that wheel grows, 28 to 33 kN.
    """
    dry, lubricated, wet = (in_a_tight_curve(*pair)[0] for pair in ((TOP, None), (TOP, FACE), (FACE, FACE)))
    outer = {"wheel": "wheelset_1_right"}
    wear = [float(found["wear_number"].sel(outer)) for found in (dry, lubricated, wet)]
    total = [float(found["wear_number"].sum()) for found in (dry, lubricated, wet)]
    assert wear[1] < 0.6 * wear[0]
    assert total[2] < 0.5 * total[1]
    assert total[1] < 0.75 * total[0]
    guiding = [float(abs(found["guiding_force"].sel(outer))) for found in (dry, lubricated, wet)]
    assert guiding[1] > 1.1 * guiding[0] > 1.1 * guiding[2]
    assert float(lubricated["nadal_limit"]) == float(wet["nadal_limit"]) > float(dry["nadal_limit"])
