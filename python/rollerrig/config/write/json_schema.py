"""JSON Schema of the files, for editors that complete keys, show units and mark mistakes while one writes.

pydantic models -> [json_schema] -> what a file may write: references by name, units in keys, short forms, parts of a case

Editors find it by the first line of a file, `#:schema PATH`; the files of the catalogue have one. It accepts every file that
`rollerrig check` accepts; what only a look across tables can tell (names that must exist, tables in order) it does not know.
"""

from typing import Any

from pydantic import BaseModel

from rollerrig.config.read import CatalogKind
from rollerrig.config.schema.base import INSTEAD_OF, USUAL_KIND
from rollerrig.config.schema.case import CaseTables
from rollerrig.config.schema.contact import Material
from rollerrig.config.schema.fit import FitPlan
from rollerrig.config.schema.plan import Plan
from rollerrig.config.schema.profile import ProfileRoot
from rollerrig.config.schema.programme import Programme
from rollerrig.config.schema.support import SupportRoot
from rollerrig.config.schema.units import KEY_SUFFIXES
from rollerrig.config.schema.vehicle import Vehicle

Schema = dict[str, Any]

ROOTS: dict[CatalogKind, type[BaseModel]] = {
    "case": CaseTables,
    "vehicle": Vehicle,
    "support": SupportRoot,
    "material": Material,
    "profile": ProfileRoot,
    "programme": Programme,
    "plan": Plan,
    "fit": FitPlan,
}


def json_schema(kind: CatalogKind = "case") -> Schema:
    """JSON Schema of one kind of file; `x-unit` is the SI unit of a number, `x-range` what it may be.

    Example:
        >>> json_schema("material")["properties"]["young_modulus"]["x-unit"]
        'Pa'
    """
    schema = ROOTS[kind].model_json_schema()
    schema = _without_titles(schema)
    tables = schema.get("$defs", {})
    _usual_kinds(schema, tables)
    for table in (schema, *tables.values()):
        _as_in_files(table)
    if kind == "case":
        _with_base(schema, tables)
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **schema}


def _without_titles(schema: Any) -> Any:
    """Pydantic makes a title of every key: the key again."""
    if isinstance(schema, list):
        return [_without_titles(item) for item in schema]
    if not isinstance(schema, dict):
        return schema
    return {k: _without_titles(v) for k, v in schema.items() if k != "title" or not isinstance(v, str)}


def _usual_kinds(schema: Any, tables: Schema) -> None:
    """A table of the usual kind need not say so."""
    if isinstance(schema, dict) and (usual := schema.pop(USUAL_KIND, "")):
        table = tables[schema["discriminator"]["mapping"][usual].split("/")[-1]]
        table["required"] = [key for key in table.get("required", []) if key != "kind"]
    for inner in schema.values() if isinstance(schema, dict) else schema if isinstance(schema, list) else ():
        _usual_kinds(inner, tables)


def _as_in_files(table: Schema) -> None:
    """Add what a file may write and the loaded object no longer shows: references, units in keys, left-out keys."""
    properties = table.get("properties", {})
    optional = {key for key, value in properties.items() if INSTEAD_OF in value}
    if "required" in table:
        table["required"] = [key for key in table["required"] if key not in optional]
    for key in sorted(properties.keys() & {"profile", "right_profile", "material"}):
        kinds = ("$ref", "oneOf", "discriminator", "anyOf")
        inner = {name: properties[key].pop(name) for name in kinds if name in properties[key]}
        properties[key]["anyOf"] = [{"type": "string"}, inner]
    quantities = [key for key, value in properties.items() if _is_number_with_unit(value)]
    if quantities:
        pattern = f"^({'|'.join(quantities)})_({'|'.join(KEY_SUFFIXES)})$"
        table["patternProperties"] = {pattern: {"type": "number"}}


def _is_number_with_unit(schema: Schema) -> bool:
    return "x-unit" in schema or any("x-unit" in choice for choice in schema.get("anyOf", ()))


# ------------------------------------------------------------------------------------------- cases that start from another


def _with_base(schema: Schema, tables: Schema) -> None:
    """Schema of a case with `base`: keys may be absent, items of lists and keys of its vehicle or support addressed by name."""
    choices = {"vehicle": ("VehicleChoice", ("Vehicle",)), "support": ("SupportChoice", ("Rig", "Track"))}
    for choice, parts in choices.values():
        inside = {key: value for part in parts for key, value in tables[part]["properties"].items()}
        own = tables[choice]["properties"]
        for key in [name for name in inside if name not in own]:  # in this order
            own[key] = {"anyOf": [{"type": "object"}, inside[key]], "description": inside[key].get("description", "")}
        _as_in_files(tables[choice])
        if "required" in tables[choice]:
            del tables[choice]["required"]
    for key, value in schema["properties"].items():
        if value.get("type") == "array" and key != "without":
            schema["properties"][key] = {"anyOf": [{"type": "object"}, value], "description": value["description"]}
    whole: Schema = {"required": schema.pop("required"), "properties": {}}
    for key, value in schema["properties"].items():
        table = tables.get(str(value.get("$ref", "")).split("/")[-1], {})
        if table.get("required"):
            whole["properties"][key] = {"required": table.pop("required")}
    schema["patternProperties"] = {r"\.": {"description": "a dotted key in quotes, with `base`"}}
    schema["if"], schema["else"] = {"required": ["base"]}, whole
