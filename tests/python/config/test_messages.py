"""Bad input: every mistake is one line that says file, key, value, what is allowed and, where it can, what was meant."""

from __future__ import annotations

from pathlib import Path

import pytest

from rollerrig.catalog import catalog_text
from rollerrig.config import ConfigError, Contact, load_any, load_case, load_vehicle
from rollerrig.config.errors import show_value
from rollerrig.config.schema.actuators import Brake
from rollerrig.config.schema.rig_control import ESTIMATORS, KalmanFilter, NoFeedback

from .conftest import MistakesOf, spoil

PRIMARY = 'between = ["front_frame", "wheelset_1"]\npoint = [10.78, 1.0, 0.46]'


@pytest.mark.parametrize(
    ("part", "old", "new", "line"),
    [
        # unknown key
        ("case", "friction = 0.3", "frction = 0.3",
         "case.toml: contact.frction: unknown key (= 0.3); allowed: " + ", ".join(Contact.model_fields)
         + "; did you mean 'friction'?"),
        ("vehicle", "carries_load = true", "carries_lod = true", None),
        # wrong unit or type
        ("case", 'speed = "150 km/h"', 'speed = "150 kN"',
         "case.toml: motion.speed: '150 kN'; allowed: a number in m/s or a text with a unit like '100 km/h', "
         "from 0 to 200 m/s, with its unit written beyond 10 m/s"),
        ("case", 'speed = "150 km/h"', "speed_mm = 150",
         "case.toml: motion.speed_mm: '150 mm'; allowed: a number in m/s or a text with a unit like '100 km/h', "
         "from 0 to 200 m/s, with its unit written beyond 10 m/s"),
        ("case", 'duration = "10 s"', "duration = true",
         "case.toml: time.duration: true; allowed: a number in s or a text with a unit like '10 ms', "
         "from 1e-06 to 100000 s"),
        ("case", "[contact]", "[contact]\ncreep = { kind = 'kalker_saturated', saturate_spin_moment = 'yes' }",
         "case.toml: contact.creep.saturate_spin_moment: 'yes'; allowed: true or false"),
        # negative mass, impossible inertia
        ("vehicle", 'mass = "32000 kg"', "mass = -32000",
         "vehicle.toml: body.car_body.mass: -32000; allowed: a number in kg or a text with a unit like '1813 kg', "
         "from 1e-05 to 1e+08 kg"),
        ("vehicle", "inertia = [56.8e3, 1.970e6, 1.970e6]", "inertia = [56.8e3, 1.970e6, 3.0e6]",
         "vehicle.toml: body.car_body.inertia: [56800.0, 1970000.0, 3000000.0]; allowed: no moment of inertia may exceed "
         "the sum of the other two"),
        ("vehicle", "inertia = [56.8e3, 1.970e6, 1.970e6]", "inertia = [56.8e3, 0, 1.970e6]",
         "vehicle.toml: body.car_body.inertia[1]: 0; allowed: a number in kg m^2 or a text with a unit like "
         "'1120 kg m^2', from 1e-10 to 1e+10 kg m^2"),
        # a disturbance off the rig
        ("case", 'lateral = "3 mm"', 'lateral = "3 m"',
         "case.toml: disturbance.wheelset_1.lateral: '3 m'; allowed: a number in m or a text with a unit like '10 mm', "
         "from -0.1 to 0.1 m"),
        # zero roller radius
        ("support", 'roller_radius = "725 mm"', "roller_radius = 0",
         "support.toml: roller_radius: 0; allowed: a number in m or a text with a unit like '460 mm', "
         "from 0.001 to 1e+06 m, with its unit written beyond 10 m"),
        ("case", 'use = "full_scale_rig"', 'use = "full_scale_rig"\nroller_radius = "0 mm"',
         "case.toml: support.roller_radius: '0 mm'; allowed: a number in m or a text with a unit like '460 mm', "
         "from 0.001 to 1e+06 m, with its unit written beyond 10 m"),
        # speed table out of order, NaN
        ("case", 'speed = "150 km/h"', "speed_table = [[0, 1], [5, 2], [3, 3]]",
         "case.toml: motion.speed_table: [[0, 1], [5, 2], [3, 3]]; allowed: rows in ascending order of their first "
         "column, each once; 3 follows 5"),
        ("case", 'speed = "150 km/h"', "speed_table = [[0, 1], [0, 2]]",
         "case.toml: motion.speed_table: [[0, 1], [0, 2]]; allowed: rows in ascending order of their first "
         "column, each once; 0 follows 0"),
        ("case", 'speed = "150 km/h"', "speed_table = [[0, 10], [5, nan]]",
         "case.toml: motion.speed_table[1][1]: nan; allowed: a number in m/s or a text with a unit like "
         "'100 km/h', from 0 to 200 m/s, with its unit written beyond 10 m/s"),
        ("case", 'speed = "150 km/h"', "speed = 1\nspeed_table = [[0, 2], [5, 3]]",
         "case.toml: motion.speed_table: [[0, 2], [5, 3]]; allowed: a first row at time 0 with motion.speed; "
         "[0, 2] is not that"),
        ("case", 'drive = "speed_controlled"', 'drive = "torque"',
         "case.toml: motion.torque_table: missing; needed for drive = 'torque'"),
        ("vehicle", '  ["-25 mm", 0.0],', '  ["-25 mm", 0.0],\n  ["-25 mm", 3.0],', None),
        # missing file
        ("case", '"full_scale_rig"', '"ful_scale_rig"',
         "case.toml: support.use: 'ful_scale_rig'; no such file; allowed: a TOML file, or a support of the catalogue: "
         "contact_benchmark_rail, contact_benchmark_roller, curved_track_190, curved_track_300, curved_track_600, en_60e1_track, "
         "flexible_track, full_scale_rig, textbook_track, uic60_track; "
         "did you mean 'full_scale_rig'?"),
        ("case", 'material = "steel"', 'material = "my/steel.toml"',
         "case.toml: contact.material: 'my/steel.toml'; no such file; there is no folder 'my'"),
        # names
        ("case", 'cut = "leading_bogie"', 'cut = "leading_bogy"',
         "case.toml: vehicle.cut: 'leading_bogy'; allowed: vehicle, leading_bogie, leading_wheelset; "
         "did you mean 'leading_bogie'?"),
        ("case", 'body = "wheelset_1"', 'body = "car_body"',
         "case.toml: disturbance.car_body.body: 'car_body'; allowed: front_frame, wheelset_1, wheelset_2"),
        ("vehicle", PRIMARY, PRIMARY.replace("front", "fromt"),
         "vehicle.toml: element.primary_1_left.between: 'fromt_frame'; allowed: car_body, front_frame, rear_frame, "
         "wheelset_1, wheelset_2, wheelset_3, wheelset_4; did you mean 'front_frame'?"),
        ("vehicle", 'name = "primary_1_left"', 'name = "primary_1_right"',
         "vehicle.toml: element[1].name: 'primary_1_right'; allowed: each name once"),
        ("vehicle", 'fixed = ["car_body"]', 'fixed = ["carbody"]',
         "vehicle.toml: cut.leading_bogie.fixed: 'carbody'; allowed: car_body, front_frame, rear_frame, wheelset_1, "
         "wheelset_2, wheelset_3, wheelset_4; did you mean 'car_body'?"),
        # geometry
        ("vehicle", PRIMARY, PRIMARY.replace("10.78", "10.7"),
         "vehicle.toml: element.primary_1_left.point: [10.7, 1.0, 0.46]; allowed: a point on the axle of wheelset_1, "
         "which does not turn with it: [10.78, y, 0.46]"),
        ("vehicle", PRIMARY, PRIMARY.replace('"front_frame", "wheelset_1"', '"wheelset_1", "front_frame"'),
         "vehicle.toml: element.primary_1_left.between: ['wheelset_1', 'front_frame']; allowed: the wheelset as the "
         "second of the two, since the force acts at the end on the second body"),
        ("vehicle", 'radius = "460 mm"', 'radius = "450 mm"', None),
        # contact, time
        ("case", "friction = 0.3", "friction = -0.1",
         "case.toml: contact.friction.mu_0: -0.1; allowed: a number, from 0 to 1.5"),
        ("case", "friction = 0.3", "friction = 1.6",
         "case.toml: contact.friction.mu_0: 1.6; allowed: a number, from 0 to 1.5"),
        ("case", "friction = 0.3", 'friction = { kind = "constant", mu_0 = "0.3 m" }',
         "case.toml: contact.friction.mu_0: '0.3 m'; allowed: a number without a unit, from 0 to 1.5"),
        ("case", 'method = "exponential_adams"', 'method = "rk5"',
         "case.toml: time.method: 'rk5'; allowed: rodas4, rk4, exponential_rk4, exponential_adams, "
         "dormand_prince; did you mean 'rk4'?"),
        ("case", '\nstep = "2 ms"', "",
         "case.toml: time.step: missing; needed: the step of the fixed-step method exponential_adams, e.g. step = '0.1 ms'"),
        ("case", 'output_step = "2 ms"', 'output_step = "20 s"',
         "case.toml: time.output_step: '20 s'; allowed: at most the duration, 10 s"),
        # missing, of a list and in one
        ("support", "roller_inertia = [1800.0, 705.0, 1800.0]", "",
         "support.toml: roller_inertia: missing; needed: moments of inertia of a pair about x, y (spin) and z through its "
         "centre [kg m^2]"),
        ("case", "[time]", "[brake]\n\n[time]",
         f"case.toml: brake.demand: missing; needed: {Brake.model_fields['demand'].description} [s, Pa]"),
        ("case", "[time]", "[brake]\ndemand = [[0, 0], ['1 s']]\n\n[time]",
         "case.toml: brake.demand[1][1]: missing; needed: a number in Pa or a text with a unit like '3.8 bar', "
         "from 0 to 1e+08 Pa"),
        # torque
        ("case", "[time]", '[[axle_torque]]\nwheelset = "front_frame"\nconstant = "1 kN m"\n\n[time]',
         "case.toml: axle_torque.front_frame.wheelset: 'front_frame'; allowed: wheelset_1, wheelset_2"),
        ("case", "[time]", '[[axle_torque]]\nwheelset = "wheelset_1"\nconstant = 1\nreacts_on = "rear_frame"\n\n[time]',
         "case.toml: axle_torque.wheelset_1.reacts_on: 'rear_frame'; allowed: none, front_frame, wheelset_2, car_body; "
         "did you mean 'front_frame'?"),
        ("case", "[time]", '[[axle_torque]]\nwheelset = "wheelset_1"\n\n[time]',
         "case.toml: axle_torque.wheelset_1.table: missing; allowed: one of `constant = torque` and "
         "`table = [[time, torque], ...]`"),
        # profile
        ("support", 'profile = "uic60_benchmark_1_40"', 'profile = { kind = "uic60", variant = "bench" }',
         "support.toml: profile.variant: 'bench'; allowed: en_13674, benchmark; did you mean 'benchmark'?"),
        ("support", 'profile = "uic60_benchmark_1_40"', 'profile = "s1002"',
         "support.toml: profile: 's1002'; kind: 's1002' is a wheel profile and cannot be used as a rail"),
    ],
)  # fmt: skip
def test_a_mistake_is_one_line(mistakes_of: MistakesOf, part: str, old: str, new: str, line: str | None) -> None:
    mistakes = mistakes_of(old, new, part)
    if line is not None:
        assert [str(mistake) for mistake in mistakes] == [line]
    assert {mistake.file for mistake in mistakes} == {f"{part}.toml"}


def test_a_wheelset_stands_on_its_wheels(mistakes_of: MistakesOf) -> None:
    mistakes = mistakes_of('radius = "460 mm"', 'radius = "450 mm"', "vehicle")
    assert str(mistakes[0]) == (
        "vehicle.toml: body.wheelset_1.position: [10.78, 0.0, 0.46]; allowed for a wheelset: [x, 0, 0.45], "
        "its wheels of radius 0.45 m standing at z = 0"
    )
    assert len(mistakes) == 4


def test_a_wheel_that_misses_the_roller_is_told_where_both_are(mistakes_of: MistakesOf) -> None:
    mistakes = mistakes_of('gauge = "1435 mm"', 'gauge = "1 m"', "support")
    assert [(m.key, m.value) for m in mistakes] == [("support.data.gauge", "1.0")]
    assert mistakes[0].allowed.startswith(
        "the wheels miss the rollers: the tape circle lies 750.0 mm from the middle, the running surface from 500."
    )


def test_all_mistakes_of_all_files_come_at_once(folder: Path) -> None:
    (folder / "vehicle.toml").write_text(
        spoil(
            spoil(catalog_text("manchester_vehicle_1"), '"32000 kg"', "-1"), 'fixed = ["car_body"]', 'fixed = ["car"]'
        )
    )
    (folder / "rig.toml").write_text(spoil(catalog_text("full_scale_rig"), '"2980 kg"', '"2980 m"'))
    case = catalog_text("bogie_rollers_constant")
    for old, new in (
        ('"manchester_vehicle_1"', '"vehicle.toml"'),
        ('"full_scale_rig"', '"rig.toml"'),
        ('"exponential_adams"', '"rk"'),
        ("friction", "fiction"),
        ("lateral", "sideways"),
    ):
        case = spoil(case, old, new)
    (folder / "case.toml").write_text(case)
    with pytest.raises(ConfigError) as error:
        load_case(folder / "case.toml")
    found = [(Path(m.file).name, m.key) for m in error.value.problems]
    assert sorted(found) == [
        ("case.toml", "contact.fiction"),
        ("case.toml", "disturbance.wheelset_1.sideways"),
        ("case.toml", "time.method"),
        ("rig.toml", "roller_mass"),
        ("vehicle.toml", "body.car_body.mass"),
        ("vehicle.toml", "cut.leading_bogie.fixed"),
    ]
    assert str(error.value).count("\n") == 5


def line_of(source: object) -> str:
    with pytest.raises(ConfigError) as error:
        load_case(source)  # type: ignore[arg-type]
    return str(error.value)


@pytest.mark.parametrize(("name", "kind"), [("manchester_vehicle_1", "vehicle"), ("full_scale_rig", "support")])
def test_what_is_no_case_is_told_as_what_it_is(folder: Path, name: str, kind: str) -> None:
    assert line_of(name).startswith(f"{name}: a {kind}, not a case; needed: a case that uses it")
    (folder / "mine.toml").write_text(catalog_text(name))
    assert line_of(folder / "mine.toml").startswith(f"{folder / 'mine.toml'}: a {kind}, not a case")


def test_a_missing_case_names_the_nearest(folder: Path) -> None:
    line = line_of("bogie_rollers_rmp.toml")
    assert line == (
        "bogie_rollers_rmp.toml: no such file; allowed: a TOML file that exists, or a case that `rollerrig catalog` lists; did "
        "you mean 'bogie_rollers_ramp'?"
    )
    assert "a case of the catalogue: adhesion_brake, " in line_of("bogie_rollers_rmp")


def test_a_missing_file_names_the_nearest_beside_it(folder: Path) -> None:
    (folder / "sub").mkdir()
    (folder / "sub" / "my_case.toml").write_text("")
    (folder / "y.toml").write_text("")  # has nothing in common with x.toml but the suffix
    assert line_of("sub/mycase.toml").endswith("`rollerrig catalog` lists; did you mean 'sub/my_case.toml'?")
    assert line_of("x.toml") == (
        "x.toml: no such file; allowed: a TOML file that exists, or a case that `rollerrig catalog` lists"
    )
    assert line_of("sab/my_case.toml") == "sab/my_case.toml: no such file; there is no folder 'sab'"


def test_a_file_that_cannot_be_read_says_so(folder: Path) -> None:
    (folder / "bad.toml").write_bytes(b"name = '\xff'")
    assert line_of("bad.toml") == "bad.toml: byte 8 is not UTF-8; allowed: a text"
    (folder / "bad.toml").write_text("a = 1\nb = \n")
    assert line_of("bad.toml") == "bad.toml: not TOML; Invalid value (at line 2, column 5)"
    (folder / "dir.toml").mkdir()
    assert line_of("dir.toml") == "dir.toml: a folder, not a regular file; allowed: a TOML file that can be read"


def test_a_mistake_in_a_file_of_points_names_the_file_that_refers_to_it(mistakes_of: MistakesOf) -> None:
    (mistake,) = mistakes_of('"uic60_benchmark_1_40"', '"points.txt"', "support")
    assert (mistake.file, mistake.key) == ("support.toml", "profile")
    assert "cannot be read: No such file or directory" in mistake.allowed


def test_nan_in_a_file_of_points_is_told(mistakes_of: MistakesOf, folder: Path) -> None:
    rows = [f"{y} {-0.001 * y * y}" for y in range(-36, 37)]
    (folder / "points.txt").write_text("\n".join([*rows[:20], "0 nan", *rows[20:]]))
    (mistake,) = mistakes_of('"uic60_benchmark_1_40"', '"points.txt"', "support")
    assert mistake.key == "profile"
    assert "nan" in mistake.allowed


def test_an_empty_file_lists_what_a_case_needs(folder: Path) -> None:
    (folder / "empty.toml").write_text("")
    lines = line_of("empty.toml").splitlines()
    assert [line.split(": ")[1] for line in lines] == ["name", "vehicle", "support", "contact", "motion", "time"]


def test_a_vehicle_alone_is_checked_too(folder: Path) -> None:
    (folder / "v.toml").write_text(spoil(catalog_text("manchester_vehicle_1"), '"32000 kg"', '"32000 m"'))
    for load in (load_vehicle, load_any):
        with pytest.raises(ConfigError, match=r"v\.toml: body\.car_body\.mass: '32000 m'; allowed: a number in kg"):
            load("v.toml")


def test_a_damper_may_not_feed_energy(mistakes_of: MistakesOf) -> None:
    new = "x = { damping_table = [[-1, -5], [0, 0], [1, -5]] }\ny = {"
    mistake = mistakes_of('y = { stiffness = "160 kN/m" }\n', new + ' stiffness = "160 kN/m" }\n', "vehicle")[0]
    assert "TOML" in mistake.value  # x is given twice
    mistake = mistakes_of(
        'x = { stiffness = "160 kN/m" }\n', "x = { damping_table = [[-1, -5], [0, 0], [1, -5]] }\n", "vehicle"
    )[0]
    assert mistake.key == "element.secondary_spring_front_left.x.damping_table"
    assert mistake.allowed.endswith("[1, -5] would feed energy")


@pytest.mark.parametrize(
    ("new", "meant"),
    [
        ("[contact]\nmerge_barrier = 0.01", "contact.normal.merging_criterion"),
        ("[contact.normal]\nkind = 'hertz'\nmerge_barrier = 0.01\n[contact]", "merging_criterion"),
        ("[contact]\npolach = { stick_reduction = 1.0 }", "creep"),
        ("[contact]\nstandstill_speed = 0.1", "creepage_regularisation_speed"),
        ("[anti_slip]\n[contact]", "wheel_slip_control"),
        ("[contact]\nideal_rolling = true", "pure_rolling"),
        ("[adhesion]\nrail = {start = 0.1}\n[contact]", "friction"),
    ],
)
def test_a_former_key_leads_to_the_present_one(mistakes_of: MistakesOf, new: str, meant: str) -> None:
    assert meant in [problem.hint for problem in mistakes_of("[contact]", new)]


def test_a_former_word_leads_to_the_present_one(mistakes_of: MistakesOf) -> None:
    (problem,) = mistakes_of('drive = "speed_controlled"', 'drive = "held"')
    assert problem.hint == "speed_controlled"


@pytest.mark.parametrize(
    ("old", "new", "line"),
    [
        ('speed = "150 km/h"', 'speed = "150 km/h"\nspeed_kmh = 150',
         "case.toml: motion.speed_kmh: 150; allowed: one of `speed` and `speed_kmh`"),
        ('method = "exponential_adams"', 'method = "Exponential_Adams"',
         "case.toml: time.method: 'Exponential_Adams'; allowed: rodas4, rk4, exponential_rk4, exponential_adams, "
         "dormand_prince; did you mean 'exponential_adams'?"),
        ('drive = "speed_controlled"', 'drive = "Speed_Controlled"',
         "case.toml: motion.drive: 'Speed_Controlled'; allowed: speed_controlled, free, torque; did you mean "
         "'speed_controlled'?"),
        ('cut = "leading_bogie"', 'cut = "LEADING_BOGIE"',
         "case.toml: vehicle.cut: 'LEADING_BOGIE'; allowed: vehicle, leading_bogie, leading_wheelset; did you mean "
         "'leading_bogie'?"),
        ("friction = 0.3", "Friction = 0.3",
         "case.toml: contact.Friction: unknown key (= 0.3); allowed: " + ", ".join(Contact.model_fields)
         + "; did you mean 'friction'?"),
    ],
)  # fmt: skip
def test_what_was_meant_is_told(mistakes_of: MistakesOf, old: str, new: str, line: str) -> None:
    assert [str(mistake) for mistake in mistakes_of(old, new)] == [line]


def test_a_unit_in_the_key_of_a_table_is_told(mistakes_of: MistakesOf) -> None:
    mistakes = mistakes_of('speed = "150 km/h"', "speed_table_kmh = [[0, 10], [5, 20]]")
    told = {mistake.key: mistake.allowed for mistake in mistakes}
    assert told["motion.speed_table_kmh"] == "allowed: `speed_table`, with a unit in its values"


def test_rollers_with_a_controller_are_free(tmp_path: Path) -> None:
    text = load_case("adhesion_brake").to_toml()
    (tmp_path / "case.toml").write_text(spoil(text, 'drive = "free"', 'drive = "torque"'))
    with pytest.raises(ConfigError) as error:
        load_case(tmp_path / "case.toml")
    (problem,) = error.value.problems
    assert (problem.key, problem.value) == ("motion.drive", "'torque'")
    assert (
        problem.allowed == "allowed with [rig_control]: 'free', its drives act on the rollers; no motion.torque_table"
    )


def test_an_example_fits_its_key(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match=r"a text with a unit like '3\.8 bar'"):
        load_case("adhesion_brake").with_changes({"brake.demand": [[0, "x"], [1, 0]]})


@pytest.mark.parametrize(
    ("changes", "line"),
    [
        ({"rig_control.estimator": "kalmann"},
         f"rig_control.estimator: 'kalmann'; allowed: {', '.join(ESTIMATORS)}; did you mean 'kalman'?"),
        ({"rig_control.estimator": {"kind": "Luenberger"}},
         f"rig_control.estimator.kind: 'Luenberger'; allowed: {', '.join(ESTIMATORS)}; did you mean 'observer'?"),
        ({"rig_control.estimator": {"speed_noise": 1e-3}},
         "rig_control.estimator.speed_noise: unknown key (= 0.001); allowed: torque, bandwidth, kind, damping_ratio"),
        ({"rig_control.estimator": {"kind": "exact", "bandwidth": 20}},
         "rig_control.estimator.bandwidth: unknown key (= 20); allowed: torque, kind"),
        ({"rig_control.feedback": {"kind": "none", "proportional": 1e3}},
         "rig_control.feedback.proportional: unknown key (= 1000.0); allowed: largest, kind"),
        ({"rig_control.feedback": {"kind": "proportional_integral", "switching": 1e3}},
         "rig_control.feedback.switching: unknown key (= 1000.0); allowed: largest, kind, bandwidth, damping_ratio, "
         "proportional, integral"),
    ],
)  # fmt: skip
def test_a_key_of_another_kind_is_refused(changes: dict[str, object], line: str) -> None:
    with pytest.raises(ConfigError) as error:
        load_case("adhesion_brake").with_changes(changes)
    assert str(error.value) == f"adhesion_brake (changed): {line}"


def test_a_name_alone_and_a_new_kind_ask_for_its_defaults() -> None:
    case = load_case("adhesion_brake").with_changes(
        {"rig_control.estimator.damping_ratio": 0.5, "rig_control.feedback": "none"}
    )
    control = case.rig_control
    assert control is not None
    assert control.feedback == NoFeedback(kind="none")
    other = case.with_changes({"rig_control.estimator.kind": "kalman"}).rig_control
    assert other is not None
    assert other.estimator == KalmanFilter(kind="kalman", bandwidth=control.estimator.bandwidth)


def test_a_long_path_keeps_its_file_name_in_a_message() -> None:
    path = "/somewhere/" + 20 * "long/" + "wheel_profile.toml"
    shown = show_value(path)
    assert len(shown) == 80
    assert shown.startswith("'/somewhere/")
    assert shown.endswith("wheel_profile.toml'")
