"""The raw tables of a case of which some values are changed: in Python, or by a file that starts from another case.

    Case + {"motion.speed": "120 km/h"} -> [changed_tables] -> raw tables, not yet validated
    raw tables with `base` + that case -> [changes_in] -> dotted key -> value

A case that only says what is different names another one as its `base`; each value in it is a change of that one.
"""

from collections.abc import Iterator, Mapping
from typing import Any

from rollerrig.config.errors import ConfigProblem, show_value
from rollerrig.config.load.change import apply_changes
from rollerrig.config.load.resolve import relative_to
from rollerrig.config.read.document import Document
from rollerrig.config.schema.case import CaseTables, SupportChoice, VehicleChoice
from rollerrig.config.schema.units import AS_WRITTEN
from rollerrig.config.write.toml import plain

BASE, WITHOUT = "base", "without"

OWN_KEYS = {"vehicle": VehicleChoice.model_fields.keys(), "support": SupportChoice.model_fields.keys()}
"""Keys of the choice of a vehicle or support; all other keys below it are those of the vehicle or support itself."""


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
    the vehicle are changes of the new one.
    """
    own_file = "allowed: in a file; read that case and change it"  # another case would bring what nobody checked
    problems = [ConfigProblem(file, BASE, show_value(changes[BASE]), own_file)] if BASE in changes else []
    full = {whole_key(key): value for key, value in changes.items() if key != BASE}
    for part in OWN_KEYS:
        short = [key for key in full if key.startswith(f"{part}.data.") and key not in changes]
        if f"{part}.use" in full and short:
            full[f"{part}.changes"] = {key.removeprefix(f"{part}.data."): full.pop(key) for key in short}
    kept = [part for part in OWN_KEYS if all(key.partition(".")[0] != part or key == "vehicle.cut" for key in full)]
    raw: dict[str, Any] = plain(
        case.model_dump(exclude_none=True, context=AS_WRITTEN, exclude={part: {"data"} for part in kept})
    )
    for part in kept:
        raw[part]["data"] = getattr(case, part).data
    return raw, problems + [problem.shortened() for problem in apply_changes(raw, full, file)]


def changes_in(document: Document, base: CaseTables) -> tuple[dict[str, object], list[ConfigProblem]]:
    """What a file with a `base` changes of it: None where `without` takes a key away."""
    tables = {key: value for key, value in document.raw.items() if key not in (BASE, WITHOUT)}
    changes: dict[str, object] = {}
    whole = plain(base)
    for key, value in leaves(tables):
        short = key.replace("vehicle.changes.", "vehicle.", 1).replace("support.changes.", "support.", 1)
        if value != {} or not exists(whole, short):  # an empty table asks for its defaults where there is none
            changes[short] = relative_to(document.folder, short, value)
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


def exists(raw: dict[str, Any], key: str) -> bool:
    """Whether a dotted key leads somewhere in the tables."""
    holder: Any = raw
    for part in whole_key(key).split("."):
        if isinstance(holder, list):
            holder = next((item for item in holder if isinstance(item, dict) and part in item.values()), None)
        else:
            holder = holder.get(part) if isinstance(holder, dict) else None
        if holder is None:
            return False
    return True
