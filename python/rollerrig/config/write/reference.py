"""The reference of keys, generated from the models: Markdown for the documentation."""

import types
from collections.abc import Iterator
from typing import Annotated, Any, Literal, Union, get_args, get_origin

from pydantic import BaseModel
from pydantic.fields import FieldInfo

from rollerrig.config.schema.base import INSTEAD_OF, quantity_of
from rollerrig.config.schema.case import CaseTables
from rollerrig.config.schema.contact import Material
from rollerrig.config.schema.plan import Plan
from rollerrig.config.schema.profile import S1002, Arc, Cone, Cylinder, ProfileFile, Uic60
from rollerrig.config.schema.programme import Programme
from rollerrig.config.schema.support import Rig
from rollerrig.config.schema.track import Track
from rollerrig.config.schema.vehicle import Vehicle
from rollerrig.config.validate.messages import tables_in, tag_of

_CHAPTERS: tuple[tuple[str, tuple[type[BaseModel], ...]], ...] = (
    ("Case file", (CaseTables,)),
    ("Vehicle file", (Vehicle,)),
    ("Support file", (Rig, Track)),
    ("Material file", (Material,)),
    ("Profile", (S1002, Cone, Uic60, Cylinder, Arc, ProfileFile)),
    ("Programme file", (Programme,)),
    ("Plan file", (Plan,)),
)

_INTRODUCTION = """\
# Configuration reference

Files are [TOML](https://toml.io). A quantity is a number in the SI unit given here, or a text with a unit that pint
understands: `0.46`, `"0.46 m"` and `"460 mm"` are the same. A unit may also end the key: `speed_kmh = 100`. Ratios may
be written `"1:40"`. Unknown keys are mistakes. Where a file refers to a vehicle, support, material or profile, a
catalogue name is meant unless the text ends in a file name's suffix; paths start at the file that names them.
"""


def reference_markdown() -> str:
    """All keys as Markdown tables: key, type, unit, default, meaning."""
    parts = [_INTRODUCTION]
    for title, roots in _CHAPTERS:
        parts.append(f"## {title}\n")
        places = _places(roots)
        for table, keys in places.items():
            parts += _section(table, keys)
    return "\n".join(parts)


def _places(roots: tuple[type[BaseModel], ...]) -> dict[type[BaseModel], list[str]]:
    """The tables of a chapter, each with the keys at which it may stand; those of other chapters are left to them."""
    elsewhere = {table for _, tables in _CHAPTERS for table in tables}
    found: dict[type[BaseModel], list[str]] = {root: [] for root in roots}

    def visit(table: type[BaseModel], key: str) -> None:
        for name, field in table.model_fields.items():
            here = f"{key}.{name}" if key else name
            for inner, path in _inner_tables(field.annotation, here):
                if inner not in elsewhere:
                    found.setdefault(inner, []).append(path)
                    visit(inner, path.strip("[]"))

    for root in roots:
        visit(root, "")
    return found


def _inner_tables(annotation: Any, key: str) -> Iterator[tuple[type[BaseModel], str]]:
    """Tables below a field, with the heading TOML gives them."""
    for table in tables_in(annotation):
        yield table, f"[{key}]"
    for part in _alternatives(annotation):
        arguments = get_args(part)
        if get_origin(part) is tuple:
            for table in tables_in(arguments[0]):
                yield table, f"[[{key}]]"
        elif get_origin(part) is dict:
            for table in tables_in(arguments[1]):
                yield table, f"[{key}.NAME]"


def _alternatives(annotation: Any) -> tuple[Any, ...]:
    while get_origin(annotation) is Annotated:
        annotation = get_args(annotation)[0]
    if get_origin(annotation) in (Union, types.UnionType):
        return tuple(a for member in get_args(annotation) if member is not type(None) for a in _alternatives(member))
    return (annotation,)


def _section(table: type[BaseModel], keys: list[str]) -> Iterator[str]:
    tag = tag_of(table)
    title = ", ".join(f"`{key}`" for key in dict.fromkeys(keys)) or (f'`kind = "{tag}"`' if tag else "top level")
    yield f"### {title}\n"
    yield f"{(table.__doc__ or '').strip().splitlines()[0]}\n"
    yield "| key | type | unit | default | meaning |"
    yield "|---|---|---|---|---|"
    for name, field in table.model_fields.items():
        quantity = None if _has_tables(field.annotation) else quantity_of(field.annotation, field.metadata)
        unit = quantity.unit if quantity and quantity.unit != "1" else ""
        meaning = "; ".join(text for text in (field.description, quantity.bounds if quantity else "") if text)
        cells = (f"`{name}`", type_text(field), unit_text(field, unit), default_text(field), meaning)
        yield "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |"
    yield ""


def _has_tables(annotation: Any) -> bool:
    return any(True for _ in _inner_tables(annotation, ""))


def unit_text(field: FieldInfo, unit: str) -> str:
    """Both units of a table of pairs, else the one unit."""
    for part in _alternatives(field.annotation):
        row = get_args(part)[:1]
        if row and get_origin(row[0]) is tuple and len(get_args(row[0])) == 2:
            first, second = (quantity_of(item) or quantity_of(None, getattr(item, "__metadata__", ()))
                             for item in get_args(row[0]))  # fmt: skip
            return f"{first.unit if first else ''}, {second.unit if second else ''}"
    return unit


def type_text(field: FieldInfo) -> str:
    """What may stand at a field, in words."""
    is_quantity = not _has_tables(field.annotation) and quantity_of(field.annotation, field.metadata) is not None
    names: list[str] = []
    for part in _alternatives(field.annotation):
        origin, arguments = get_origin(part), get_args(part)
        if origin is Literal:
            names.append(" or ".join(f'`"{choice}"`' for choice in arguments))
        elif isinstance(part, type) and issubclass(part, BaseModel):
            names.append("table")
        elif origin is tuple:
            names.append(_tuple_type(arguments))
        elif origin is dict:
            names.append("tables by name")
        else:
            plain = {
                str: "text",
                bool: "true or false",
                int: "whole number",
                float: "quantity" if is_quantity else "number",
            }
            names.append(plain.get(part, "value"))
    return " or ".join(dict.fromkeys(names))


def _tuple_type(arguments: tuple[Any, ...]) -> str:
    if len(arguments) == 2 and arguments[1] is Ellipsis:
        first = _alternatives(arguments[0])[0]
        if isinstance(first, type) and issubclass(first, BaseModel):
            return "array of tables"
        if get_origin(first) is tuple:
            return "rows of two numbers"
        return "list of texts" if first is str or get_origin(first) is Literal else "list of numbers"
    inner = "points" if get_origin(_alternatives(arguments[0])[0]) is tuple else "values"
    return f"list of {len(arguments)} {inner}"


def _number(value: object) -> str:
    return f"{value:g}" if isinstance(value, float) else str(value)


def _list(row: tuple[object, ...]) -> str:
    return f"[{', '.join(map(_number, row))}]"


def default_text(field: FieldInfo) -> str:
    """The default as a file would have it, "required", or "" where absence is the default."""
    if isinstance(field.json_schema_extra, dict) and INSTEAD_OF in field.json_schema_extra:
        return f"this or `{field.json_schema_extra[INSTEAD_OF]}`"
    if field.is_required():
        return "required"
    default = field.default
    if default is None or default in ((), {}, "") or isinstance(default, BaseModel):
        return ""
    if isinstance(default, bool):
        return "true" if default else "false"
    if isinstance(default, tuple):
        return ", ".join(_list(row) if isinstance(row, tuple) else _number(row) for row in default)
    return f'"{default}"' if isinstance(default, str) else f"{default:g}"
