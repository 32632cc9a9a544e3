"""The reference names every key with its meaning."""

from __future__ import annotations

import importlib.util
import json
import tomllib
from collections.abc import Iterator
from pathlib import Path

import pytest
from jsonschema import Draft202012Validator
from pydantic import BaseModel

from rollerrig.catalog import KINDS, catalog_file, catalog_names
from rollerrig.config import Case, FitPlan, Plan, Programme, explain, json_schema, load_case
from rollerrig.config.read import schema_file
from rollerrig.config.schema.base import Table
from rollerrig.config.write.explain import key_places
from rollerrig.profiles import SHAPES

from .schema_walk import whole_cases


def tables(root: type[BaseModel] = Table) -> Iterator[type[BaseModel]]:
    for table in root.__subclasses__():
        yield table
        yield from tables(table)


@pytest.mark.parametrize("table", list(tables()), ids=lambda table: table.__name__)
def test_every_key_has_a_description(table: type[BaseModel]) -> None:
    assert table.__doc__
    for name, field in table.model_fields.items():
        assert field.description, f"{table.__name__}.{name}"


def test_the_reference_of_the_documentation_names_every_key() -> None:
    pytest.importorskip("sphinx")
    path = Path(__file__).resolve().parents[3] / "docs" / "_ext" / "config_reference.py"
    spec = importlib.util.spec_from_file_location("config_reference", path)
    assert spec
    assert spec.loader
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    lines = module.reference(*(root.model_json_schema() for root in (Case, Programme, Plan, FitPlan)))
    text = "\n".join(lines)
    for place in key_places():
        assert f"| `{place.key.rpartition('.')[2]}` |" in text, place.key
    rows = [line for line in text.splitlines() if line.startswith("|")]
    assert {line.replace("\\|", "").count("|") for line in rows} == {6}


def test_a_key_is_explained_with_its_unit() -> None:
    assert "from 1e-06 to 100000 s" in explain("time.duration")
    assert "s, m/s" in explain("motion.speed_table")


@pytest.mark.parametrize("kind", KINDS)
def test_the_json_schema_that_ships_is_that_of_the_models(kind: str) -> None:
    """If not: python scripts/write_schemas.py."""
    schema = json_schema(kind)  # type: ignore[arg-type]
    assert json.loads(schema_file(kind).read_text("utf-8")) == schema  # type: ignore[arg-type]


@pytest.mark.parametrize("kind", KINDS)
def test_the_json_schema_accepts_every_file_that_ships(kind: str) -> None:
    schema = Draft202012Validator(json_schema(kind))  # type: ignore[arg-type]
    Draft202012Validator.check_schema(schema.schema)
    for name in catalog_names(kind):  # type: ignore[arg-type]
        text = catalog_file(kind, name).read_text("utf-8")  # type: ignore[arg-type]
        assert text.startswith(f"#:schema ../schema/{kind}.json\n")
        assert [error.message for error in schema.iter_errors(tomllib.loads(text))] == [], name


def test_the_json_schema_accepts_whole_and_short_cases() -> None:
    schema = Draft202012Validator(json_schema())
    changed = load_case("adhesion_brake").with_changes(
        {"vehicle.element.primary_*.x.stiffness": 3e7, "axle_torque": []}
    )
    short = changed.with_changes({"motion.speed": "300 km/h", "rig_control.feedback": "none"}).to_short_toml()
    raws = [*whole_cases().values(), tomllib.loads(short), tomllib.loads(STARTED)]
    for raw in raws:
        assert [error.message for error in schema.iter_errors(raw)] == []


STARTED = """
base = "bogie_track"
without = ["disturbance"]
"motion.speed" = "100 km/h"
motion.speed_kmh = 100
support.roller_radius_mm = 800
slide_protection.fmu = "wsp.fmu"
vehicle.element."primary_*".x.stiffness = 1e6
disturbance.wheelset_1.lateral = 0.001
"""


@pytest.mark.parametrize(
    "text",
    ['name = "x"', 'base = "bogie_track"\nmotion.sped = 3', 'base = "bogie_track"\nmotion.speed = 80',
     'base = "bogie_track"\ncontact.creep = "polahc"', 'base = "bogie_track"\nadhesion.rail = "lo"', "base = 3"],
)  # fmt: skip
def test_the_json_schema_marks_mistakes(text: str) -> None:
    assert list(Draft202012Validator(json_schema()).iter_errors(tomllib.loads(text)))


def test_the_json_schema_lets_a_file_refer_and_leave_out() -> None:
    tables = json_schema()["$defs"]
    assert "data" not in tables["VehicleChoice"].get("required", [])
    assert tables["Contact"]["properties"]["material"]["anyOf"][0] == {"type": "string"}
    assert tables["TimeSettings"]["properties"]["duration"]["x-unit"] == "s"
    assert "patternProperties" in tables["Motion"]


def test_every_shape_of_the_profiles_can_be_written() -> None:
    tags = json_schema("profile")["discriminator"]["mapping"]
    assert tags.keys() == SHAPES.keys()
