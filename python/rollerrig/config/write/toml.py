"""Cases as TOML text in SI: complete, as a result file stores them, or short, for people to read and edit."""

import re
from collections.abc import Mapping
from typing import Any

from rollerrig.config.schema.base import Table
from rollerrig.config.schema.units import AS_WRITTEN

_INNERMOST_LIST = re.compile(r"\[\n((?: +[^\[\]\n]+,\n)+) *\]")


def to_toml(table: Table) -> str:
    """The table as TOML text; unset keys are left out, everything else is written, defaults too."""
    import tomli_w

    return tomli_w.dumps(plain(table))


def to_short_toml(table: Table) -> str:
    """The same without what has its default value, and with a list of numbers on one line."""
    import tomli_w

    text = tomli_w.dumps(plain(table.model_dump(exclude_none=True, exclude_defaults=True, context=AS_WRITTEN)))
    return _INNERMOST_LIST.sub(lambda found: f"[{', '.join(item.strip(' ,') for item in found[1].splitlines())}]", text)


def plain(value: Any) -> Any:
    """Models as tables, tuples as lists, unset keys left out: what TOML can hold.

    A number that a file may not give without its unit is a text with it, so that the result can be read again.
    """
    if hasattr(value, "model_dump"):
        return plain(value.model_dump(exclude_none=True, context=AS_WRITTEN))
    if isinstance(value, Mapping):
        return {key: plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    return value
