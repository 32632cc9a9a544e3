"""Differences between two cases, and a case in words.

    two cases -> [differences] -> {"motion.speed": (41.7, 33.3)} -> [text_from_base] -> TOML text with `base`
    Case -> [in_words] -> Summary: (what, words) -> text, HTML

A key that one of them does not have is None there. Items of a list are identified by their names while both lists have the same
ones; else the whole list is one value.
"""

from collections.abc import Iterator
from typing import Any

from rollerrig.common.formatting import Summary, number
from rollerrig.config.errors import show_value
from rollerrig.config.schema.case import ACTUATORS, CaseTables, Contact, SupportChoice, VehicleChoice
from rollerrig.config.schema.support import Rig
from rollerrig.config.validate.messages import named_items
from rollerrig.config.write.explain import unit_of
from rollerrig.config.write.toml import plain, text_of

Raw = dict[str, Any]

OWN_KEYS = {"vehicle": VehicleChoice.model_fields.keys(), "support": SupportChoice.model_fields.keys()}
"""Keys of the choice of a vehicle or support; all other keys below it are those of the vehicle or support itself."""


class Differences(dict[str, tuple[Any, Any]]):
    """Dotted key -> (value here, value there), in SI; None where a case does not have the key. Prints a line per key."""

    def __repr__(self) -> str:
        return "\n".join(f"{key}: {a} -> {b}" for key, a, b in self.texts()) or "no difference"

    def texts(self) -> Iterator[tuple[str, str, str]]:
        """Key and both values, with the unit."""
        for key, (a, b) in self.items():
            unit = unit_of(key)
            yield key, _shown(a, unit), _shown(b, unit)


def _shown(value: object, unit: str) -> str:
    if value is None:
        return "absent"
    return f"{number(value, 6)} {unit}".rstrip() if isinstance(value, float) else show_value(value)


def tables_of(case: CaseTables) -> Raw:
    """All tables of a case as a file would have them, defaults too; all numbers plain, in SI."""
    raw: Raw = plain(case.model_dump(exclude_none=True))
    return raw


def differences(here: Raw, there: Raw) -> Differences:
    """What is different, in the order of the tables."""
    return Differences({_short_key(key): pair for key, pair in _different(here, there, "")})


def _different(here: Any, there: Any, key: str) -> Iterator[tuple[str, tuple[Any, Any]]]:
    if here == there and type(here) is type(there):
        return
    a, b = _items(here), _items(there)
    together = isinstance(here, dict) or (a is not None and b is not None and list(a) == list(b))
    if a is None or b is None or not together or type(here) is not type(there):
        yield key, (here, there)
        return
    for name in dict.fromkeys([*a, *b]):
        inner = f"{key}.{name}" if key else name
        if name in a and name in b:
            yield from _different(a[name], b[name], inner)
        else:
            yield inner, (a.get(name), b.get(name))


def _items(value: Any) -> Raw | None:
    """What may be compared one by one: the keys of a table, the named items of a list of tables."""
    if isinstance(value, dict):
        return value
    if isinstance(value, list) and value and isinstance(value[0], dict):
        return named_items(value)
    return None


def _short_key(key: str) -> str:
    """`vehicle.data.body` as `vehicle.body`, where that means the same."""
    head, _, rest = key.partition(".data.")
    own = OWN_KEYS.get(head, ())
    return f"{head}.{rest}" if own and rest and rest.split(".")[0] not in own else key


def text_from_base(name: str, changes: Differences) -> str:
    """TOML text of the case that starts from the one called `name`; `without` names what it does not have any more."""
    without = [key for key, (_, value) in changes.items() if value is None]
    tables: Raw = {"base": name, **({"without": without} if without else {})}
    for key, (_, value) in changes.items():
        if value is not None:
            _put(tables, key.split("."), value)
    return text_of(tables)


def _put(tables: Raw, path: list[str], value: Any) -> None:
    for part in path[:-1]:
        tables = tables.setdefault(part, {})
    tables[path[-1]] = value


def in_words(case: CaseTables) -> Summary:
    """What the case is made of, a row each."""
    vehicle, support, contact, time = case.vehicle, case.support.data, case.contact, case.time
    part = "" if vehicle.cut == "vehicle" else f", {vehicle.cut}"
    bodies = [body.name for body in vehicle.bodies]
    method, step = case.integration
    acting = [name for name in (*ACTUATORS, "axle_torque", "disturbance") if getattr(case, name)]
    names = ", ".join(bodies if len(bodies) <= 4 else [*bodies[:2], f"{bodies[2]} and {len(bodies) - 3} more"])
    found = [
        ("vehicle", f"{vehicle.data.name}{part}: {names}"),
        ("support", support.name + (f", rollers of {1e3 * support.roller_radius:g} mm" if isinstance(support, Rig) else "")),
        ("motion", f"{3.6 * case.motion.speed:.4g} km/h at the start, {case.motion.drive.replace('_', ' ')}"),
        ("contact", ", ".join((contact.material.name, f"friction {_friction(contact)}", contact.normal.kind,
                               contact.creep.kind))),
        ("time", f"{time.duration:g} s, kept every {1e3 * time.output_step:g} ms; {method}"
                 + (f", step {1e3 * step:g} ms" if step else "")),
    ]  # fmt: skip
    headline = f"Case {case.name}" + (f": {case.description}" if case.description else "")
    return Summary(headline, (*found, *([("acting", ", ".join(acting))] if acting else [])))


def _friction(contact: Contact) -> str:
    law, face = contact.friction, contact.gauge_face_friction
    top = f"{law.mu_0:g}" if law.kind == "constant" else law.kind
    return top if face is None else f"{top} ({face:g} on the gauge face)"
