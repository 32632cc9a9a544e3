"""Profiles generated from definitions, against those definitions and against closed forms."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from catalogued import profile_table
from rollerrig.profiles import STEEPEST_SLOPE, gauge_point, profile_from_spec
from rollerrig.profiles import analytic as rail
from rollerrig.profiles.analytic import FLANGE_ROOT_AS_PRINTED, SEGMENTS, TREAD, s1002, s1002_height

mm = 1e-3
RAILS = ["uic60_benchmark_1_40", "uic60_benchmark_1_20", "en_60e1_1_40", "en_60e1_1_20"]


def away_from(y, junctions, distance):
    return np.min(np.abs(np.subtract.outer(y, np.asarray(junctions))), axis=1) > distance


# ------------------------------------------------------------------ S1002


@pytest.mark.parametrize(
    ("s", "increase"),
    [(-30, 3.92157), (-20, 1.59656), (-10, 0.52276), (10, -0.20840), (20, -0.31176), (30, -0.64623), (60, -2.63568)],
)
def test_s1002_takes_its_published_sample_values(s, increase):
    # The samples have five decimals. At -30 the closing of the printed polynomial's gaps moves the value by 7e-5 mm.
    tolerance = 1e-4 if s == -30 else 6e-6
    assert float(s1002().evaluate(s * mm)) / mm == pytest.approx(increase, abs=tolerance)


def test_s1002_is_zero_at_the_tape_circle_and_spans_flange_tip_to_run_out():
    table = s1002()
    assert table.domain == pytest.approx((-60 * mm, 60 * mm), abs=1e-15)
    assert abs(float(table.evaluate(0.0))) < 1e-12
    tip = float(table.evaluate(-55 * mm))
    assert tip == pytest.approx(28 * mm, abs=1e-8)  # centre 16 + radius 12, table of 0.05 mm


def test_s1002_segments_meet_in_value_slope_and_are_closed_where_the_print_gapes():
    starts = [start for start, _ in SEGMENTS[:-1]]
    gap = [float(s1002_height(np.array(s)) - s1002_height(np.array(s - 1e-9))) for s in starts]
    # 1e-9 mm times the steepest slope 2.75, and the gaps of the nine-digit arcs, which are below 7e-8 mm.
    assert np.max(np.abs(gap)) < 1e-7
    s = np.linspace(-35, -26, 901)
    moved = s1002_height(s) - FLANGE_ROOT_AS_PRINTED(s)
    assert np.max(np.abs(moved)) < 1.3e-4  # [mm] no larger than the gap of the print at -35


def test_s1002_curvature_has_no_spike_at_the_junctions():
    table = s1002()
    for junction, kind in ((-26.0, "smooth"), (-35.0, "smooth"), (32.15796, "jump")):
        y = np.linspace(junction - 0.5, junction + 0.5, 2001) * mm
        curvature = table.curvature(y)
        left, right = curvature[0], curvature[-1]
        # Smooth junctions: the curvature runs from one side to the other with less than 0.5 of its 1/13 mm = 77 1/m.
        # At the run-out it jumps by 4.4 1/m, and a twelfth of that is the overshoot of the spline.
        allowed = 0.5 if kind == "smooth" else 4.4 / 11
        assert curvature.max() < max(left, right) + allowed
        assert curvature.min() > min(left, right) - allowed


def test_s1002_slope_is_exact_but_for_the_fifth_of_a_millimetre_around_a_junction():
    table = s1002()
    s = np.linspace(-59.9, 59.9, 40001)
    s = s[away_from(s, [start for start, _ in SEGMENTS], 0.2)]
    d = 1e-4  # [mm] central difference, error below 1e-9
    exact = (s1002_height(s + d) - s1002_height(s - d)) / (2 * d)
    error = np.arctan(table.evaluate(s * mm, 1)) - np.arctan(exact)
    assert np.max(np.abs(error)) < 2e-6  # [rad]; measured 1.2e-6, on the flange face side of an arc


def test_s1002_tread_matches_its_polynomial_with_curvature():
    s = np.linspace(-25, 32, 5701)
    s = s[np.abs(s - 32.15796) > 0.2]
    table = s1002()
    second = TREAD.deriv(2)(s) / mm
    assert np.max(np.abs(table.evaluate(s * mm) / mm - TREAD(s))) < 1e-8
    assert np.max(np.abs(table.evaluate(s * mm, 2) - second)) < 1e-4  # [1/m] of 21


# ------------------------------------------------------------------ rail heads


@pytest.mark.parametrize(
    ("variant", "depths", "side"),
    [
        ("en_13674", (0.174404, 2.302524), (35.99981, 14.29996)),
        # The benchmark's corners lie 5e-5 mm lower than tangent arcs through its junctions put them.
        ("benchmark", (0.183804, 2.253210), (36.00, None)),
    ],
)
def test_the_arcs_of_the_head_meet_where_the_drawing_says(variant, depths, side):
    arcs = rail.half_head(variant)
    tolerance = 2e-6 if variant == "en_13674" else 6e-5
    assert -arcs[0].point(arcs[0].end)[1] == pytest.approx(depths[0], abs=tolerance)
    assert -arcs[1].point(arcs[1].end)[1] == pytest.approx(depths[1], abs=tolerance)
    y, z = arcs[2].point(arcs[2].end)
    assert y == pytest.approx(side[0], abs=1e-5)
    if side[1] is not None:
        assert -z == pytest.approx(side[1], abs=1e-5)


@settings(max_examples=25, deadline=None)
@given(inclination=st.floats(-0.05, 0.05), variant=st.sampled_from(["en_13674", "benchmark"]))
def test_at_any_inclination_the_highest_point_is_the_origin_and_the_head_is_convex(inclination, variant):
    table = rail.uic60(inclination, variant)
    y = np.linspace(*table.domain, 2001)
    height = table.evaluate(y)
    # Where the curvature jump of the crown (9 1/m) comes to lie at the top, the spline rounds it off: 1 nm.
    assert height.max() < 1e-8
    assert abs(float(table.evaluate(0.0))) < 1e-8
    assert np.max(np.abs(table.evaluate(y, 1))) < STEEPEST_SLOPE * 1.02
    inner = y[(y > y[0] + mm) & (y < y[-1] - mm)]  # the last knots extrapolate a steep arc
    assert np.min(table.curvature(inner)) > 0


@settings(max_examples=15, deadline=None)
@given(inclination=st.floats(0.0, 0.05))
def test_leaning_outward_mirrors_leaning_inward(inclination):
    inward, outward = rail.uic60(inclination), rail.uic60(-inclination)
    y = np.linspace(-20 * mm, 20 * mm, 401)
    assert inward.domain == pytest.approx((-outward.domain[1], -outward.domain[0]), abs=1e-12)
    assert inward.evaluate(y) == pytest.approx(outward.evaluate(-y), abs=1e-12)


@pytest.mark.parametrize("name", RAILS)
def test_a_rail_table_follows_its_arcs(name):
    table = profile_table(name, "rail")
    variant = "benchmark" if "benchmark" in name else "en_13674"
    arcs = rail.inclined_head(variant, 1 / 40 if name.endswith("40") else 1 / 20)
    y = np.linspace(*table.domain, 30001)
    exact = rail.head_height(arcs, y / mm) * mm
    assert np.max(np.abs(table.evaluate(y) - exact)) < 1e-7  # [m]; at the steep ends, elsewhere 1e-8

    slope, curvature = np.full((2, len(y)), np.nan)
    for arc in arcs:
        inside = (y / mm >= arc.point(arc.start)[0]) & (y / mm <= arc.point(arc.end)[0])
        angle = np.arcsin((y[inside] / mm - arc.y) / arc.radius)
        slope[inside], curvature[inside] = -np.tan(angle), 1e3 / arc.radius
    calm = away_from(y / mm, [arc.point(arc.start)[0] for arc in arcs[1:]], 0.2)
    # A wheel's flange stands at 70 degrees, slope 2.75; beyond 72 degrees the 0.05 mm steps get coarse.
    calm &= np.abs(slope) < 3.0
    angle_error = np.arctan(table.evaluate(y, 1)) - np.arctan(slope)
    assert np.max(np.abs(angle_error[calm])) < 1e-5  # [rad]; asked for: 2e-5
    assert np.max(np.abs(table.curvature(y) / curvature - 1)[calm]) < 0.005
    near = ~away_from(y / mm, [arc.point(arc.start)[0] for arc in arcs[1:]], 0.2) & away_from(
        y / mm, [arc.point(arc.start)[0] for arc in arcs[1:]], 0.15
    )  # the spline is local: three knots of 0.05 mm beyond a junction nothing of its jump is left
    assert np.max(np.abs(table.curvature(y) / curvature - 1)[near]) < 0.005


def test_the_benchmark_rail_lies_where_the_gauge_puts_it():
    table = profile_table("uic60_benchmark_1_40", "rail")
    # 760.533 mm is the origin of the benchmark's point file, whose highest point lies 0.006 mm further out
    # (its two R13 centres say so): our origin is the highest point itself.
    origin = 1.435 / 2 - gauge_point(table, 14 * mm)
    assert origin == pytest.approx(760.5326 * mm + 0.00596 * mm, abs=1e-6)


def test_the_gauge_does_not_depend_on_the_sampling_of_the_outline():
    arcs = rail.inclined_head("en_13674", 1 / 40)
    coarse, fine = (rail.outline(arcs, n) for n in (500, 4000))
    y = [float(np.interp(-14 * mm, o[: len(o) // 5, 1], o[: len(o) // 5, 0])) for o in (coarse, fine)]
    assert y[0] == pytest.approx(y[1], abs=2e-8)  # chord error of the R13 arc: s^2/8R = 1e-8 m for 0.03 mm


# ------------------------------------------------------------------ cone, cylinder, arc


@settings(max_examples=20, deadline=None)
@given(conicity=st.floats(-0.5, 0.5))
def test_a_cone_loses_its_conicity_per_metre_outward(conicity):
    table = profile_from_spec({"kind": "cone", "conicity": conicity}, "wheel")
    s = np.linspace(*table.domain, 101)
    assert table.evaluate(s) == pytest.approx(-conicity * s, abs=1e-15)
    assert table.evaluate(s, 1) == pytest.approx(-conicity, abs=1e-11)
    assert np.max(np.abs(table.evaluate(s, 2))) < 1e-5  # round-off of second differences over 5e-5 m


@settings(max_examples=20, deadline=None)
@given(radius=st.floats(0.02, 5.0))
def test_an_arc_has_the_curvature_of_its_radius(radius):
    table = profile_from_spec({"kind": "arc", "radius": radius}, "rail")
    half = 0.6 * min(radius, 36 * mm)
    y = np.linspace(-half, half, 301)
    # z'' is off by step^2 z''''/12, at most 1e-6 relative for radii from 20 mm up to slope 0.75
    assert table.curvature(y) == pytest.approx(1 / radius, rel=2e-5, abs=1e-5)
    assert np.max(table.evaluate(np.linspace(*table.domain, 999))) < 1e-13  # round-off of 30 mm at the far ends


def test_a_flat_head_has_flanks_for_its_gauge():
    assert gauge_point(profile_table("cylinder", "rail")) == pytest.approx(-36 * mm)
    assert not np.any(profile_table("cylinder", "wheel").coefficients)
