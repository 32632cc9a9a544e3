"""Files to spoil: copies of catalogue entries in an empty folder, read as a user would from there."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from rollerrig.catalog import catalog_text
from rollerrig.config import ConfigError, ConfigProblem, load_case

WRITTEN_OUT = Path(__file__).with_name("vehicle_written_out.toml")
"""The vehicle manchester_vehicle_1 with every body and element written where it stands."""

MistakesOf = Callable[..., list[ConfigProblem]]


def spoil(text: str, old: str, new: str) -> str:
    assert old in text, f"{old!r} is no longer in the catalogue entry"
    return text.replace(old, new)


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def mistakes_of(folder: Path) -> MistakesOf:
    """Problems of the case bogie_rollers_constant after replacing one text in it, or in its vehicle or rig."""

    def mistakes(old: str, new: str, part: str = "case") -> list[ConfigProblem]:
        case = catalog_text("bogie_rollers_constant")
        entries = {"vehicle": "manchester_vehicle_1", "support": "full_scale_rig"}
        if part == "case":
            case = spoil(case, old, new)
        else:
            case = spoil(case, f'use = "{entries[part]}"', f'use = "{part}.toml"')
            whole = WRITTEN_OUT.read_text() if part == "vehicle" else catalog_text(entries[part])
            (folder / f"{part}.toml").write_text(spoil(whole, old, new))
        (folder / "case.toml").write_text(case)
        with pytest.raises(ConfigError) as error:
            load_case("case.toml")
        return list(error.value.problems)

    return mistakes
