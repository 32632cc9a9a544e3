"""Bodies and elements written once and placed many times."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from rollerrig.config import ConfigError, load_vehicle
from rollerrig.config.load.resolve import placed

from .conftest import WRITTEN_OUT


def test_the_vehicle_of_the_catalogue_is_the_one_written_out(tmp_path: Path) -> None:
    shutil.copy(WRITTEN_OUT, tmp_path / "whole.toml")
    assert load_vehicle(tmp_path / "whole.toml") == load_vehicle("manchester_vehicle_1")


def elements(**keys: object) -> list[dict[str, object]]:
    found, problems = placed({"element": [{"name": "spring", "between": ["a", "b"], **keys}]}, "v.toml")
    assert problems == []
    return found["element"]  # type: ignore[no-any-return]


def test_an_element_stands_at_each_place_on_both_sides() -> None:
    at = {"front": {"point": [1.0, 0.5, 0.0]}, "rear": {"point": ["-1 m", "500 mm", 0.0], "between": ["a", "c"]}}
    assert elements(at=at, both_sides=True, z={"stiffness": 1}) == [
        {"name": "spring_front_left", "between": ["a", "b"], "point": [1.0, 0.5, 0.0], "z": {"stiffness": 1}},
        {"name": "spring_front_right", "between": ["a", "b"], "point": [1.0, -0.5, 0.0], "z": {"stiffness": 1}},
        {"name": "spring_rear_left", "between": ["a", "c"], "point": ["-1 m", "500 mm", 0.0], "z": {"stiffness": 1}},
        {"name": "spring_rear_right", "between": ["a", "c"], "point": ["-1 m", "-500 mm", 0.0], "z": {"stiffness": 1}},
    ]


def test_what_acts_to_one_side_is_mirrored() -> None:
    stop = {"table": [[0, 0], ["20 mm", 0], ["30 mm", 1e4]], "preload": 5.0}
    _, right = elements(
        both_sides=True, points=[[0, 1, 0], [0, 0.8, 0]], y=stop, x={"preload": 5.0}, yaw={"preload": 2}
    )
    assert right["points"] == [[0, -1, 0], [0, -0.8, 0]]
    assert right["y"] == {"table": [[-1e4 and "-30 mm", -1e4], ["-20 mm", 0], [0, 0]], "preload": -5.0}
    assert (right["x"], right["yaw"]) == ({"preload": 5.0}, {"preload": -2})


BODY = 'name = "v"\n[wheel]\nprofile = "s1002"\nradius = 0.46\nback_to_back = 1.36\n[[body]]\nname = "w"\nkind = "wheelset"\n'
BODY += "mass = 1800\ninertia = [1000, 100, 1000]\n"
FRAME = 'at.1 = { position = [0, 0, 0.46] }\n[[body]]\nname = "f"\nmass = 900\ninertia = [1, 1, 1]\nposition = [0, 0, 0.7]\n'
SPRING = f'{FRAME}[[element]]\nname = "s"\nbetween = ["f", "w_1"]\n[element.z]\nstiffness = 1e6\n'


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("at = 3\n", "v.toml: body.w.at: 3; allowed: a table of places by name, like at.front"),
        ("both_sides = true\n", "v.toml: body.w.both_sides: true; allowed: of elements only"),
        ("at.1 = { psition = [0, 0, 0.46] }\n", "v.toml: body.w_1.position: missing; needed:"),
        (SPRING.replace("[element.z]", "point = [0, 0, 0.46]\nboth_sides = true\n[element.z]"),
         "v.toml: element.s.point: [[0, 0, 0.46]]; allowed with both_sides = true: a point with y other than 0"),
        (SPRING.replace("[element.z]", "point = [0, 1, 0.46]\nboth_sides = 1\n[element.z]"),
         "v.toml: element.s.both_sides: 1; allowed: true or false"),
        (SPRING.replace("[element.z]", "points = 5\nboth_sides = true\n[element.z]"),
         "v.toml: element.s_left.points: 5; allowed: "),
    ],
)  # fmt: skip
def test_a_mistake_in_a_place_is_one_line(
    text: str, line: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("v.toml").write_text(BODY + text)
    with pytest.raises(ConfigError) as error:
        load_vehicle("v.toml")
    assert any(str(problem).startswith(line) for problem in error.value.problems), str(error.value)


def test_two_sides_are_two_elements(tmp_path: Path) -> None:
    text = SPRING.replace("[element.z]", "point = [0, 1, 0.46]\nboth_sides = true\n[element.z]")
    (tmp_path / "v.toml").write_text(BODY + text)
    assert [(e.name, e.end_a[1]) for e in load_vehicle(tmp_path / "v.toml").element] == [("s_left", 1), ("s_right", -1)]
