"""Cases: read, changed, written and read again."""

from __future__ import annotations

import pickle
import re
import tomllib
from pathlib import Path

import pytest

from rollerrig.catalog import catalog_names, catalog_text
from rollerrig.config import Case, ConfigError, Rig, Track, Uic60, case_from_toml, load_case, load_profile

from .conftest import spoil


@pytest.fixture(scope="module")
def bogie() -> Case:
    return load_case("bogie_rollers_constant")


def rig_of(case: Case) -> Rig:
    assert isinstance(case.support.data, Rig)
    return case.support.data


def test_a_case_is_in_si_with_everything_it_refers_to(bogie: Case) -> None:
    assert bogie.motion.speed == pytest.approx(150 / 3.6, rel=1e-15)  # one rounding
    assert bogie.vehicle.data.wheel.radius == 0.46
    assert rig_of(bogie).roller_radius == 0.725
    assert isinstance(rig_of(bogie).profile, Uic60)
    assert bogie.contact.material.shear_modulus == pytest.approx(210e9 / 2.56, rel=1e-15)
    assert [body.name for body in bogie.vehicle.data.bodies_in(bogie.vehicle.part)] == [
        "front_frame", "wheelset_1", "wheelset_2"
    ]  # fmt: skip


def test_a_cut_keeps_the_elements_between_its_bodies(bogie: Case) -> None:
    elements = bogie.vehicle.data.elements_in(bogie.vehicle.part)
    assert len(elements) == 4 + 2 + 2 + 2 + 1 + 1 + 1
    assert all("rear" not in element.name for element in elements)


@pytest.mark.parametrize("name", catalog_names("case"))
def test_a_case_survives_being_written_and_read(name: str) -> None:
    case = load_case(name)
    text = case.to_toml()
    assert case_from_toml(text) == case
    assert case_from_toml(text).to_toml() == text
    assert tomllib.loads(text)["vehicle"]["data"]["wheel"]["radius"] == case.vehicle.data.wheel.radius


def test_a_case_can_be_sent_to_another_process(bogie: Case) -> None:
    assert pickle.loads(pickle.dumps(bogie)) == bogie


def test_changes_make_another_case(bogie: Case) -> None:
    changed = bogie.with_changes(
        {
            "motion.speed": "120 km/h",
            "support.roller_radius": 10,
            "support.gauge": "1432 mm",
            "vehicle.body.car_body.mass": "30 t",
            "vehicle.element.primary_1_left.y.stiffness": "4 MN/m",
            "vehicle.data.body[1].mass": 2600,
            "contact.material": "paper",
            "disturbance.wheelset_1.lateral": "1 mm",
            "time.maximum_step": "1 ms",
        }
    )
    assert changed.motion.speed == pytest.approx(120 / 3.6, rel=1e-15)
    assert (rig_of(changed).roller_radius, rig_of(changed).gauge) == (10.0, 1.432)
    assert [body.mass for body in changed.vehicle.data.body[:2]] == [30000.0, 2600.0]
    law = changed.vehicle.data.element[0].y
    assert law is not None
    assert law.stiffness == 4e6
    assert changed.contact.material.shear_modulus == 10e9
    assert changed.disturbance[0].lateral == 0.001
    assert bogie.vehicle.data.body[0].mass == 32000.0
    assert bogie.with_changes({}) == bogie


def test_a_change_may_replace_or_remove_a_whole_part(bogie: Case) -> None:
    track = bogie.with_changes({"support.use": "uic60_track", "disturbance": None})
    assert isinstance(track.support.data, Track)
    assert track.disturbance == ()
    ramp = load_case("bogie_rollers_ramp")
    slow = ramp.with_changes({"motion.speed_table": None, "motion.speed_kmh": 50, "motion.speed": None})
    assert slow.motion.speed == pytest.approx(50 / 3.6, rel=1e-15)
    stiff = bogie.with_changes({"contact.material.shear_modulus": "10 GPa", "contact.material.poisson_ratio": 0.3})
    assert stiff.contact.material.young_modulus == pytest.approx(26e9, rel=1e-15)


@pytest.mark.parametrize("modulus", ["shear_modulus", "young_modulus"])
def test_a_modulus_is_refused_in_its_own_name_where_the_other_would_be_out_of_range(bogie: Case, modulus: str) -> None:
    value = {"shear_modulus": 9e13, "young_modulus": 1.5e5}[modulus]
    with pytest.raises(ConfigError, match=rf"contact\.material\.{modulus}: .*allowed: such that ") as error:
        bogie.with_changes({f"contact.material.{modulus}": value})
    assert len(error.value.problems) == 1


def test_mistaken_changes_are_told_like_mistakes_in_a_file(bogie: Case) -> None:
    with pytest.raises(ConfigError) as error:
        bogie.with_changes(
            {"motion.sped": 3, "support.roler_radius": 1, "vehicle.body.carbody.mass": 1, "time.maximum_step.x": 1}
        )
    lines = str(error.value).splitlines()
    assert lines[0] == (
        "bogie_rollers_constant (changed): vehicle.body.carbody.mass: no item 'carbody'; allowed: car_body, "
        "front_frame, rear_frame, wheelset_1, wheelset_2, wheelset_3, wheelset_4; did you mean 'car_body'?"
    )
    assert "bogie_rollers_constant (changed): motion.sped: unknown key (= 3)" in lines[2]
    assert {problem.key for problem in error.value.problems} == {
        "motion.sped", "support.roler_radius", "vehicle.body.carbody.mass", "time.maximum_step"
    }  # fmt: skip


def test_a_file_may_change_what_it_uses(tmp_path: Path) -> None:
    text = spoil(
        catalog_text("bogie_rollers_constant"),
        'cut = "leading_bogie"',
        'cut = "leading_bogie"\nbody.front_frame.mass = "3 t"\nelement."primary_*".x.stiffness = "40 MN/m"'
        '\nwheel.profile = { kind = "cone", conicity = "1:20" }',
    )
    text = spoil(text, 'use = "full_scale_rig"', 'use = "full_scale_rig"\nroller_radius_mm = 500')
    case = case_from_toml(text, folder=tmp_path)
    assert case.vehicle.data.body_named("front_frame").mass == 3000.0
    assert case.vehicle.data.wheel.profile.arguments()["conicity"] == 0.05
    stiffness = {e.x and e.x.stiffness for e in case.vehicle.data.element if e.name.startswith("primary_")}
    assert stiffness == {40e6}
    assert rig_of(case).roller_radius == 0.5
    assert case_from_toml(case.to_toml()) == case


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ('element."primary_*".x.stiffness = "-3 MN/m"', "vehicle.element.primary_1_left.x.stiffness: '-3 MN/m'; allowed: "),
        ('body.car_body.locked = ["q"]', "vehicle.body.car_body.locked[0]: 'q'; allowed: x, y, z, roll, pitch, yaw"),
        ("wheel.profile.length_scale = 0.2", "vehicle.wheel.profile.kind: missing; allowed: s1002"),
        ("changes.wheel.radius = 0.5", "vehicle.changes: unknown key (= a table with 1 key); allowed: name, "),
    ],
)  # fmt: skip
def test_a_mistake_beside_use_is_one_of_the_case(tmp_path: Path, line: str, message: str) -> None:
    (tmp_path / "mine.toml").write_text(
        spoil(catalog_text("bogie_rollers_constant"), 'cut = "leading_bogie"', f'cut = "leading_bogie"\n{line}')
    )
    with pytest.raises(ConfigError, match=rf"mine\.toml: {re.escape(message)}") as error:
        load_case(tmp_path / "mine.toml")
    assert "(catalogue)" not in str(error.value)


def test_a_used_vehicle_that_is_not_there_is_the_only_mistake_of_its_table() -> None:
    text = spoil(catalog_text("bogie_rollers_constant"), '"manchester_vehicle_1"', '"manchestr"\nwheel.radius = 0.5')
    with pytest.raises(ConfigError, match=r"vehicle\.use: 'manchestr'; no such file") as error:
        case_from_toml(text)
    assert len(error.value.problems) == 1


def test_an_empty_table_beside_use_leaves_what_there_is() -> None:
    text = catalog_text("bogie_rollers_constant")
    empty = spoil(text, 'use = "full_scale_rig"', 'use = "full_scale_rig"\nprofile = {}')
    assert case_from_toml(empty) == case_from_toml(text)


def test_paths_start_at_the_file_that_names_them(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "rigs").mkdir()
    rows = "\n".join(f"{y / 4} {-(36**2 - (36**2 - (y / 4) ** 2)) / 600:.8f}" for y in range(-140, 141))
    (tmp_path / "rigs" / "head.txt").write_text(rows + "\n")
    rig = spoil(catalog_text("full_scale_rig"), '"uic60_benchmark_1_40"', '"head.txt"')
    (tmp_path / "rigs" / "mine.toml").write_text(spoil(rig, '"14 mm"', '"1 mm"'))
    case = spoil(catalog_text("bogie_rollers_constant"), '"full_scale_rig"', '"rigs/mine.toml"')
    (tmp_path / "case.toml").write_text(spoil(case, 'material = "steel"', 'material = "mine.toml"'))
    (tmp_path / "mine.toml").write_text(catalog_text("steel"))
    monkeypatch.chdir("/")
    loaded = load_case(tmp_path / "case.toml")
    assert rig_of(loaded).profile.arguments()["path"] == str(tmp_path / "rigs" / "head.txt")
    assert case_from_toml(loaded.to_toml()) == loaded


def test_profile_arguments_are_what_the_profiles_take() -> None:
    assert load_profile("uic60_benchmark_1_40", "rail").arguments() == {
        "kind": "uic60", "variant": "benchmark", "inclination": 0.025, "step": 5e-5, "length_scale": 1.0
    }  # fmt: skip
    with pytest.raises(ConfigError, match="did you mean 's1002'"):
        load_profile("s102")


@pytest.mark.parametrize("value", ['"my head.prr"', '{kind = "file", path = "my head.prr"}'])
def test_a_profile_file_in_changes_stands_relative_to_the_case(tmp_path: Path, value: str) -> None:
    (tmp_path / "my head.prr").write_text("".join(f"{u} {-u * u / 80:.6f}\n" for u in range(-36, 37)))
    rig = 'use = "full_scale_rig"'
    case = spoil(catalog_text("wheelset_rollers"), rig, f"{rig}\nprofile = {value}")
    (tmp_path / "case.toml").write_text(case)
    assert str(tmp_path / "my head.prr") in load_case(tmp_path / "case.toml").to_toml()
