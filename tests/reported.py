"""Whether summaries and the registry of reported quantities agree."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from rollerrig.study.quantities import COMMON, Numbers, Quantities


def unexplained(quantities: Quantities, numbers: Numbers) -> list[str]:
    """Keys of a summary that the registry does not explain."""
    known = (*quantities, *COMMON)
    return [".".join(path) for path in _leaves(numbers, ()) if not any(q.matches(path) for q in known)]


def unreported(quantities: Quantities, numbers: Numbers) -> list[str]:
    """Keys of the registry that a summary has nothing for."""
    places = list(_leaves(numbers, ()))
    return [quantity.key for quantity in quantities if not any(quantity.matches(path) for path in places)]


def _leaves(value: Any, path: tuple[str, ...]) -> Iterator[tuple[str, ...]]:
    """Places of all that is no table; items of a list of tables are named by their number."""
    if isinstance(value, Mapping):
        for key, inner in value.items():
            yield from _leaves(inner, (*path, str(key)))
    elif isinstance(value, list) and any(isinstance(item, Mapping) for item in value):
        for k, item in enumerate(value):
            yield from _leaves(item, (*path, str(k)))
    else:
        yield path
