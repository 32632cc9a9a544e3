"""The glossary names keys, results and laws that exist, with their units, and every result of a run stands in it."""

from __future__ import annotations

import re
from functools import cache
from pathlib import Path
from typing import Any, Literal, get_args, get_origin

import pytest
import xarray as xr
from pydantic import BaseModel

import rollerrig as rr
from rollerrig.config import Case

PAGE = (Path(__file__).parents[3] / "docs" / "glossary.md").read_text(encoding="utf-8")
ROWS = [[cell.strip() for cell in line.strip("|").split("|")] for line in PAGE.splitlines() if line.startswith("| ")]
QUANTITIES = [row for row in ROWS if len(row) == 6 and row[0] != "quantity"]
CHOICES = [row for row in ROWS if len(row) == 3 and row[0] != "choice"]


def names(cell: str) -> list[str]:
    return re.findall(r"`([^`]+)`", cell)


def fields(annotation: Any, key: str) -> list[Any]:
    """Annotations of a key in all the tables that a value may be; items of lists, and tables by name, are looked into."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        found = [annotation.model_fields[key].annotation] if key in annotation.model_fields else []
        data = annotation.model_fields.get("data")  # the vehicle or support itself: its keys may be written without it
        return found or (fields(data.annotation, key) if data else [])
    return [found for part in get_args(annotation) for found in fields(part, key)]


def annotations(key: str) -> list[Any]:
    found: list[Any] = [Case]
    for part in key.split("."):
        found = [inner for one in found for inner in fields(one, part)]
    return found


def literals(annotation: Any) -> list[str]:
    if get_origin(annotation) is Literal:
        return list(get_args(annotation))
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):  # a law: the name that asks for it
        return literals(annotation.model_fields["kind"].annotation) if "kind" in annotation.model_fields else []
    return [name for part in get_args(annotation) for name in literals(part)]


@cache
def units() -> dict[str, str]:
    """Name -> unit of all that runs, stability and wheel forces give."""
    run = rr.simulate(rr.load_case("adhesion_brake").with_changes({"time.duration": "20 ms"}))
    modes = rr.stability(rr.load_case("bogie_track"), speeds_kmh=[100, 120])
    speeds = rr.critical_speed("bogie_track", speeds_kmh=[300, 320])
    datasets: list[xr.Dataset] = [speeds, modes, rr.wheel_forces(run), run]
    return {str(name): v.attrs.get("units", "") for one in datasets for name, v in one.variables.items()}


@pytest.mark.parametrize("key", sorted({key for row in QUANTITIES for key in names(row[3])}))
def test_keys_exist(key: str) -> None:
    assert annotations(key), f"no key {key} in a case file"


def test_results_exist_with_their_unit() -> None:
    for row in QUANTITIES:
        unit = row[2].replace("²", "^2").replace("³", "^3")
        assert {name: units().get(name) for name in names(row[4])} == dict.fromkeys(names(row[4]), unit), row[0]


def test_every_result_of_a_run_is_explained() -> None:
    run = rr.simulate(rr.load_case("adhesion_brake").with_changes({"time.duration": "20 ms"}))
    explained = {name for row in QUANTITIES for name in names(row[4])}
    assert not {str(name) for name in run.data_vars} - explained


@pytest.mark.parametrize(("key", "listed"), [(names(row[1])[0], names(row[2])) for row in CHOICES])
def test_names_of_laws_are_those_of_the_configuration(key: str, listed: list[str]) -> None:
    allowed = {name for annotation in annotations(key) for name in literals(annotation) or literals(tuple[annotation])}
    assert set(listed) == allowed
