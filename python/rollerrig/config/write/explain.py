"""What a key of a file means, in words: for the command line and for Python.

pydantic models -> [key_places] -> every dotted key with its table -> [explain] -> meaning, unit, default, range, users
"""

import re
import tomllib
import types
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cache
from textwrap import shorten
from typing import Annotated, Any, Literal, Union, get_args, get_origin

from pydantic import BaseModel
from pydantic.fields import FieldInfo

from rollerrig.config.errors import nearest
from rollerrig.config.read import CatalogKind, catalog_file, catalog_names
from rollerrig.config.schema.base import INSTEAD_OF, OrShort, by_kind, quantities_in
from rollerrig.config.schema.case import SupportChoice, VehicleChoice
from rollerrig.config.schema.units import Quantity
from rollerrig.config.validate.messages import meant, tables_in, tag_of
from rollerrig.config.write.json_schema import ROOTS
from rollerrig.config.write.toml import literal_on_one_line, plain

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
    parts = key.split(".")
    units = {unit_text(place.field).partition(", ")[0] for place in key_places() if place.matches(parts)}
    return units.pop() if len(units) == 1 else ""


def _unknown(key: str) -> str:
    """Keys that speak of the words of what is no key; a KeyError where none does."""
    last = key.rpartition(".")[2]
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
        ("allowed", " or ".join(dict.fromkeys(_allowed(field.annotation, _marks(place))))),
        ("belongs to", f"[{holder}]{kind} of a {place.file}{summary}" if holder else f"a {place.file}"),
        ("used by", _users(place)),
        *_keys_in(field),
    ]
    return "\n".join([place.key, *(f"  {what:10} {text}" for what, text in rows if text)])


def _marks(place: KeyPlace) -> list[Any]:
    """What the annotation of a key says beside its type, and that a part of a case may be named."""
    is_named = place.key.rpartition(".")[2] in ("profile", "right_profile", "material")
    return [*([OrShort(words="a name of the catalogue or a file")] if is_named else []), *place.field.metadata]


def _keys_in(field: FieldInfo) -> Iterator[tuple[str, str]]:
    """Keys of the tables that may stand there, a row per kind."""
    for table in _below(field.annotation)[0]:
        yield "keys in it", (f"'{tag_of(table)}': " if tag_of(table) else "") + ", ".join(table.model_fields)


def _summary(table: type[BaseModel]) -> str:
    return (table.__doc__ or "").strip().partition("\n")[0]


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


def unit_text(field: FieldInfo) -> str:
    """The unit of a number, those of the columns of rows; "" where there is none."""
    units = dict.fromkeys(quantity.unit for quantity in quantities_in(field.annotation, field.metadata))
    return ", ".join(units) if set(units) != {"1"} else ""


def _allowed(annotation: Any, marks: Any = ()) -> Iterator[str]:
    """What may stand there, one possibility after the other, the shortest first."""
    origin, parts = get_origin(annotation), get_args(annotation)
    if origin is Annotated:
        yield from _allowed(parts[0], (*marks, *parts[1:]))
        return
    if quantity := next((mark for mark in marks if isinstance(mark, Quantity)), None):
        yield quantity.allowed.removeprefix("allowed: ")
        return
    for mark in marks:
        if isinstance(mark, by_kind | OrShort):
            yield mark.words
    if origin is Literal:
        yield from (f'"{choice}"' for choice in parts)
    elif origin in (Union, types.UnionType):
        tables = [part for part in parts if isinstance(part, type) and issubclass(part, BaseModel) and tag_of(part)]
        if tables:
            yield f"a table of a kind: {', '.join(map(tag_of, tables))}"
        for part in parts:
            if part not in tables:
                yield from _allowed(part)
    elif origin is dict:
        yield f"tables by name, each {' or '.join(_allowed(parts[1]))}"
    elif origin is tuple:
        each = dict.fromkeys(" or ".join(_allowed(part)) for part in parts if part is not Ellipsis)
        yield f"a list{'' if Ellipsis in parts else f' of {len(parts)}'}, each {'; then '.join(each)}"
    elif annotation is int:
        yield f"a whole number{_ends(marks)}"
    elif annotation is not types.NoneType:
        yield _TYPES.get(annotation, "a table")


def _ends(marks: Iterable[Any]) -> str:
    """The range of a whole number in words."""
    limits = [limit for mark in marks for limit in (mark.metadata if isinstance(mark, FieldInfo) else (mark,))]
    least, most, below = (
        next((getattr(one, end) for one in limits if hasattr(one, end)), None) for end in ("ge", "le", "lt")
    )
    most = below - 1 if below is not None else most
    if least is None:
        return ""
    return f", at least {least}" if most is None else f", from {least} to {most}"


_TYPES = {str: "a text", bool: "true or false", float: "a number", Any: "a value"}


def _default(field: FieldInfo) -> str:
    """The default as a file would have it, or why there is none."""
    if isinstance(field.json_schema_extra, dict) and INSTEAD_OF in field.json_schema_extra:
        return f"this or '{field.json_schema_extra[INSTEAD_OF]}'"
    if field.is_required():
        return "none: it must be given"
    if field.default is None or field.default in ((), {}, ""):
        return "none: absent" if field.default is None else "none: empty"
    if isinstance(field.default, BaseModel):
        return f"'{field.default.kind}'" if hasattr(field.default, "kind") else "that of the keys in it"
    return literal_on_one_line(plain(field.default))
