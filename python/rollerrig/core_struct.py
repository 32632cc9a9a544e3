"""A struct of the core from a table of the configuration, parameter by parameter under the same names.

    table, numbers that follow from the case -> [core_struct] -> object of the core

The core has no defaults: each stands once, in `rollerrig.config`. A name that is missing on either side is an error.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from typing import Any, TypeVar, cast

from pydantic import BaseModel

S = TypeVar("S")


def core_struct(struct: type[S], table: BaseModel | None = None, *, without: Collection[str] = (), **given: Any) -> S:
    """An object of a class of the core.

    Args:
        struct: the class; its attribute `fields` has the names.
        table: has a field for each parameter that is not given.
        without: fields of the table that are no parameters of the struct.
        given: parameters by name, in place of the table's.

    Raises:
        TypeError: a parameter is neither in the table nor given, or the struct does not have it.
    """
    values = _values(table, without, given)
    names = set(cast("Any", struct).fields)
    missing, unknown = names - set(values), set(values) - names
    if missing or unknown:
        raise TypeError(f"{struct.__name__}: missing {sorted(missing)}, unknown {sorted(unknown)}")
    return struct(**values)


def core_law(
    registry: Mapping[str, Any], kind: str, table: BaseModel, *, without: Collection[str] = (), **given: Any
) -> Any:
    """The law of that name in a registry of the core; the table has the parameters of all of them.

    Raises:
        TypeError: the registry has no such law, or a field of the table is a parameter of none of them.
    """
    if kind not in registry:
        raise TypeError(f"no law {kind!r}; known: {', '.join(registry)}")
    values = _values(table, (*without, "kind"), given)
    unknown = set(values) - {name for law in registry.values() for name in law.fields}
    if unknown:
        raise TypeError(f"{', '.join(registry)}: unknown {sorted(unknown)}")
    struct = registry[kind]
    return core_struct(struct, **{name: value for name, value in values.items() if name in struct.fields})


def _values(table: BaseModel | None, without: Collection[str], given: Mapping[str, Any]) -> dict[str, Any]:
    fields = type(table).model_fields if table is not None else ()
    return {name: getattr(table, name) for name in fields if name not in without} | dict(given)


def angular(frequency: float) -> float:
    """A frequency of the configuration [Hz] as the core takes it [rad/s]."""
    return 2.0 * math.pi * frequency
