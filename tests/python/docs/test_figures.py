"""Figures quoted in README and documentation: pages agree with docs/figures.toml, and its quick ones with the program."""

from __future__ import annotations

import importlib.util
import tomllib
from pathlib import Path
from typing import Any

import pytest

from rollerrig.study import studies

ROOT = Path(__file__).resolve().parents[3]
DATA: dict[str, Any] = tomllib.loads((ROOT / "docs" / "figures.toml").read_text(encoding="utf-8"))
QUICK = [name for name, command in DATA["command"].items() if command.get("quick")]

spec = importlib.util.spec_from_file_location("write_figures", ROOT / "scripts" / "write_figures.py")
assert spec is not None
assert spec.loader is not None
write_figures = importlib.util.module_from_spec(spec)
spec.loader.exec_module(write_figures)


@pytest.mark.parametrize("page", sorted({figure["page"] for figure in DATA["figure"]}))
def test_pages_quote_the_recorded_values(page: str) -> None:
    text = (ROOT / page).read_text(encoding="utf-8")
    stale = [write_figures.quoted(one) for one in DATA["figure"] if one["page"] == page]
    assert [one for one in stale if one not in text] == []


@pytest.mark.slow
@pytest.mark.parametrize("name", QUICK)
def test_recorded_values_are_what_the_program_computes(name: str) -> None:
    numbers = write_figures.summary(DATA["command"][name]["command"])
    for figure in (one for one in DATA["figure"] if one["of"] == name):
        new = {**figure, "values": [write_figures.value(numbers, key) for key in figure["keys"]]}
        assert write_figures.quoted(new) == write_figures.quoted(figure)


@pytest.mark.parametrize("name", sorted(DATA["command"]))
def test_values_are_reported_quantities(name: str) -> None:
    command = DATA["command"][name]["command"].split()[1]
    quantities = next(study.quantities for study in studies() if study.command == command)
    keys = [key for figure in DATA["figure"] if figure["of"] == name for key in figure["keys"]]
    assert [key for key in keys if not any(q.matches(write_figures.place(key)[1]) for q in quantities)] == []


def test_every_command_is_quoted() -> None:
    assert {figure["of"] for figure in DATA["figure"]} == set(DATA["command"])
