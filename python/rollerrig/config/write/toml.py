"""Cases as TOML text in SI: complete, as a result file stores them, or short, for people to read and edit.

Written here and not by tomli-w because every run carries its case: 15 kB of text in 0.2 to 0.8 ms, with vehicle and support
written once for all cases that share them. tomli-w takes 2.5 to 3.2 ms for it, as much as a tenth of the cheapest case of a
sweep, and gives each number of a list a line of its own: half as many lines again to read and to edit.
"""

import re
from collections.abc import Mapping, Sequence
from functools import cache, lru_cache
from json.encoder import encode_basestring
from typing import Any

import numpy as np
from pydantic import BaseModel

from rollerrig.config.schema.base import Table
from rollerrig.config.schema.units import AS_WRITTEN, is_quantity, quantity_text

_BARE_KEY = re.compile(r"[A-Za-z0-9_-]+")


class _Kept:
    """A table that is written once: two are the same where they are one object. Tables never change."""

    __slots__ = ("table",)

    def __init__(self, table: Table) -> None:
        self.table = table

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Kept) and self.table is other.table

    def __hash__(self) -> int:
        return id(self.table)


@lru_cache(maxsize=16)
def _kept_lines(kept: _Kept, path: str) -> tuple[str, ...]:
    lines: list[str] = []
    _write(kept.table.model_dump(exclude_none=True, context=AS_WRITTEN), path, lines)
    return tuple(lines)


def to_toml(table: Table, shared: Sequence[tuple[str, str]] = ()) -> str:
    """The table as TOML text; unset keys are left out, everything else is written, defaults too.

    Of keys (in a table of the table) that other tables share, the text of the last ones is kept.
    """
    tables = table.model_dump(exclude_none=True, context=AS_WRITTEN, exclude={part: {key} for part, key in shared})
    for part, key in shared:
        tables[part][key] = _Kept(getattr(getattr(table, part), key))
    return text_of(tables)


def to_short_toml(table: Table) -> str:
    """The same without what has its default value."""
    return text_of(table.model_dump(exclude_none=True, exclude_defaults=True, context=AS_WRITTEN))


def text_of(tables: Mapping[str, Any]) -> str:
    """TOML text of plain values: the keys of a table first, then the tables in it; an innermost list on one line."""
    lines: list[str] = []
    _write(tables, "", lines)
    return "\n".join(lines).lstrip("\n") + "\n"


def _write(table: Mapping[str, Any], path: str, lines: list[str]) -> None:
    inner = []
    for key, value in table.items():
        if is_table(value):
            inner.append((f"{path}{key_text(key)}", value))
        else:
            lines.append(f"{key_text(key)} = {literal(value)}")
    for name, value in inner:
        if isinstance(value, dict | _Kept):
            head = len(lines)
            lines.append(f"\n[{name}]")
            if isinstance(value, _Kept):
                lines += _kept_lines(value, f"{name}.")
            else:
                _write(value, f"{name}.", lines)
            if len(lines) > head + 1 and lines[head + 1].startswith("\n["):
                del lines[head]  # a table of tables alone
            continue
        for item in value:
            lines.append(f"\n[[{name}]]")
            _write(item, f"{name}.", lines)


def is_table(value: object) -> bool:
    """Whether it is written under a heading of its own: a table, or a list of tables."""
    first = value[0] if isinstance(value, list | tuple) and value else value
    return isinstance(first, dict | _Kept)


@cache
def key_text(key: str) -> str:
    """A key, in quotes where it needs them."""
    return key if _BARE_KEY.fullmatch(key) else _text(key)


def _text(value: str) -> str:
    """A string of JSON is one of TOML, but for the character 127."""
    return encode_basestring(value).replace("\x7f", "\\u007f")


def literal(value: Any) -> str:
    """A plain value as TOML has it; a table on one line."""
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{key_text(key)} = {literal(item)}" for key, item in value.items()) + " }"
    if isinstance(value, float):
        return repr(value)
    if isinstance(value, str):
        return _text(value)
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, list | tuple):
        if value and isinstance(value[0], list | tuple):
            return "[\n" + "".join(f"    {literal(item)},\n" for item in value) + "]"
        return f"[{', '.join(map(literal, value))}]"
    return repr(value)


def literal_on_one_line(value: Any) -> str:
    """The same, also a list of lists."""
    return literal(value).replace("\n    ", "").replace(",\n]", "]").replace(",[", ", [")


def plain(value: Any) -> Any:
    """Models as tables, tuples as lists, unset keys left out: what TOML can hold.

    A number that a file may not give without its unit is a text with it, so that the result can be read again. Numbers of NumPy
    and quantities of pint become what a file would have, also in lists.
    """
    if type(value) in (float, str, int, bool):  # nearly all are
        return value
    if isinstance(value, dict):
        return {key: plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    if isinstance(value, BaseModel):
        return plain(value.model_dump(exclude_none=True, context=AS_WRITTEN))
    if isinstance(value, Mapping):
        return plain(dict(value))
    if is_quantity(value):
        return [quantity_text(item) for item in value] if np.ndim(value.magnitude) else quantity_text(value)
    return value.tolist() if isinstance(value, np.generic | np.ndarray) else value
