"""The reference names every key with its meaning."""

from __future__ import annotations

import json
from collections.abc import Iterator

import pytest
from pydantic import BaseModel

from rollerrig.catalog import KINDS
from rollerrig.config import Case, Material, Rig, Track, Vehicle, json_schema, reference_markdown
from rollerrig.config.schema.base import Table
from rollerrig.profiles import SHAPES


def tables(root: type[BaseModel] = Table) -> Iterator[type[BaseModel]]:
    for table in root.__subclasses__():
        yield table
        yield from tables(table)


@pytest.mark.parametrize("table", list(tables()), ids=lambda table: table.__name__)
def test_every_key_has_a_description(table: type[BaseModel]) -> None:
    assert table.__doc__
    for name, field in table.model_fields.items():
        assert field.description, f"{table.__name__}.{name}"


def test_the_reference_names_every_key_with_its_unit() -> None:
    text = reference_markdown()
    for table in (Case, Vehicle, Rig, Track, Material):
        for name in table.model_fields:
            assert f"| `{name}` |" in text
    assert "| `duration` | quantity | s | required | length of the run; from 1e-06 to 100000 s |" in text
    assert "| `speed_table` | rows of two numbers | s, m/s |" in text
    assert "### `[element.x.damper]`, `[element.y.damper]`, `[element.z.damper]`" in text
    rows = [line for line in text.splitlines() if line.startswith("|")]
    assert {line.replace("\\|", "").count("|") for line in rows} == {6}


@pytest.mark.parametrize("kind", KINDS)
def test_the_json_schema_can_be_exported(kind: str) -> None:
    schema = json_schema(kind)  # type: ignore[arg-type]
    assert json.loads(json.dumps(schema)) == schema


def test_the_json_schema_lets_a_file_refer_and_leave_out() -> None:
    tables = json_schema()["$defs"]
    assert "data" not in tables["VehicleChoice"].get("required", [])
    assert tables["Contact"]["properties"]["material"]["anyOf"][0] == {"type": "string"}
    assert tables["TimeSettings"]["properties"]["duration"]["x-unit"] == "s"
    assert "patternProperties" in tables["Motion"]


def test_every_shape_of_the_profiles_can_be_written() -> None:
    tags = json_schema("profile")["discriminator"]["mapping"]
    assert tags.keys() == SHAPES.keys()
