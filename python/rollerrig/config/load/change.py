"""Changes of a case by dotted keys, and its tables with them.

    raw tables + {"body.car_body.mass": "30 t"} -> [apply_changes] -> raw tables, not yet validated
    Case + {"motion.speed": "120 km/h"} -> [changed_tables] -> raw tables, not yet validated
    raw tables with `base` + that case -> [changes_in] -> dotted key -> value

A case that only says what is different names another one as its `base`; each value in it is a change of that one.
"""

import re
from collections.abc import Iterator, Mapping, Sequence
from fnmatch import fnmatchcase
from functools import cache
from typing import Any

from rollerrig.config.errors import ConfigProblem, nearest, one_of, show_value
from rollerrig.config.load.resolve import HEADS, relative_to
from rollerrig.config.read import Document
from rollerrig.config.schema.case import CaseTables
from rollerrig.config.schema.units import AS_WRITTEN, KEY_SUFFIXES
from rollerrig.config.validate.messages import item_labels, named_items, tables_below, tag_of
from rollerrig.config.write.differences import OWN_KEYS
from rollerrig.config.write.toml import plain

# A new value of the first makes the second meaningless.
_REPLACES = {
    "use": ("data",),
    "young_modulus": ("shear_modulus",),
    "shear_modulus": ("young_modulus",),
    "poisson_ratio": ("shear_modulus",),
    "stiffness": ("table",),
    "table": ("stiffness", "constant"),
    "constant": ("table",),
    "damping": ("damping_table",),
    "damping_table": ("damping",),
    "point": ("points",),
    "points": ("point",),
    "speed_table": ("speed",),
    "gauge": ("contact_distance",),
    "contact_distance": ("gauge",),
}


def apply_changes(raw: dict[str, Any], changes: Mapping[str, object], file: str, at: str = "") -> list[ConfigProblem]:
    """Write each value to its key in ``raw``; None removes the key.

    Args:
        raw: tables, changed in place.
        changes: dotted key -> value; items of a list are addressed by name or index; a part of a key with `*` stands for all
            that exist and match.
        file: what the problems name.
        at: the key under which ``changes`` themselves stand, for the problems.

    Returns:
        Keys that lead nowhere. Whether the values are allowed is found by validation.
    """
    problems = []
    for key, value in changes.items():
        path = parts_of(key)
        matching = matching_paths(raw, path, key, file) if "*" in key else [path]
        if isinstance(matching, ConfigProblem):
            problems.append(matching.within(at))
            continue
        for found in matching:
            problem = _write(raw, key if found is path else ".".join(found), plain(value), set(changes), file)
            if problem:
                problems.append(problem.within(at))
    return problems


def parts_of(key: str) -> list[str]:
    """Parts of a dotted key; `body[1]` is that of `body.1`."""
    return re.sub(r"\[(\d+)\]", r".\1", key).split(".")


def matching_paths(holder: Any, path: list[str], key: str, file: str) -> list[list[str]] | ConfigProblem:
    """All paths that exist and match one with `*` in it; a problem where none does."""
    if "*" not in ".".join(path):
        return [path]
    first, rest = path[0], path[1:]
    items = named_items(holder) if isinstance(holder, list) else holder if isinstance(holder, dict) else {}
    if first.isdecimal() and int(first) < len(items) and first not in items:
        first = list(items)[int(first)]
    matching = [name for name in items if fnmatchcase(name, first)]
    if isinstance(holder, dict) and "*" in first and rest:  # of a table's keys, those below which the next one exists
        tables = {name: item for name, item in items.items() if isinstance(item, dict)}
        matching = [n for n in matching if n in tables and ("*" in rest[0] or rest[0] in tables[n])]
    paths: list[list[str]] = []
    for name in matching:
        found = matching_paths(items[name], rest, key, file)
        if isinstance(found, ConfigProblem):
            return found
        paths += [[name, *tail] for tail in found]
    hint = _nearest_pattern(first, tuple(items))
    return paths or ConfigProblem(file, key, f"nothing matches '{first}'", one_of(items), hint)


def _nearest_pattern(pattern: str, names: tuple[str, ...]) -> str:
    """The pattern that was probably meant: one whose beginning some names have."""
    head, _, tail = pattern.partition("*")
    heads = tuple(dict.fromkeys(name[: end.end()] for name in names for end in re.finditer("_", name)))
    meant = f"{nearest(head, heads)}*{tail}" if head else "*"
    return meant if meant[0] != "*" and any(fnmatchcase(n, meant) for n in names) else nearest(pattern, names)


def _write(raw: dict[str, Any], key: str, value: object, keys: set[str], file: str) -> ConfigProblem | None:
    *path, last = parts_of(key)
    holder: Any = raw
    for part in path:
        if isinstance(holder, dict):
            if part in HEADS and isinstance(holder.get(part), str):  # a name, in place of which a table is written
                holder[part] = {}
            holder = holder.setdefault(part, {})
        elif (index := _index(holder, part)) is not None:
            holder = holder[index]
        else:
            return _nowhere(holder, part, key, value, file)
    if (index := _index(holder, last)) is not None:
        holder[index] = value
        return None
    if not isinstance(holder, dict):
        return _nowhere(holder, last, key, value, file)
    holder.pop(last, None)
    if value is not None:
        holder[last] = value
        base, _, suffix = last.rpartition("_")
        spellings = (base,) if suffix in KEY_SUFFIXES else tuple(f"{last}_{suffix}" for suffix in KEY_SUFFIXES)
        for sibling in (*_REPLACES.get(last, ()), *spellings, *(_of_other_kinds(value) if last == "kind" else ())):
            if key.removesuffix(last) + sibling not in keys:
                holder.pop(sibling, None)
    return None


@cache
def _keys_by_kind() -> Mapping[str, frozenset[str]]:
    """Keys of the tables of each `kind`, those of the same word together."""
    found: dict[str, frozenset[str]] = {}
    for table in tables_below(CaseTables):
        if tag := tag_of(table):
            found[tag] = found.get(tag, frozenset()) | table.model_fields.keys()
    return found


def _of_other_kinds(kind: object) -> frozenset[str]:
    """Keys that a table of another kind may have and one of this kind may not: they go where the kind is changed."""
    own = _keys_by_kind().get(str(kind))
    return frozenset().union(*_keys_by_kind().values()) - own if own else frozenset()


def _index(items: Any, part: str) -> int | None:
    """Number of the item of a list that a part of a key names; None where there is none, or no list."""
    if not isinstance(items, list):
        return None
    if part.isdecimal() and len(part) < 10:
        return int(part) if int(part) < len(items) else None
    labels = item_labels(items)
    return labels.index(part) if part in labels else None


def _nowhere(holder: Any, part: str, key: str, value: object, file: str) -> ConfigProblem:
    if not isinstance(holder, list):
        return ConfigProblem(file, key, show_value(value), f"allowed: keys that exist; '{part}' is inside a value")
    labels = item_labels(holder)
    return ConfigProblem(file, key, f"no item '{part}'", one_of(labels), nearest(part, labels))


BASE, WITHOUT = "base", "without"


def whole_key(key: str) -> str:
    """`vehicle.body.car_body.mass` as `vehicle.data.body.car_body.mass`."""
    head, _, rest = key.partition(".")
    is_short = head in OWN_KEYS and rest and rest.split(".")[0] not in OWN_KEYS[head]
    return f"{head}.data.{rest}" if is_short else key


def changed_tables(
    case: CaseTables, changes: Mapping[str, object], file: str
) -> tuple[dict[str, Any], list[ConfigProblem]]:
    """Tables of a case with some values replaced, and the keys among them that lead nowhere.

    A vehicle or support that no change concerns stays the checked object that it is. Beside a new `vehicle.use` the other keys of
    the vehicle are those of the new one.
    """
    own_file = "allowed: in a file; read that case and change it"  # another case would bring what nobody checked
    problems = [ConfigProblem(file, BASE, show_value(changes[BASE]), own_file)] if BASE in changes else []
    beside = [key for key in changes if whole_key(key) != key and f"{key.partition('.')[0]}.use" in changes]
    full = {whole_key(key): value for key, value in changes.items() if key != BASE and key not in beside}
    kept = [part for part in OWN_KEYS if all(key.partition(".")[0] != part or key == "vehicle.cut" for key in full)]
    left_out = {part: {"data"} for part in kept}
    raw: dict[str, Any] = plain(case.model_dump(exclude_none=True, context=AS_WRITTEN, exclude=left_out))
    for part in kept:
        raw[part]["data"] = getattr(case, part).data
    for part, _, key in (key.partition(".") for key in beside):
        raw[part][key] = plain(changes[f"{part}.{key}"])
    return raw, problems + [problem.shortened() for problem in apply_changes(raw, full, file)]


def changes_in(document: Document, base: CaseTables) -> tuple[dict[str, object], list[ConfigProblem]]:
    """What a file with a `base` changes of it: None where `without` takes a key away."""
    tables = {key: value for key, value in document.raw.items() if key not in (BASE, WITHOUT)}
    changes: dict[str, object] = {}
    whole = plain(base)
    for key, value in new_leaves(tables, whole):
        changes[key] = relative_to(document.folder, key, value)
    problems = []
    taken = document.raw.get(WITHOUT, [])
    for key in taken if isinstance(taken, list) else [taken]:
        if not isinstance(key, str) or not exists(whole, key):
            allowed = f"allowed: a list of dotted keys that {base.name} has, like 'disturbance'"
            problems.append(ConfigProblem(document.file, WITHOUT, show_value(key), allowed))
        else:
            changes[key] = None
    return changes, problems


def leaves(table: Mapping[str, Any], above: str = "") -> Iterator[tuple[str, Any]]:
    """Values with their dotted keys; an empty table is one, a list is one."""
    for key, value in table.items():
        if isinstance(value, Mapping) and value:
            yield from leaves(value, f"{above}{key}.")
        else:
            yield f"{above}{key}", value


def new_leaves(table: Mapping[str, Any], old: dict[str, Any]) -> Iterator[tuple[str, Any]]:
    """The same without an empty table where the old tables have one: it asks for defaults where there is none."""
    return ((key, value) for key, value in leaves(table) if value != {} or not exists(old, key))


def exists(raw: dict[str, Any], key: str) -> bool:
    """Whether a dotted key leads somewhere in the tables."""
    return value_in(raw, parts_of(whole_key(key))) is not None


def value_in(tables: Any, path: Sequence[str]) -> Any:
    """What is in tables at the parts of a key; None: nothing."""
    for part in path:
        if (index := _index(tables, part)) is not None:
            tables = tables[index]
        else:
            tables = tables.get(part) if isinstance(tables, dict) else None
    return tables
