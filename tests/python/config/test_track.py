"""Tracks with curves, irregularities and foundations: what may be written, and what is refused by name."""

from __future__ import annotations

import math
import re
from pathlib import Path

import numpy as np
import pytest

from rollerrig.config import Case, ConfigError, Track, load_case, load_support
from rollerrig.config.validate.check_track import distance_run, speeds_on

TRACK = """
name = "line"
kind = "track"
profile = "uic60_benchmark_1_40"
"""
CURVE = (
    TRACK
    + """
segment = [
  { kind = "straight", length = "50 m" },
  { kind = "transition", length = "80 m" },
  { kind = "curve", length = "150 m", radius = "600 m", cant = "120 mm" },
  { kind = "transition", length = "80 m", shape = "bloss" },
  { kind = "straight", length = "50 m" },
]
"""
)
CASE = """
name = "on_line"
vehicle = { use = "manchester_vehicle_1", cut = "CUT" }
support = { use = "line.toml" }
contact = { material = "steel" }
motion = { speed_kmh = 100 }
time = { duration = "10 s" }
"""


@pytest.fixture
def line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path / "line.toml"


def case_on(line: Path, track: str, cut: str = "vehicle") -> Case:
    line.write_text(track)
    return load_case_text(CASE.replace("CUT", cut))


def load_case_text(text: str) -> Case:
    Path("case.toml").write_text(text)
    return load_case("case.toml")


def mistakes(line: Path, track: str, case: str = CASE.replace("CUT", "vehicle")) -> list[str]:
    line.write_text(track)
    with pytest.raises(ConfigError) as error:
        load_case_text(case)
    return [str(problem) for problem in error.value.problems]


def test_a_line_is_what_its_segments_say(line: Path) -> None:
    line.write_text(CURVE)
    track = load_support(line)
    assert isinstance(track, Track)
    found = track.line
    assert found is not None
    assert found.length == 410.0
    np.testing.assert_allclose(found.curvature.evaluate([0, 90, 200, 320, 400]), np.array([0, 0.5, 1, 0.5, 0]) / 600)
    np.testing.assert_allclose(found.cant.evaluate([0, 90, 200, 320, 400]), np.array([0, 0.5, 1, 0.5, 0]) * 0.12)
    assert float(found.heading(410.0)) == pytest.approx(230 / 600, rel=1e-14)


def test_a_curve_to_the_right_is_the_mirror_image(line: Path) -> None:
    line.write_text(CURVE.replace('radius = "600 m"', 'radius = "600 m", direction = "right"'))
    mirrored = load_support(line).line
    line.write_text(CURVE)
    straight = load_support(line).line
    np.testing.assert_array_equal(mirrored.curvature.rows[:, 1:], -straight.curvature.rows[:, 1:])
    np.testing.assert_array_equal(mirrored.cant.rows[:, 1:], -straight.cant.rows[:, 1:])


def test_a_track_without_segments_has_no_line() -> None:
    assert load_support("uic60_track").line is None


def test_a_case_is_written_with_all_of_its_track(line: Path) -> None:
    more = '\nirregularity = { kind = "ore_b176", level = "low", seed = 3 }\n'
    more += "foundation = { rail_mass = 60, vertical = { stiffness = 1e8 } }\n"
    case = case_on(line, CURVE + more)
    Path("copy.toml").write_text(case.to_toml())
    assert load_case("copy.toml") == case


S = 'segment = [{ kind = "straight", length = 50 }'


@pytest.mark.parametrize(
    ("track", "expected"),
    [
        (S + ', { kind = "curve", length = 50, radius = 300, cant = "0.1 m" }]',
         "line.toml: segment[1]: a curve; segments do not join: segment[0] ends with no curvature, segment[1] begins with a "
         "radius of 300 m to the left and 100 mm of cant; put a transition between them"),
        (S.replace("straight", "curve").replace("50 }", "50, radius = 300 }")
         + ', { kind = "curve", length = 50, radius = 300, direction = "right" }]',
         "line.toml: segment[1]: a curve; segments do not join: segment[0] ends with a radius of 300 m to the left and 0 mm "
         "of cant, segment[1] begins with a radius of 300 m to the right and 0 mm of cant; put a transition between them"),
        (S + ', { kind = "transition", length = 50 }]',
         "line.toml: segment[1].kind: 'transition'; segments do not join; allowed: a transition between straights or curves, "
         "which it joins"),
        (S + ', { kind = "curve", length = 50, radius = 300, cant = "301 mm" }]',
         "line.toml: segment[1].cant: '301 mm'; allowed: a number in m or a text with a unit like '10 mm', from -0.3 "
         "to 0.3 m"),
        (S + ', { kind = "curve", length = 50, radius = -300 }]',
         "line.toml: segment[1].radius: -300; allowed: a number in m or a text with a unit like '100 m', from 20 to 1e+07 m"),
        (S + ', { kind = "bend", length = 50 }]',
         "line.toml: segment[1].kind: 'bend'; allowed: straight, transition, curve"),
        ('irregularity = { kind = "ore_b176", level = "lower" }',
         "line.toml: irregularity.level: 'lower'; allowed: low, high; did you mean 'low'?"),
        ('irregularity = { kind = "ore_b176", level = "low", seed = 1.5 }',
         "line.toml: irregularity.seed: 1.5; allowed: a whole number"),
        ('irregularity = { kind = "ore_b176", level = "low", longest_wavelength = 2 }',
         "line.toml: irregularity.longest_wavelength: 2; allowed: at least shortest_wavelength, 3 m"),
        ('irregularity = { kind = "file", path = "no.csv" }', None),
        ("foundation = { rail_mass = 60 }",
         "line.toml: foundation.lateral: missing; needed: a support along y, z or about the foot, as in flexible_track; else "
         "leave it out"),
        ("foundation = { lateral = { stiffness = 0 } }",
         "line.toml: foundation.lateral.stiffness: 0; allowed: a number in N/m or a text with a unit like '3.9 MN/m', from "
         "1e-06 to 1e+13 N/m"),
        ("foundation = { sleeper = {}, lateral = { stiffness = 1e7 } }",
         "line.toml: foundation.sleeper.vertical: missing; needed: ballast along y or z; without both leave out the sleeper"),
        ("foundation = { vertical = { stiffness = 100 } }",
         "case.toml: support.data.foundation.vertical.stiffness: 100; under the wheel load, 54.5 kN, the rail's head moves by "
         "5.5e+05 mm; allowed: 2.7e+06 to 5.5e+11 N/m; flexible_track has typical values; for a rigid rail leave it out"),
        ("foundation = { roll = { stiffness = 1e4 } }",
         "case.toml: support.data.foundation.roll.stiffness: 10000; under the wheel load, 54.5 kN, the rail's head moves by "
         "1.6e+02 mm; allowed: 8.1e+04 to 1.6e+10 N m/rad; flexible_track has typical values; for a rigid rail leave it out"),
        ('foundation = { rail_mass = "1 g", vertical = { stiffness = 1e8 } }',
         "case.toml: support.data.foundation.rail_mass: 0.001 kg; allowed under the wheel load, 54.5 kN: 5.6 to 5.6e+04 kg; "
         "flexible_track has typical values"),
        ("foundation = { lateral = { stiffness = 4e7, damping = 1e9 } }",
         "case.toml: support.data.foundation.lateral.damping: 1e+09; allowed: at most 8e+06 N s/m, 0.2 s times the stiffness; "
         "flexible_track has typical values"),
        ("foundation = { roll = { stiffness = 4e5, damping = 1e6 } }",
         "case.toml: support.data.foundation.roll.damping: 1e+06; allowed: at most 8e+04 N m s/rad, 0.2 s times the stiffness; "
         "flexible_track has typical values"),
        ('gauge = "1.48 m"',
         "case.toml: support.data.gauge: 1.48; wheel and rail of different gauge: the flanges, 1425.0 mm across, stand far "
         "inside of the rails; allowed: a gauge 1.425 to 1.465 m, or another wheel.back_to_back (1360 mm)"),
        ('gauge = "1.42 m"',
         "case.toml: support.data.gauge: 1.42; wheel and rail of different gauge: the flanges, 1425.0 mm across, do not fit "
         "between the rails; allowed: a gauge 1.425 to 1.465 m, or another wheel.back_to_back (1360 mm)"),
    ],
)  # fmt: skip
def test_a_mistake_is_one_line(line: Path, track: str, expected: str | None) -> None:
    found = mistakes(line, f"{TRACK}{track}\n")
    if expected is None:
        assert found[0].startswith("line.toml: irregularity.path: '")
        assert found[0].endswith("; cannot be read: No such file or directory")
    else:
        assert found == [expected]


def test_a_curve_tighter_than_the_wheelbase_is_refused_with_the_least_radius(line: Path) -> None:
    """R such that two wheelsets 8 m apart, askew by 4 m / R, fill the play of 10 mm: sqrt(r tan(delta) / play) 4 m."""
    wagon = Path(__file__).parents[1] / "two_axle_wagon.toml"
    case = load_case(wagon)
    least = 4.0 * math.sqrt(0.46 * math.tan(math.radians(70.0)) / 0.010)
    for radius, allowed in ((0.9 * least, False), (1.1 * least, True)):
        line.write_text(f'{TRACK}\nsegment = [{{ kind = "curve", length = 50, radius = {radius} }}]\n')
        change = {"support": {"use": str(line)}, "motion.speed": "1 m/s", "motion.drive": "speed_controlled"}
        if allowed:
            case.with_changes(change)
            continue
        with pytest.raises(ConfigError) as error:
            case.with_changes(change)
        assert re.search(
            r": support\.segment\[0\]\.radius: 40\.\d+ m; tighter than the wheelbase of two_axle_wagon allows: 2 wheelsets under "
            r"car_body, 8 m, jam in the gauge, whose play is 10\.0 mm; allowed: at least 4[45](\.\d)? m$",
            str(error.value),
        ), str(error.value)


def test_a_speed_beyond_overturning_is_refused_with_the_highest_allowed(line: Path) -> None:
    """130 mm of cant on 600 m: the vehicle of 1.47 m height overturns beyond 215 km/h."""
    case = CASE.replace("CUT", "vehicle").replace("speed_kmh = 100", "speed_kmh = 230")
    (found,) = mistakes(line, CURVE, case)
    assert found.startswith(
        "case.toml: motion.speed: 230 km/h; speed beyond overturning on support.data.segment[2], radius 600 m, cant 120 mm: "
    )
    highest = float(found.split("at most ")[1].split()[0])
    assert 200 < highest < 225
    load_case_text(case.replace("230", f"{highest - 1}"))


def test_a_low_vehicle_climbs_before_it_overturns(line: Path) -> None:
    case = CASE.replace("CUT", "leading_wheelset").replace("speed_kmh = 100", "speed_kmh = 400")
    assert "speed beyond flange climb on support.data.segment[2]" in mistakes(line, CURVE, case)[0]


def test_a_curve_that_is_not_reached_is_no_obstacle(line: Path) -> None:
    line.write_text(CURVE)
    load_case_text(CASE.replace("CUT", "vehicle").replace("speed_kmh = 100", "speed_kmh = 300").replace("10 s", "1 s"))


def test_the_speed_in_a_curve_is_that_of_the_table(line: Path) -> None:
    """From 20 m/s at 2 m/s^2: v^2 = 400 + 4 s; the curve lies from 130 to 280 m."""
    line.write_text(CURVE)
    table = 'motion = { speed_table = [[0, "20 m/s"], [10, "40 m/s"]] }'
    case = load_case_text(CASE.replace("CUT", "vehicle").replace("motion = { speed_kmh = 100 }", table))
    assert distance_run(case.motion, 10.0) == pytest.approx(300.0)
    low, high = speeds_on(case, case.support.data.line.segments[2]) or (0.0, 0.0)
    assert (low, high) == (
        pytest.approx((400 + 4 * 130) ** 0.5, rel=1e-5),
        pytest.approx((400 + 4 * 280) ** 0.5, rel=1e-5),
    )
    assert speeds_on(case.with_changes({"time.duration": "2 s"}), case.support.data.line.segments[2]) is None


def test_a_measured_file_shorter_than_the_run_is_refused(line: Path) -> None:
    rows = "\n".join(f"{0.25 * i}, 0.0" for i in range(1000))
    Path("rails.csv").write_text(f"distance [m], vertical [mm]\n{rows}\n")
    track = TRACK + 'irregularity = { kind = "file", path = "rails.csv" }'
    (found,) = mistakes(line, track)
    assert "shorter than the run: it reaches from 0 to 249.75 m, the wheels run from 0 to 277.778 m of it" in found
    case = CASE.replace("CUT", "vehicle").replace("10 s", "8 s")
    assert load_case_text(case).support.data.irregularity.path == str(Path("rails.csv").absolute())


def test_an_irregularity_on_rollers_needs_controlled_rollers(tmp_path: Path) -> None:
    case = load_case("bogie_rollers_traction")
    with pytest.raises(
        ConfigError, match=r"motion\.drive: 'free'; allowed with an irregularity that is fed to the rollers"
    ):
        case.with_changes({"support.irregularity": {"kind": "ore_b176", "level": "low"}})
    load_case("bogie_rollers_constant").with_changes({"support.irregularity": {"kind": "ore_b176", "level": "low"}})
