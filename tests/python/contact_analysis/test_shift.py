"""Touching points over lateral shift: arcs on arcs in closed form, cones, and what rollers change."""

from __future__ import annotations

import math

import numpy as np
import pytest
import xarray as xr

from rollerrig.assembly.model import assemble
from rollerrig.config import Case, load_case
from rollerrig.contact_analysis import conicity_table, pair_case, shift_table

WHEEL_ARC, RAIL_ARC, DEPTH = 2.0, 0.3, 0.2e-3


def crowned_pair(roller_radius: float | None = None) -> Case:
    """A crowned wheel on a crowned rail that stands some 7 mm further out."""
    half_width = math.sqrt(RAIL_ARC**2 - (RAIL_ARC - DEPTH) ** 2)
    case = load_case("contact_benchmark_track" if roller_radius is None else "contact_benchmark_rollers")
    changes: dict[str, object] = {
        "vehicle.wheel.profile": {"kind": "arc", "radius": WHEEL_ARC, "half_width": 20e-3},
        "support.profile": {"kind": "arc", "radius": RAIL_ARC, "half_width": 20e-3},
        "support.gauge_depth": DEPTH,
        "support.gauge": 2 * (0.757 - half_width),
    }
    return case.with_changes(changes | ({"support.roller_radius": roller_radius} if roller_radius else {}))


@pytest.fixture(scope="module")
def offset() -> float:
    """Of the rail's crown from the tape circle, outwards [m]; 4e-6 m above 7 mm: the gauge is taken on a polygon."""
    return assemble(crowned_pair()).rail_origin_y - 0.75


@pytest.fixture(scope="module")
def crowned() -> xr.Dataset:
    return shift_table(crowned_pair(), 4e-3, 0.5e-3)


@pytest.mark.parametrize(("side", "sign"), [("left", 1), ("right", -1)])
def test_arcs_touch_on_the_line_through_their_centres(crowned: xr.Dataset, offset: float, side: str, sign: int) -> None:
    here = crowned.sel(side=side)
    sine = (offset - sign * here["lateral"].to_numpy()) / (WHEEL_ARC + RAIL_ARC)
    # Splines of arcs with knots at 0.05 mm.
    assert here["wheel_abscissa"].to_numpy() == pytest.approx(WHEEL_ARC * sine, abs=2e-7)
    assert here["rail_abscissa"].to_numpy() == pytest.approx(-RAIL_ARC * sine, abs=2e-7)
    assert here["contact_angle"].to_numpy() == pytest.approx(np.arcsin(sine), abs=2e-7)
    drop = 1 - np.sqrt(1 - sine**2)
    assert here["rolling_radius"].to_numpy() == pytest.approx(0.46 - WHEEL_ARC * drop, abs=2e-9)
    assert here["rail_height"].to_numpy() == pytest.approx(-RAIL_ARC * drop, abs=2e-9)


def test_crowned_wheels_have_a_constant_conicity(crowned: xr.Dataset, offset: float) -> None:
    exact = offset * WHEEL_ARC / (WHEEL_ARC + RAIL_ARC) ** 2  # of parabolas; arcs differ by sine^2, 1e-5
    assert conicity_table(crowned, [1e-3, 3e-3])["conicity"].to_numpy() == pytest.approx(exact, rel=1e-4)


@pytest.mark.parametrize("roller_radius", [0.3, 0.725, 10.0])
def test_rollers_touch_where_rails_do_and_take_their_own_radii_into_account(
    crowned: xr.Dataset, roller_radius: float
) -> None:
    rollers = shift_table(crowned_pair(roller_radius), 4e-3, 0.5e-3)
    for name in ("wheel_abscissa", "rail_abscissa", "rolling_radius", "rail_height", "contact_angle"):
        assert rollers[name].to_numpy() == pytest.approx(crowned[name].to_numpy(), abs=1e-9)
    share = (WHEEL_ARC - RAIL_ARC * 0.46 / roller_radius) / WHEEL_ARC
    expected = share * crowned["rolling_radius_difference"].to_numpy()
    assert rollers["effective_difference"].to_numpy() == pytest.approx(expected, abs=2e-9)


def test_a_rolling_wheelset_touches_on_both_sides(offset: float) -> None:
    free = shift_table(crowned_pair(), 2e-3, 0.5e-3, free_to_roll=True)
    lateral, roll = free["lateral"].to_numpy(), free["roll"].to_numpy()
    # The wheel that moves towards its rail's crown climbs, the other one descends; the contacts are 1.5 m and 6 mm apart.
    climb = 2 * lateral * offset / (WHEEL_ARC + RAIL_ARC)
    assert roll == pytest.approx(climb / 1.5, rel=0.02, abs=1e-9)
    assert roll[0] == -roll[-1]


def test_a_cone_keeps_its_conicity_and_its_contact_on_the_rail() -> None:
    table = shift_table(pair_case("cone_1_20", "en_60e1_1_40"), 4e-3, 1e-3)
    assert np.ptp(table["rail_abscissa"].to_numpy()) < 1e-9
    assert conicity_table(table, [1e-3, 4e-3])["conicity"].to_numpy() == pytest.approx(0.05, rel=1e-9)


def test_a_jump_of_the_contact_is_placed_to_a_micrometre() -> None:
    table = shift_table(pair_case("s1002", "uic60_benchmark_1_40"), 1e-3, 0.25e-3)
    way = np.abs(np.diff(table["wheel_abscissa"].sel(side="left").to_numpy()))
    assert way.max() > 8e-3
    assert np.diff(table["lateral"].to_numpy())[way > 1e-3].max() <= 1e-6


def test_the_table_ends_where_a_wheel_leaves_its_rail() -> None:
    table = shift_table(pair_case("cone_1_20", "en_60e1_1_40"), 80e-3, 20e-3)
    assert float(table["lateral"][-1]) < 80e-3
    assert "no contact from" in table.attrs["ended"]


def test_steps_must_be_positive() -> None:
    with pytest.raises(ValueError, match="positive"):
        shift_table(pair_case("cone_1_20", "en_60e1_1_40"), 1e-3, 0.0)


def test_rollers_add_to_the_conicity_what_their_radii_do(offset: float) -> None:
    radius = 0.725
    table = conicity_table(shift_table(crowned_pair(radius), 4e-3, 0.5e-3), [1e-3, 3e-3])
    # Arcs: the wheel's radius grows by offset R_w / (R_w + R_r)^2 per shift, the roller's by R_r / R_w of that.
    wheels = offset * WHEEL_ARC / (WHEEL_ARC + RAIL_ARC) ** 2
    rollers = -wheels * RAIL_ARC / WHEEL_ARC * 0.46 / radius  # λ_r / R0, in the wheel's scale r0
    assert table["conicity"].to_numpy() == pytest.approx(wheels + rollers, rel=1e-4)
