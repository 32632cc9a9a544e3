"""Cases that say only what is different from another one: written short, read again, printed, compared."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pint
import pytest

from rollerrig.cases import on_rig, on_track
from rollerrig.catalog import catalog_names
from rollerrig.config import Case, ConfigError, case_from_toml, load_case


@pytest.fixture(scope="module")
def bogie() -> Case:
    return load_case("bogie_rollers_constant")


# ------------------------------------------------------------------------------------------------------ written short


def test_a_case_of_another_speed_is_four_lines_and_reads_as_the_same(bogie: Case, tmp_path: Path) -> None:
    changed = bogie.with_changes({"motion.speed": "120 km/h"})
    changed.save(tmp_path / "mine.toml")
    lines = (tmp_path / "mine.toml").read_text().splitlines()
    assert lines == ['base = "bogie_rollers_constant"', "", "[motion]", 'speed = "120 km/h"']
    assert load_case(tmp_path / "mine.toml") == changed


@pytest.mark.parametrize("name", catalog_names("case"))
def test_every_case_with_a_change_is_written_short_and_reads_as_the_same(name: str) -> None:
    changed = load_case(name).with_changes({"name": "mine", "gravity": 9.7})
    text = changed.to_short_toml(name)
    assert len(text.splitlines()) <= 3
    assert case_from_toml(text) == changed


CHANGES = [
    {"vehicle.use": "electric_locomotive", "vehicle.body.car_body.mass": "50 t"},
    {"disturbance": None},
    {"contact.friction": {"kind": "falling", "mu_0": 0.3, "A": 0.4, "B": 0.6}},
    {"contact.normal": "hertz", "contact.material": "paper"},
    {"vehicle.cut": "leading_wheelset", "disturbance": [{"body": "wheelset_1", "yaw": "1 mrad"}]},
    {"vehicle.element.primary_*.x.stiffness": "20 MN/m", "support.roller_radius": 10, "support.gauge": "1432 mm"},
    {"motion.speed_table": [[0, "150 km/h"], [5, "160 km/h"]]},
    {"motion.speed": "300 km/h", "description": 'with "quotes"'},
]  # fmt: skip


@pytest.mark.parametrize("changes", CHANGES, ids=lambda changes: next(iter(changes)))
def test_what_changed_is_all_that_is_written(bogie: Case, changes: dict[str, object]) -> None:
    changed = bogie.with_changes(changes)
    text = changed.to_short_toml()
    assert text.startswith('base = "')
    assert len(text.splitlines()) < 40
    assert case_from_toml(text) == changed


def test_cases_on_the_other_support_are_written_short(bogie: Case) -> None:
    for case in (on_track(bogie), on_rig(load_case("vehicle_curve")), on_rig(bogie, 1.0)):
        assert len(case.to_short_toml().splitlines()) < 20
        assert case_from_toml(case.to_short_toml()) == case


# ------------------------------------------------------------------------------------------------------ read from a file


def test_a_file_may_start_from_another_file(bogie: Case, tmp_path: Path) -> None:
    (tmp_path / "first.toml").write_text(
        'base = "bogie_rollers_constant"\nname = "first"\n[vehicle.element."primary_*".x]\nstiffness = "20 MN/m"\n'
    )
    (tmp_path / "second.toml").write_text('base = "first.toml"\nwithout = ["disturbance"]\nmotion.speed_kmh = 100\n')
    case = load_case(tmp_path / "second.toml")
    assert (case.name, case.disturbance) == ("first", ())
    assert case.motion.speed == 100 / 3.6
    stiffness = {e.name: e.x.stiffness for e in case.vehicle.data.element if e.x and e.name.startswith("primary")}
    assert set(stiffness.values()) == {20e6}
    assert len(stiffness) == 8


def test_a_profile_named_beside_the_base_is_that_files_own(tmp_path: Path) -> None:
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "wheel.toml").write_text('kind = "cone"\nconicity = "1:20"\n')
    (tmp_path / "mine" / "case.toml").write_text(
        'base = "bogie_rollers_constant"\nvehicle.wheel.profile = "wheel.toml"\n'
    )
    assert load_case(tmp_path / "mine" / "case.toml").vehicle.data.wheel.profile.kind == "cone"


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ('base = "bogie_rollers"', "mine.toml: base: 'bogie_rollers'; no such file; allowed:"),
        ('base = "mine.toml"', "mine.toml: base: 'mine.toml'; allowed: a case that does not start from this one again"),
        ("base = 3", "mine.toml: base: 3; allowed: a case of the catalogue or a file"),
        ('without = ["brake"]', "mine.toml: without: ['brake']; allowed: beside `base`, whose keys it takes away"),
        ('base = "bogie_track"\nwithout = ["brake"]', "mine.toml: without: 'brake'; allowed: a list of dotted keys"),
        ('base = "bogie_track"\nmotion.speed = "3 kg"', "mine.toml: motion.speed: '3 kg'; allowed: a number in m/s"),
        ('base = "bogie_track"\nmotion.sped = 3', "mine.toml: motion.sped: unknown key (= 3)"),
        ('base = "bogie_track"\n[vehicle.element."primary_5*".x]\nstiffness = 1',
         "mine.toml: vehicle.element.primary_5*.x.stiffness: nothing matches 'primary_5*'; allowed: primary_1_left"),
    ],
)  # fmt: skip
def test_a_mistake_beside_a_base_is_one_line(
    text: str, line: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("mine.toml").write_text(f"{text}\n")
    with pytest.raises(ConfigError) as error:
        load_case("mine.toml")
    assert str(error.value).startswith(line)
    assert len(error.value.problems) == 1


# ------------------------------------------------------------------------------------------------------ numbers, patterns


def test_numbers_of_numpy_and_quantities_of_pint_are_numbers(bogie: Case) -> None:
    unit = pint.UnitRegistry()
    changed = bogie.with_changes(
        {
            "motion.speed": 120 * unit.km / unit.hour,
            "vehicle.body.car_body.mass": np.int64(30000),
            "contact.friction": np.float32(0.25),
            "vehicle.body.car_body.inertia": np.array([56e3, 2e6, 2e6]),
            "vehicle.body.car_body.position": [0 * unit.m, 0.0, np.float64(1.9)],
            "support.roller_radius": unit.Quantity(np.float64(800), "mm"),
        }
    )
    plain = {
        "motion.speed": "120 km/h",
        "vehicle.body.car_body.mass": 30000,
        "contact.friction": 0.25,
        "vehicle.body.car_body.inertia": [56e3, 2e6, 2e6],
        "vehicle.body.car_body.position": [0.0, 0.0, 1.9],
        "support.roller_radius": "800 mm",
    }
    assert changed == bogie.with_changes(plain)
    with pytest.raises(ConfigError, match=r"motion.speed: '3 kilogram'; allowed: a number in m/s"):
        bogie.with_changes({"motion.speed": 3 * unit.kg})


@pytest.mark.parametrize("number", [np.float32(0.5), np.int16(2), np.float64(1.5)])
def test_a_table_takes_a_number_of_numpy(bogie: Case, number: np.generic) -> None:
    assert type(bogie.support.data)(**{**dict(bogie.support.data), "gauge_depth": number / 100}).gauge_depth == float(
        number / 100
    )


def test_a_pattern_changes_all_that_match(bogie: Case) -> None:
    changed = bogie.with_changes({"vehicle.element.primary_*_left.*.damper.damping": "1 kN s/m"})
    assert list(bogie.diff(changed)) == [
        f"vehicle.element.primary_{i}_left.{axis}.damper.damping" for i in (1, 2, 3, 4) for axis in "xyz"
    ]
    one = bogie.with_changes({"disturbance.*.lateral": "1 mm"})
    assert one.disturbance[0].lateral == 1e-3


def test_a_pattern_that_matches_nothing_is_a_mistake(bogie: Case) -> None:
    with pytest.raises(
        ConfigError, match=r"(changed.: vehicle\.element\.primry).*allowed: primary_1_left, .*did you mean 'primary_\*'"
    ):
        bogie.with_changes({"vehicle.element.primry_*.x.stiffness": 1e6})


@pytest.mark.parametrize("key", ["extends", "inherits", "Base"])
def test_another_word_for_the_base_is_the_only_mistake(key: str) -> None:
    with pytest.raises(ConfigError) as raised:
        case_from_toml(f'{key} = "bogie_track"')
    assert len(raised.value.problems) == 1
    assert str(raised.value).startswith(f"case: {key}: unknown key")
    assert str(raised.value).endswith("did you mean 'base'?")


# ------------------------------------------------------------------------------------------------------ printed


def test_a_case_prints_in_seven_lines(bogie: Case) -> None:
    text = repr(bogie)
    assert len(text.splitlines()) == 7
    assert max(len(line) for line in text.splitlines()) < 130
    for word in ("bogie_rollers_constant", "leading_bogie", "725 mm", "150 km/h", "10 s", "friction 0.3"):
        assert word in text
        assert word in bogie._repr_html_()
    assert len(repr(bogie.vehicle)) < 200


def test_the_difference_of_two_cases(bogie: Case) -> None:
    assert bogie.diff(bogie) == {}
    assert repr(bogie.diff(bogie)) == "no difference"
    changed = bogie.with_changes({"motion.speed": "40 m/s", "disturbance": None, "gravity": 9.8})
    assert bogie.diff(changed) == {
        "gravity": (9.81, 9.8),
        "motion.speed": (bogie.motion.speed, 40.0),
        "disturbance": ([{**dict(bogie.disturbance[0])}], []),
    }
    lines = repr(bogie.diff(changed)).splitlines()
    assert "gravity: 9.81 m/s^2 -> 9.8 m/s^2" in lines
    assert "motion.speed: 41.6667 m/s -> 40 m/s" in lines
    softer = bogie.with_changes({"vehicle.element.primary_1_left.x.stiffness": "30 MN/m", "contact.friction": 0.25})
    assert "vehicle.element.primary_1_left.x.stiffness: 3.1391·10⁷ N/m -> 3·10⁷ N/m" in repr(bogie.diff(softer))
    assert "contact.friction.mu_0: 0.3 -> 0.25" in repr(bogie.diff(softer))


def test_a_case_is_not_saved_as_one_of_another_that_there_is_not(bogie: Case, tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match=r"base: 'bogie_trak'; allowed: .* did you mean 'bogie_track'"):
        bogie.save(tmp_path / "mine.toml", base="bogie_trak")
    assert not (tmp_path / "mine.toml").exists()
