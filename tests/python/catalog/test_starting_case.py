"""Cases to begin with: explained, whole, and those that they start from."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from rollerrig.catalog import catalog_names
from rollerrig.catalog.starting_case import starting_case
from rollerrig.config import ConfigError, case_from_toml, load_case


@pytest.mark.parametrize("name", catalog_names("case"))
def test_a_new_case_is_the_one_it_starts_from_by_another_name(name: str) -> None:
    assert case_from_toml(starting_case("mine", name)) == load_case(name).with_changes({"name": "mine"})


@pytest.mark.parametrize("name", ["bogie_rollers_constant", "adhesion_brake", "vehicle_curve"])
def test_what_is_offered_in_comments_is_the_default_that_it_says(name: str) -> None:
    text = starting_case("mine", name)
    offered = re.sub(r"^# (?=[a-z_A-Z]+ = )", "", text, flags=re.MULTILINE)
    assert offered.count("\n#") < text.count("\n#") - 5
    assert case_from_toml(offered) == case_from_toml(text)


def test_a_new_case_starts_from_a_file(tmp_path: Path) -> None:
    load_case("bogie_track").with_changes({"name": "first", "gravity": 9.8}).save(tmp_path / "first.toml")
    case = case_from_toml(starting_case("second", tmp_path / "first.toml"))
    assert (case.name, case.gravity) == ("second", 9.8)


def test_every_key_of_a_new_case_is_explained_above_it() -> None:
    lines = starting_case("mine", "adhesion_brake").splitlines()
    keys = [i for i, line in enumerate(lines) if re.match(r"[a-z_A-Z]+ = ", line) and not line.startswith("kind")]
    assert len(keys) > 15
    assert [lines[i] for i in keys if not lines[i - 1].startswith("# ")] == []


def test_each_default_says_what_it_is() -> None:
    lines = starting_case("mine", "adhesion_brake").splitlines()
    offered = [line for line in lines if re.match(r"# [a-z_A-Z]+ = ", line)]
    assert len(offered) > 20
    assert [line for line in offered if not re.search(r"  # \w+", line)] == []
    assert "# It has several kinds: `rollerrig explain slide_protection` lists their keys." in lines


def test_a_name_that_cannot_be_one_is_refused() -> None:
    with pytest.raises(ConfigError, match=r"new: name: 'two words'; allowed: a name of at most 60 letters"):
        starting_case("two words")
