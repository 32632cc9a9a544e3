"""Measured points: whatever way a file writes a profile, the same profile comes out; bad files are refused."""

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from catalogued import profile_table
from rollerrig.profiles import ProfileError, gauge_point, profile_from_spec
from rollerrig.profiles import analytic as rail
from rollerrig.profiles.analytic import s1002_height

mm = 1e-3


def wheel_points(step=0.25):
    """S1002 along its flange and tread: S and radius increase [mm], evenly spaced along the curve."""
    s = np.linspace(-62, 60, 20001)
    z = s1002_height(s)
    length = np.concatenate(([0.0], np.cumsum(np.hypot(np.diff(s), np.diff(z)))))
    even = np.linspace(0, length[-1], round(length[-1] / step))
    s = np.interp(even, length, s)
    return np.column_stack([s, s1002_height(s)])


def rail_points(step=0.25, depth=20.0):
    """The benchmark rail 1:40 with its flanks: y and height [mm]."""
    outline = rail.outline(rail.inclined_head("benchmark", 1 / 40), 4000) / mm
    length = np.concatenate(([0.0], np.cumsum(np.hypot(*np.diff(outline, axis=0).T))))
    even = np.linspace(0, length[-1], round(length[-1] / step))
    points = np.column_stack([np.interp(even, length, c) for c in outline.T])
    return points[points[:, 1] > -depth]


def write(path, points, separator=" ", head=""):
    path.write_text(head + "\n".join(separator.join(f"{x:.7f}" for x in row) for row in points) + "\n")
    return path


def read(path, kind="wheel", **keys):
    return profile_from_spec({"kind": "file", "path": str(path), **keys}, kind)


# ------------------------------------------------------------------ one profile, many ways to write it


@pytest.mark.parametrize(
    ("y_sign", "z_sign", "order", "unit"), list(itertools.product([1, -1], [1, -1], [1, -1], [1, mm]))
)
def test_a_wheel_is_recognised_by_its_flange_in_any_axes_and_units(tmp_path, y_sign, z_sign, order, unit):
    points = (wheel_points() * [y_sign, z_sign])[::order] * unit
    path = tmp_path / "wheel.txt"
    np.savetxt(path, points, fmt="%.10f")
    table, exact = read(path), profile_table("s1002", "wheel")
    s = np.linspace(-59, 59, 1181) * mm
    # Smoothing at the 0.25 mm spacing rounds the junctions of the flange off by 0.3 um; the tread is exact.
    assert np.max(np.abs(table.evaluate(s) - exact.evaluate(s))) < 5e-7
    tread = (s > -20 * mm) & (s < 30 * mm)
    assert np.max(np.abs(table.curvature(s) - exact.curvature(s))[tread]) < 0.5  # [1/m]


@pytest.mark.parametrize("mark", ["#", "!", "%", ";", "//"])
@pytest.mark.parametrize("separator", [" ", ",", "\t", ", "])
def test_comments_and_separators_do_not_matter(tmp_path, mark, separator):
    points = wheel_points(1.0)
    plain = read(write(tmp_path / "plain.txt", points))
    head = f"{mark} measured on a Monday, 3 4\nS,z\n\n  {mark}another line\n"
    dressed = read(write(tmp_path / "dressed.txt", points, separator, head))
    assert dressed.coefficients.tobytes() == plain.coefficients.tobytes()


def test_a_rail_comes_out_with_its_top_at_the_origin_and_its_gauge(tmp_path):
    points = rail_points() + [3.0, 7.0]  # the file's origin is anywhere
    table = read(write(tmp_path / "rail.txt", points), "rail")
    exact = profile_table("uic60_benchmark_1_40", "rail")
    assert gauge_point(table) == pytest.approx(gauge_point(exact), abs=1e-6)
    y = np.linspace(-40, 27, 671) * mm
    assert np.max(np.abs(table.evaluate(y) - exact.evaluate(y))) < 5e-7  # junctions rounded at 0.25 mm


@pytest.mark.parametrize("z_sign", [1, -1])
def test_a_rail_pictured_from_the_other_side_says_so(tmp_path, z_sign):
    mirrored = rail_points() * [-1, z_sign]
    straight = read(write(tmp_path / "a.txt", rail_points()), "rail")
    turned = read(write(tmp_path / "b.txt", mirrored), "rail", inner_side="positive")
    y = np.linspace(-40, 27, 671) * mm
    assert turned.evaluate(y) == pytest.approx(straight.evaluate(y), abs=1e-9)  # seven decimals of a millimetre


def test_an_upright_measurement_is_inclined_on_request(tmp_path):
    points = rail.outline(rail.inclined_head("benchmark", 0.0), 400) / mm
    table = read(write(tmp_path / "upright.txt", points[1:-1]), "rail", inclination=0.025)
    exact = profile_table("uic60_benchmark_1_40", "rail")
    y = np.linspace(-40, 27, 671) * mm
    assert np.max(np.abs(table.evaluate(y) - exact.evaluate(y))) < 1e-6


def test_a_wheel_measured_from_the_flange_back_names_its_tape_circle(tmp_path):
    path = write(tmp_path / "wheel.txt", wheel_points() + [70.0, 0.0])
    exact = profile_table("s1002", "wheel")
    s = np.linspace(-55, 55, 221) * mm
    assert read(path, tape_circle=0.07).evaluate(s) == pytest.approx(exact.evaluate(s), abs=5e-7)


def test_web_and_foot_of_a_full_rail_section_are_left_out(tmp_path):
    web_and_foot = [[-30, -51], [-8.25, -60], [-8.25, -140], [-75, -160], [-75, -172]]
    section = np.vstack([web_and_foot[::-1], rail_points(0.25, 38.0), np.array(web_and_foot) * [-1, 1]])
    table = read(write(tmp_path / "section.txt", section), "rail")
    exact = profile_table("uic60_benchmark_1_40", "rail")
    assert gauge_point(table) == pytest.approx(gauge_point(exact), abs=1e-6)


def test_a_chamfer_at_the_outer_edge_of_a_wheel_ends_the_profile(tmp_path):
    chamfer = np.column_stack([np.arange(60.25, 65, 0.25), -2.6357 - np.arange(0.25, 5, 0.25)])
    table = read(write(tmp_path / "wheel.txt", np.vstack([wheel_points(), chamfer])))
    assert 57 * mm < table.domain[1] <= 60.3 * mm  # the kink is found to within its window


def test_smoothing_can_be_set_and_is_recorded(tmp_path):
    path = write(tmp_path / "wheel.txt", wheel_points())
    assert "smoothed at 3 mm" in read(path, smoothing=3e-3).source


@pytest.mark.slow
@settings(max_examples=10, deadline=None)
@given(noise=st.sampled_from([1e-3, 3e-3, 8e-3]), seed=st.integers(0, 1000), step=st.sampled_from([0.05, 0.1, 0.2]))
def test_noise_is_smoothed_until_the_curvature_is_usable(tmp_path_factory, noise, seed, step):
    points = rail_points(step)
    points += noise * np.random.default_rng(seed).standard_normal(points.shape)
    table = read(write(tmp_path_factory.mktemp("noisy") / "rail.txt", points), "rail")
    exact = profile_table("uic60_benchmark_1_40", "rail")
    shift = gauge_point(exact) - gauge_point(table)
    y = np.linspace(-38, 24, 621) * mm
    # Height: the noise itself, and at the 13 mm corners up to 40 um where the cut-off comes near its 10 mm limit.
    error = table.evaluate(y - shift) - exact.evaluate(y)
    normal = (error - np.median(error)) * np.cos(np.arctan(exact.evaluate(y, 1)))
    assert np.max(np.abs(normal)) < 60e-6
    # Curvature on the R300 crown: five times the 0.3 1/m that the smoothing aims at; unsmoothed it is above 100.
    crown = np.linspace(-12, -3, 91) * mm
    assert np.median(np.abs(table.curvature(crown - shift) - exact.curvature(crown))) < 1.5


# ------------------------------------------------------------------ Simpack text

SIMPACK = """! a profile
  header.begin
    version = 1
    type    = {type} ! 0=rail profile, 1=wheel profile
  header.end
  spline.begin
    comment        = 'made by a test'
    type           = 0
    shift.y        = {shift_y}
    rotate         = {rotate}
    bound.y.min    = {low}
    bound.y.max    = {high}
    mirror.y       = {mirror_y}
    mirror.z       = {mirror_z}
    inversion      = {inversion}
    units.len.f    = {factor}
    units.ang.f    = 1000.0
    point.begin
    ! y z
{points}
    point.end
  spline.end
"""
PLAIN = {"type": 1, "shift_y": 0, "rotate": 0, "low": 1, "high": 0, "mirror_y": 0, "mirror_z": 0, "inversion": 0}


def simpack(path, points, factor=1e3, **header):
    rows = "\n".join("\t".join(f"{x:.9E}" for x in row) for row in points)
    path.write_text(SIMPACK.format(**{**PLAIN, **header}, factor=factor, points=rows))
    return path


@pytest.mark.parametrize(
    ("change", "header"),
    [
        (lambda p: p, {}),
        (lambda p: p[::-1], {"inversion": 1}),
        (lambda p: p * [-1, 1], {"mirror_y": 1}),
        (lambda p: p * [1, -1], {"mirror_z": 1}),
        (lambda p: p - [5, 0], {"shift_y": 5}),
        (lambda p: p / 1e3, {"factor": 1.0}),
        (lambda p: np.vstack([[[-150, 3]], p]), {"low": -70, "high": 70}),
        (lambda p: np.column_stack([p, np.ones(len(p))]), {}),
        # 20 mrad: the file is turned back by what the header turns it (y outward, z down, about x)
        (lambda p: p @ np.array([[np.cos(0.02), -np.sin(0.02)], [np.sin(0.02), np.cos(0.02)]]), {"rotate": 20.0}),
    ],
)
def test_simpack_header_processing_is_applied(tmp_path, change, header):
    table = read(simpack(tmp_path / "wheel.prw", change(wheel_points()), **header))
    exact = profile_table("s1002", "wheel")
    s = np.linspace(-59, 59, 1181) * mm
    assert table.evaluate(s) == pytest.approx(exact.evaluate(s), abs=5e-7)
    assert "made by a test" in table.source


def test_a_simpack_rail_is_not_taken_for_a_wheel(tmp_path):
    path = simpack(tmp_path / "rail.prr", wheel_points(), type=0)
    with pytest.raises(ProfileError, match="says it is a rail; it is used as a wheel"):
        read(path)


def test_a_truncated_simpack_file_is_refused(tmp_path):
    path = simpack(tmp_path / "wheel.prw", wheel_points())
    path.write_text(path.read_text().split("point.end")[0])
    with pytest.raises(ProfileError, match=r"no line 'point.end'"):
        read(path)


# ------------------------------------------------------------------ bad files


def spoiled(points, row, value):
    points = points.copy()
    points[row] = value
    return points


def folded(points):  # the abscissa runs back by 2 mm in the middle of the tread, then on
    points = points.copy()
    i = np.searchsorted(points[:, 0], 10.0)
    points[i : i + 16] = points[i : i + 16][::-1]
    return points


def kinked(points):  # an edge of 15 degrees at S = 10 mm
    s, z = points.T
    return np.column_stack([s, z - np.maximum(s - 10, 0) * 0.26])


WHEEL = wheel_points()


@pytest.mark.parametrize(
    ("points", "message"),
    [
        (folded(WHEEL), r"folds back near line \d+, \(1\d\.\d+,"),
        (kinked(WHEEL), r"not smooth: the direction jumps by 1[345].* degrees near line \d+, \((9|10)"),
        (spoiled(WHEEL, 100, np.nan), r"line 101: 'nan nan' is not finite"),
        (spoiled(WHEEL, 7, [1.0, np.inf]), r"line 8: .*inf' is not finite"),
        (WHEEL[::60], r"\d+ points; a profile has at least 20"),
        (WHEEL * 25.4, r"wrong units suspected: the abscissa spans 3"),
        (WHEEL / 25.4, r"wrong units suspected: the abscissa spans 4\.8"),
        (WHEEL[WHEEL[:, 0] > -25], r"no flange: the radius rises"),
        (
            WHEEL[(WHEEL[:, 0] < 10) | (WHEEL[:, 0] > 25)],
            r"a gap of 15.* mm after line \d+, \(9\.\d+, .*\) mm; allowed 5 mm",
        ),
        (WHEEL + [70, 0], r"tape circle \(abscissa 0\) is not in the profile.*set tape_circle"),
        (WHEEL[:, :1], r"line 1: .*: 1 numbers; allowed 2"),
    ],
)
def test_a_bad_wheel_is_refused_with_file_place_and_cure(tmp_path, points, message):
    path = write(tmp_path / "bad.txt", points)
    with pytest.raises(ProfileError, match=message) as caught:
        read(path)
    assert "bad.txt" in str(caught.value)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "the file is empty"),
        ("# only a comment\n", "0 points"),
        ("1 2\n3 four\n", "line 2: '3 four' is not a row of numbers"),
        ("1,5 2,5\n", "line 1: '1,5 2,5' has decimal commas"),
        ("S z\nmm mm\n", "line 2: 'mm mm' is not a row of numbers"),
    ],
)
def test_a_malformed_file_is_refused_with_its_line(tmp_path, text, message):
    path = tmp_path / "bad.txt"
    path.write_text(text)
    with pytest.raises(ProfileError, match=message):
        read(path)


def test_a_missing_file_and_a_folder_are_refused(tmp_path):
    with pytest.raises(ProfileError, match=r"nowhere.txt: cannot be read: No such file"):
        read(tmp_path / "nowhere.txt")
    with pytest.raises(ProfileError, match="cannot be read"):
        profile_from_spec({"kind": "file", "path": str(tmp_path)}, "rail")


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({"smoothing": 3}, "smoothing: 3; allowed 'auto', or a length"),
        ({"smoothing": "much"}, "smoothing: 'much'"),
        ({"z_positive": "up"}, "no flange.*check inner_side and z_positive"),
    ],
)
def test_wrong_keys_of_a_file_are_refused(tmp_path, keys, message):
    path = write(tmp_path / "wheel.txt", WHEEL)
    with pytest.raises(ProfileError, match=message):
        read(path, **keys)


def test_a_tread_without_a_flange_may_be_asked_for(tmp_path):
    path = write(tmp_path / "tread.txt", WHEEL[WHEEL[:, 0] > -25])
    keys = {"require_flange": False, "inner_side": "negative", "z_positive": "down"}
    table = read(path, **keys)
    assert table.domain == pytest.approx((-25 * mm, 60 * mm), abs=0.3 * mm)


@settings(max_examples=60, deadline=None)
@given(
    kind=st.sampled_from(["wheel", "rail"]),
    first=st.integers(0, 400),
    count=st.integers(0, 500),
    every=st.integers(1, 40),
    noise=st.sampled_from([0.0, 0.1, 5.0]),
    repeat=st.sampled_from([1, 2, 30]),
    shuffled=st.booleans(),
    seed=st.integers(0, 99),
)
def test_whatever_the_points_either_a_smooth_profile_comes_out_or_one_clear_error(
    tmp_path_factory, kind, first, count, every, noise, repeat, shuffled, seed
):
    random = np.random.default_rng(seed)
    points = (wheel_points() if kind == "wheel" else rail_points())[first : first + count : every]
    points = np.repeat(points, repeat, axis=0) + noise * random.standard_normal((repeat * len(points), 2))
    points = random.permutation(points) if shuffled else points
    path = write(tmp_path_factory.mktemp("any") / "points.txt", points)
    try:
        table = read(path, kind)
    except ProfileError as error:
        assert str(path) in str(error)  # noqa: PT017 - both outcomes are right
    else:
        y = np.linspace(*table.domain, 500)
        assert np.all(np.isfinite(table.evaluate(y, 2)))
        assert np.max(np.abs(table.evaluate(y, 1))) < 5.5  # the limit of 5, and the last knots' extrapolation
