"""Gauge and inclination along a track, rails that differ left and right: what the keys mean, and mistakes in one line each."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import rollerrig as rr
from catalogued import profile_table
from rollerrig import ConfigError
from rollerrig.config import Track, load_support
from rollerrig.config.schema.support import rail_layout
from rollerrig.config.validate.check_track import check_line
from rollerrig.profiles import gauge_point, profile_from_spec

STRAIGHT = '{ kind = "straight", length = 20 }'
RAMP = '{ kind = "transition", length = 40 }'


def track_of(tmp_path: Path, *segments: str, more: str = "") -> Track:
    file = tmp_path / "line.toml"
    rows = f"segment = [{', '.join(segments)}]\n" if segments else ""
    file.write_text(f'name = "line"\nkind = "track"\nprofile = "en_60e1_1_40"\n{rows}{more}\n')
    track = load_support(file)
    assert isinstance(track, Track)
    return track


def mistakes(tmp_path: Path, *segments: str, more: str = "") -> list[str]:
    with pytest.raises(ConfigError) as error:
        track_of(tmp_path, *segments, more=more)
    return [str(problem).removeprefix(f"{tmp_path}/") for problem in error.value.problems]


def test_a_transition_widens_in_proportion_and_without_corners(tmp_path: Path) -> None:
    wide = '{ kind = "curve", length = 100, radius = "190 m", gauge = "1445 mm" }'
    curves = rail_layout(track_of(tmp_path, STRAIGHT, RAMP, wide, RAMP, STRAIGHT))
    assert curves is not None
    s = np.array([0.0, 30.0, 40.0, 60.0, 150.0, 180.0, 205.0, 400.0])
    half = np.array([0.0, 1.25, 2.5, 5.0, 5.0, 2.5, 0.0, 0.0]) * 1e-3
    half[3] -= 5e-3 / 40 * 4 / 8  # the corner is rounded over 4 m: slope times an eighth of it
    np.testing.assert_allclose(curves["left_y"].evaluate(s), half, atol=1e-15)
    np.testing.assert_allclose(curves["right_y"].evaluate(s), -half, atol=1e-15)
    knots = curves["left_y"].rows[:, 0]
    before, after = (curves["left_y"].evaluate(knots + side, 1) for side in (-1e-9, 1e-9))
    np.testing.assert_allclose(before, after, atol=1e-12)
    assert all(len(curves[name].rows) == 0 for name in ("left_z", "left_roll", "right_z", "right_roll"))


def test_rails_as_the_track_has_them_are_no_layout(tmp_path: Path) -> None:
    assert rail_layout(track_of(tmp_path, STRAIGHT)) is None
    same = '{ kind = "straight", length = 20, gauge = "1435 mm", inclination = "1:40" }'
    curves = rail_layout(track_of(tmp_path, same))
    assert curves is not None
    assert not any(len(curve.rows) for curve in curves.values())


@pytest.mark.parametrize("inclination", ["1:20", "1:30", "1:100"])
def test_a_leaning_rail_lies_where_the_profile_of_that_inclination_does(tmp_path: Path, inclination: str) -> None:
    track = track_of(
        tmp_path, f'{{ kind = "straight", length = 20, gauge = "1440 mm", inclination = "{inclination}" }}'
    )
    curves = rail_layout(track)
    assert curves is not None
    aside, up, lean = (float(curves[f"left_{name}"].evaluate(0.0)) for name in ("y", "z", "roll"))
    own = profile_table("en_60e1_1_40", "rail")
    other = profile_from_spec(
        {"kind": "uic60", "variant": "en_13674", "inclination": 1 / float(inclination[2:])}, "rail"
    )
    y = np.linspace(-0.028, 0.028, 57)
    h = own.evaluate(y)
    turned_y, turned_z = y * np.cos(lean) - h * np.sin(lean), y * np.sin(lean) + h * np.cos(lean)
    from_middle = 1.435 / 2 - gauge_point(own) + aside + turned_y
    expected = other.evaluate(from_middle - (1.440 / 2 - gauge_point(other)))
    np.testing.assert_allclose(up + turned_z, expected, atol=1e-7)  # each is a spline with knots every 0.05 mm
    for name, sign in (("y", -1.0), ("z", 1.0), ("roll", -1.0)):
        np.testing.assert_array_equal(curves[f"right_{name}"].rows[:, 1:], sign * curves[f"left_{name}"].rows[:, 1:])


def test_mistakes_are_one_line_each(tmp_path: Path) -> None:
    wide = '{ kind = "straight", length = 20, gauge = "1445 mm" }'
    assert mistakes(tmp_path, STRAIGHT, wide) == [
        "line.toml: segment[1].gauge: 1.445; allowed: as on segment[0], 1.435 m; between two values put a transition, also on a "
        "straight"
    ]
    leaning = '{ kind = "straight", length = 20, inclination = "1:20" }'
    assert mistakes(tmp_path, leaning, STRAIGHT) == [
        "line.toml: segment[1].inclination: that of the profile; allowed: as on segment[0], 0.05; between two values put a "
        "transition, also on a straight"
    ]
    assert mistakes(tmp_path, leaning, more='right_profile = "cylinder"') == [
        "line.toml: segment[0].inclination: 0.05; the right rail, of kind 'cylinder', has none; allowed with 'uic60' and "
        "'file'; leave it out"
    ]
    worn = '{ kind = "straight", length = 20, profile = "en_60e1_1_20" }'
    assert mistakes(tmp_path, STRAIGHT, worn) == [
        "line.toml: segment[1].profile: another head; allowed: as on segment[0]; between two heads put a transition, also on a "
        "straight"
    ]
    (found,) = mistakes(tmp_path, worn.replace("en_60e1_1_20", "no.txt"))
    assert (
        found
        == f"line.toml: segment[0].profile: the left rail; {tmp_path}/no.txt: cannot be read: No such file or directory"
    )
    (found,) = mistakes(tmp_path, '{ kind = "straight", length = 20, gauge = "1445" }')
    assert found.startswith("line.toml: segment[0].gauge: '1445'; allowed: a number in m or a text with a unit")
    (found,) = mistakes(tmp_path, more='right_profile = "en_60e1_1_30"')
    assert found.startswith("line.toml: right_profile: 'en_60e1_1_30'; allowed: a table with kind, a file of points")
    assert found.endswith(("did you mean 'en_60e1_1_20'?", "did you mean 'en_60e1_1_40'?"))


def test_the_line_of_a_track_without_rails_of_its_own_is_checked_as_before() -> None:
    assert [*check_line(load_support("curved_track_600"))] == []


def test_a_misalignment_whose_moment_the_core_does_not_take_is_refused() -> None:
    case = rr.load_case("bogie_rollers_constant")
    stiff = {"yaw": {"stiffness": 1e12}, "misalignment": [0.0, -1e-3]}
    with pytest.raises(rr.ConfigError, match=r"misalignment: .*allowed: at most 0.0001 rad, a moment"):
        case.with_changes({"support.mounting": stiff})
    assert rr.assemble(case.with_changes({"support.mounting": stiff | {"misalignment": [0.0, -1e-4]}}))
