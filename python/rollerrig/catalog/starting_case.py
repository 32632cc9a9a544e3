"""A case to begin with: another one, written with what each key means and what else could be said.

name, case of the catalogue or file -> [starting_case] -> TOML text with comments
"""

from __future__ import annotations

import textwrap
import tomllib
from pathlib import Path
from typing import Any

from rollerrig.config import load_case
from rollerrig.config.errors import ConfigError, ConfigProblem, show_value
from rollerrig.config.read import catalog_file, catalog_names, schema_uri
from rollerrig.config.schema.vehicle import Vehicle
from rollerrig.config.write.differences import OWN_KEYS
from rollerrig.config.write.explain import KeyPlace, key_places, unit_text
from rollerrig.config.write.toml import is_table, key_text, literal, literal_on_one_line, plain

Raw = dict[str, Any]

START = "bogie_rollers_constant"
"""The case that a new one starts from unless another one is named."""

_WIDTH = 110
_NAME = "name"


def starting_case(name: str, source: str | Path = START) -> str:
    """Text of a case that runs as it stands, each key explained above it, the plain defaults of its tables as comments.

    Args:
        name: of the new case.
        source: a case of the catalogue, which is copied, or a file, from which the new one starts (`base`).

    Raises:
        ConfigError: there is no such case, or the name cannot be one.

    Example:
        >>> starting_case("mine").splitlines()[5:7]
        ['# name, in results and messages', 'name = "mine"']
    """
    case = load_case(source)
    try:
        case.with_changes({_NAME: name})
    except ConfigError:
        allowed = "allowed: a name of at most 60 letters, digits, _ and -"
        raise ConfigError([ConfigProblem("new", _NAME, show_value(name), allowed)]) from None
    if str(source) in catalog_names("case"):
        raw = tomllib.loads(catalog_file("case", str(source)).read_text("utf-8"))
    else:
        raw = {"base": str(Path(source).absolute()), "description": case.description}
        raw["motion"] = {"speed": f"{case.motion.speed!r} m/s"}
    raw = {"name": name, **{key: value for key, value in raw.items() if key != _NAME}}
    heading = [
        f"#:schema {schema_uri('case')}",
        f"# Made from {Path(source).name}. Numbers are in SI, texts have a unit. `rollerrig explain KEY` says more.",
        f"#   rollerrig check {name}.toml",
        f"#   rollerrig run {name}.toml --out {name}-run",
    ]
    lines: list[str] = []
    _table(raw, "", lines)
    return "\n".join([*heading, "", *lines]) + "\n"


def _table(table: Raw, above: str, lines: list[str]) -> None:
    """The plain keys of a table, what else it could have, then the tables in it."""
    inner = {key: value for key, value in table.items() if is_table(value)}
    for key, value in table.items():
        if key not in inner:
            lines += [*_meaning(f"{above}{key}"), f"{key_text(key)} = {literal(value)}"]
    lines += _offered(table, above)
    for key, value in inner.items():
        for item in value if isinstance(value, list) else [value]:
            name, own = f"{above}{key}", list[str]()
            _table(item, f"{name}.", own)
            heading = ["", f"[[{name}]]" if isinstance(value, list) else f"[{name}]"]
            lines += own if own[:1] == [""] else [*heading, *own]  # the first: a table of tables alone


def _place(key: str) -> KeyPlace | None:
    found = [place for place in key_places() if place.file == "case" and place.matches(key.split("."))]
    return min(found, key=lambda place: (place.key != key, place.table is Vehicle), default=None)


def _meaning(key: str) -> list[str]:
    """What a key means, as comments; of a key without a description nothing."""
    place = _place(key)
    if place is None or not place.field.description or key.endswith((".kind", ".body", ".wheelset")):
        return []
    return [f"# {line}" for line in textwrap.wrap(_said(place), _WIDTH)]


def _said(place: KeyPlace) -> str:
    """Its description, with the unit."""
    unit = unit_text(place.field)
    return f"{place.field.description or ''} {f'[{unit}]' if unit else ''}".strip()


def _offered(table: Raw, above: str) -> list[str]:
    """Plain keys that a table could have beside those it has: default and meaning, one line each."""
    table_of = above.rstrip(".")
    places = [one for one in key_places() if one.file == "case" and one.key.rpartition(".")[0] == table_of]
    if not places or table_of.split(".")[0] in ("", *OWN_KEYS):  # a vehicle or support in use has its own values
        return []
    if len({place.table for place in places}) > 1:  # each has its own
        return [f"# It has several kinds: `rollerrig explain {above.rstrip('.')}` lists their keys."]
    lines = []
    for place in places:
        key, default = place.key.rpartition(".")[2], place.field.default
        if key not in table and isinstance(default, str | float | int | tuple) and default not in ("", ()):
            lines.append(f"# {key} = {literal_on_one_line(plain(default))}  # {_said(place)}".rstrip(" #"))
    return ["# what it has by default:", *lines] if lines else []
