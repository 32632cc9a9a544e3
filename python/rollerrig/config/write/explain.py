"""What a key of a file means, in words: for the command line and for Python.

pydantic models -> [key_places] -> every dotted key with its table -> [explain] -> meaning, unit, default, range, users
"""

import re
import tomllib
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from textwrap import shorten
from typing import Any, Literal, get_args, get_origin

from pydantic import BaseModel
from pydantic.fields import FieldInfo

from rollerrig.config.errors import nearest
from rollerrig.config.read import CatalogKind, catalog_file, catalog_names
from rollerrig.config.schema.base import INSTEAD_OF, OrShort, by_kind, quantity_of
from rollerrig.config.schema.case import SupportChoice, VehicleChoice
from rollerrig.config.schema.units import Quantity
from rollerrig.config.validate.messages import alternatives, divided, meant, tables_in, tag_of
from rollerrig.config.write.json_schema import ROOTS

_FILES: tuple[CatalogKind, ...] = ("case", "programme", "plan", "fit")
"""Kinds of files whose keys are explained; those of the others are in a case."""
_MOST_CASES = 4
_MOST_GUESSES = 4
_MOST_ROWS = 12
_WORD = re.compile(r"[._\s]+")


@dataclass(frozen=True)
class KeyPlace:
    """A key that a file may have."""

    key: str  # dotted; names of list items are left out
    file: str  # kind of file
    table: type[BaseModel]  # where it stands
    field: FieldInfo  # what the table says about it
    lists: frozenset[int]  # numbers of the parts of the key that are lists of tables or tables by name

    def matches(self, parts: list[str]) -> bool:
        """Whether a dotted key leads here; after a list it may have the name or number of an item."""
        own, taken = self.key.split("."), 0
        for number, part in enumerate(own):
            if taken >= len(parts) or parts[taken] != part:
                return False
            taken += 1
            after = own[number + 1 : number + 2]
            named = number in self.lists and taken < len(parts) and parts[taken : taken + 1] != after
            taken += named
        return taken == len(parts)


@cache
def key_places() -> tuple[KeyPlace, ...]:
    """Every key of a case, programme, plan and fit; those of `vehicle.data` and `support.data` as `vehicle` and `support`."""
    return tuple(place for file in _FILES for place in _places(ROOTS[file], "", file, frozenset()))


def _places(table: type[BaseModel], above: str, file: str, lists: frozenset[int]) -> Iterator[KeyPlace]:
    for name, field in table.model_fields.items():
        key = f"{above}.{name}" if above else name
        is_part = name == "data" and table in (VehicleChoice, SupportChoice)
        inner, is_list = _below(field.annotation)
        below = lists | {key.count(".")} if is_list else lists
        if not is_part:
            yield KeyPlace(key, file, table, field, below)
        for one in inner:
            yield from _places(one, above if is_part else key, file, below)


def _below(annotation: Any) -> tuple[tuple[type[BaseModel], ...], bool]:
    """Tables that stand at a key, and whether there are several of them by name or number."""
    if direct := tables_in(annotation):
        return direct, False
    for part in (annotation, *get_args(annotation)):
        if get_origin(part) in (tuple, dict) and (
            tables := tables_in(get_args(part)[0 if get_origin(part) is tuple else 1])
        ):
            return tables, True
    return (), False


def explain(key: str) -> str:
    """What a key means: unit, default, what is allowed, in which table it stands, who uses it.

    Args:
        key: dotted (`motion.speed`, `vehicle.element.primary_1_left.x.stiffness`), or its last part alone.

    Returns:
        The explanation; of words that are no key, the keys whose names or texts have them all, the best first.

    Raises:
        KeyError: there is neither; the text has the nearest key.

    Example:
        >>> explain("time.duration").splitlines()[2].split()
        ['unit', 's']
    """
    parts = re.sub(r"\[(\d+)\]", r".\1", key.strip())
    parts = parts.replace("vehicle.data.", "vehicle.").replace("support.data.", "support.")
    found = [place for place in key_places() if place.key == parts]
    found = found or [place for place in key_places() if place.matches(parts.split("."))]
    found = found or [place for place in key_places() if place.key.endswith(f".{parts}")]
    if not found:
        return _unknown(key)
    texts = _texts(found)
    different = dict.fromkeys(place.key for place in found)
    if len(texts) > 3 and len(different) > 1:
        meanings = {place.key: place.field.description or "" for place in reversed(found)}  # the first of each key
        lines = [f"{name:<{max(map(len, different))}}  {meanings[name]}" for name in different]
        return "\n".join([f"{len(different)} keys end in '{parts}':", *lines])
    return "\n\n".join(texts)


@cache
def unit_of(key: str) -> str:
    """Unit of a number at a dotted key, as `explain` says it; "" where it has none, or several that differ."""
    units = {
        quantity.unit if (quantity := quantity_of(place.field.annotation, place.field.metadata)) else ""
        for place in key_places()
        if place.matches(key.split("."))
    }
    return units.pop() if len(units) == 1 and units != {"1"} else ""


def _unknown(key: str) -> str:
    """Keys that speak of the words of what is no key; a KeyError where none does."""
    last = key.rpartition(".")[2]
    if where := divided(key) or divided(last):
        raise KeyError(f"{key}: {where}")
    keys = tuple(dict.fromkeys(place.key for place in key_places()))
    lasts = tuple(dict.fromkeys(name.rpartition(".")[2] for name in keys))
    words = _WORD.split(key)
    holding = [name for name in keys if set(words) <= set(_WORD.split(name))]
    holding = [name for name in holding if name.rpartition(".")[2] in words] or holding
    if not holding and (rows := search(words)):
        return "\n".join([f"no key is called '{key}'; these speak of it:", *rows])
    if not holding and (guess := ("." in key and nearest(key, keys)) or meant(last, lasts)):
        ending = [name for name in keys if name == guess or name.endswith(f".{guess}")]
        holding = ending if len(ending) <= _MOST_GUESSES else [guess]
    hint = f"; did you mean {_listed(holding)}?" if holding else ""
    raise KeyError(f"{key}: no such key{hint or '; rollerrig schema prints all keys'}")


def search(words: list[str]) -> list[str]:
    """Keys with their meanings, a line each, that have all words in their names or texts; the best first."""
    patterns = [re.compile(rf"(?<![a-z]){re.escape(word.lower())}") for word in words if word]
    scores: dict[str, tuple[int, str]] = {}
    for place in key_places():
        tags = " ".join(tag for table in _below(place.field.annotation)[0] if (tag := tag_of(table)))
        text = place.field.description or ""
        weighted = ((8, place.key.rpartition(".")[2]), (4, place.key), (3, tags), (2, text), (1, _summary(place.table)))
        hits = [sum(w for w, where in weighted if one.search(where.lower())) for one in patterns]
        if patterns and all(hits) and sum(hits) > scores.get(place.key, (0, ""))[0]:
            scores[place.key] = sum(hits), text
    ranked = sorted(scores.items(), key=lambda item: (-item[1][0], item[0].count("."), item[0]))[:_MOST_ROWS]
    width = max((len(name) for name, _ in ranked), default=0)
    return [f"  {name:<{width}}  {shorten(text, 100, placeholder=' ...')}" for name, (_, text) in ranked]


def _listed(names: list[str]) -> str:
    more = [f"one of {len(names) - _MOST_GUESSES} more"] if len(names) > _MOST_GUESSES else []
    return " or ".join([*(f"'{name}'" for name in names[:_MOST_GUESSES]), *more])


def _texts(places: list[KeyPlace]) -> list[str]:
    """What is said of each key; of one that several kinds of a table have alike it is said once."""
    same: dict[tuple[str, str, str], list[KeyPlace]] = {}
    for place in places:
        same.setdefault((place.key, place.file, _text([place]).partition("  belongs to")[0]), []).append(place)
    return list(dict.fromkeys(_text(alike) for alike in same.values()))


def _text(alike: list[KeyPlace]) -> str:
    place = alike[0]
    field = place.field
    holder = place.key.rpartition(".")[0]
    tags = [f"'{tag}'" for one in alike if (tag := tag_of(one.table)) and not one.key.endswith(".kind")]
    kind = f" of kind {' or '.join(tags)}" if tags else ""
    summary = f": {_summary(place.table)}" if len(alike) == 1 else ""
    rows = [
        ("meaning", field.description or ""),
        ("unit", unit_text(field) or "none"),
        ("default", _default(field)),
        ("allowed", _allowed(place)),
        ("belongs to", f"[{holder}]{kind} of a {place.file}{summary}" if holder else f"a {place.file}"),
        ("used by", _users(place)),
        *_keys_in(field),
    ]
    return "\n".join([place.key, *(f"  {what:10} {text}" for what, text in rows if text)])


def _allowed(place: KeyPlace) -> str:
    """A number with its unit, names of kinds, or the type; what is shorter than a table first."""
    quantity = _quantity_at(place.field)
    words = _type_text(place.field)
    if quantity is None:
        tags = [tag for table in _below(place.field.annotation)[0] if (tag := tag_of(table))]
        words = f"a {words}" if words.startswith("table") and not words.startswith("tables") else words
        whole = f"{words} of a kind: {', '.join(tags)}" if tags else words
        return " or ".join([*_shorter(place), whole])
    parts = words.split(" or ")
    choices = [word for word in parts if word.startswith('"')]
    lists = [f"{word}, each " for word in parts if word.startswith("list of")]
    return " or ".join([*choices, "".join(lists) + quantity.allowed.removeprefix("allowed: ")])


def _shorter(place: KeyPlace) -> Iterator[str]:
    """What a file may write in place of a table."""
    if not _below(place.field.annotation)[0]:
        return
    if place.key.rpartition(".")[2] in ("profile", "right_profile", "material"):
        yield "a name of the catalogue or a file"
    types = {"string": "a text", "number": "a number"}
    for mark in _marks(place.field.annotation, place.field.metadata):
        if isinstance(mark, by_kind):
            yield "the name of a kind"
        for short in mark.alternatives if isinstance(mark, OrShort) else ():
            kinds = short.get("type", ())
            yield ", ".join(short["enum"]) if "enum" in short else types[kinds if isinstance(kinds, str) else kinds[0]]


def _marks(annotation: Any, metadata: Any = ()) -> Iterator[Any]:
    yield from (*metadata, *getattr(annotation, "__metadata__", ()))
    if get_origin(annotation) not in (tuple, dict):
        for part in get_args(annotation):
            yield from _marks(part)


def _keys_in(field: FieldInfo) -> Iterator[tuple[str, str]]:
    """Keys of the tables that may stand there, a row per kind."""
    for table in _below(field.annotation)[0]:
        yield "keys in it", (f"'{tag_of(table)}': " if tag_of(table) else "") + ", ".join(table.model_fields)


def _summary(table: type[BaseModel]) -> str:
    return (table.__doc__ or "").strip().splitlines()[0]


def _users(place: KeyPlace) -> str:
    """Entries of the catalogue in which the key is written."""
    names = [f"{kind} {name}" for kind, name, keys in _written() if any(place.matches(key) for key in keys)]
    if not names:
        return "no file of the catalogue"
    more = f" and {len(names) - _MOST_CASES} more" if len(names) > _MOST_CASES else ""
    return ", ".join(names[:_MOST_CASES]) + more


@cache
def _written() -> tuple[tuple[str, str, tuple[list[str], ...]], ...]:
    """Kind, name and keys of the entries of the catalogue, as a case would have them."""
    heads: dict[CatalogKind, str] = {
        "case": "", "vehicle": "vehicle", "support": "support", "material": "contact.material", "programme": ""
    }  # fmt: skip
    found = []
    for kind, head in heads.items():
        for name in catalog_names(kind):
            raw = tomllib.loads(catalog_file(kind, name).read_text("utf-8"))
            keys = dict.fromkeys(_keys_of(raw, head))
            found.append((kind, name, tuple(key.replace(".data.", ".").split(".") for key in keys)))
    return tuple(found)


def _keys_of(value: Any, above: str) -> Iterator[str]:
    for key, inner in value.items():
        here = f"{above}.{key}" if above else key
        yield here
        items = inner if isinstance(inner, list) else [inner]
        for item in items:
            if isinstance(item, dict):
                yield from _keys_of(item, here)


# ------------------------------------------------------------------------------------------------ one field in words


def _quantity_at(field: FieldInfo) -> Quantity | None:
    """The quantity of a number, or of the numbers of a list; None where tables may stand."""
    return None if _below(field.annotation)[0] else quantity_of(field.annotation, field.metadata)


def unit_text(field: FieldInfo) -> str:
    """Both units of a table of pairs, else the one unit; "" where there is none."""
    for part in alternatives(field.annotation):
        row = get_args(part)[:1]
        if row and get_origin(row[0]) is tuple and len(get_args(row[0])) == 2:
            first, second = map(quantity_of, get_args(row[0]))
            return f"{first.unit if first else ''}, {second.unit if second else ''}"
    quantity = _quantity_at(field)
    return quantity.unit if quantity and quantity.unit != "1" else ""


def _type_text(field: FieldInfo) -> str:
    """What may stand at a field, in words."""
    names: list[str] = []
    for part in alternatives(field.annotation):
        origin, arguments = get_origin(part), get_args(part)
        if origin is Literal:
            names.append(" or ".join(f'"{choice}"' for choice in arguments))
        elif isinstance(part, type) and issubclass(part, BaseModel):
            names.append("table")
        elif origin is tuple:
            names.append(_tuple_type(arguments))
        elif origin is dict:
            names.append("tables by name")
        else:
            plain = {str: "text", bool: "true or false", int: "whole number"}
            number = "quantity" if _quantity_at(field) else "number"
            names.append(number if part is float else plain.get(part, "value"))
    return " or ".join(dict.fromkeys(names))


def _tuple_type(arguments: tuple[Any, ...]) -> str:
    if len(arguments) == 2 and arguments[1] is Ellipsis:
        first = alternatives(arguments[0])[0]
        if isinstance(first, type) and issubclass(first, BaseModel):
            return "array of tables"
        if get_origin(first) is tuple:
            return "rows of two numbers"
        return "list of texts" if first is str or get_origin(first) is Literal else "list of numbers"
    inner = "points" if get_origin(alternatives(arguments[0])[0]) is tuple else "values"
    return f"list of {len(arguments)} {inner}"


def _number(value: object) -> str:
    if isinstance(value, tuple):
        return f"[{', '.join(map(_number, value))}]"
    return f"{value:g}" if isinstance(value, float) else str(value)


def _default(field: FieldInfo) -> str:
    """The default as a file would have it, or why there is none."""
    if isinstance(field.json_schema_extra, dict) and INSTEAD_OF in field.json_schema_extra:
        return f"this or '{field.json_schema_extra[INSTEAD_OF]}'"
    if field.is_required():
        return "none: it must be given"
    default = field.default
    if isinstance(default, BaseModel):
        return f"'{default.kind}'" if hasattr(default, "kind") else "that of the keys in it"
    if default is None or default in ((), {}, ""):
        return "none: absent" if default is None else "none: empty"
    if isinstance(default, bool):
        return "true" if default else "false"
    if isinstance(default, tuple):
        return ", ".join(map(_number, default))
    return f'"{default}"' if isinstance(default, str) else f"{default:g}"
