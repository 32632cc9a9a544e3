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


def _values(table: BaseModel | None, without: Collection[str], given: Mapping[str, Any]) -> dict[str, Any]:
    fields = type(table).model_fields if table is not None else ()
    return {name: getattr(table, name) for name in fields if name not in without} | dict(given)


def angular(frequency: float) -> float:
    """A frequency of the configuration [Hz] as the core takes it [rad/s]."""
    return 2.0 * math.pi * frequency
