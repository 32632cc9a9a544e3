"""Cases as TOML text in SI: complete, as a result file stores them, or short, for people to read and edit."""

import re

from rollerrig.config.base import Table
from rollerrig.config.change import plain

_INNERMOST_LIST = re.compile(r"\[\n((?: +[^\[\]\n]+,\n)+) *\]")


def to_toml(table: Table) -> str:
    """The table as TOML text; unset keys are left out, everything else is written, defaults too."""
    import tomli_w

    return tomli_w.dumps(plain(table))


def to_short_toml(table: Table) -> str:
    """The same without what has its default value, and with a list of numbers on one line."""
    import tomli_w

    text = tomli_w.dumps(plain(table.model_dump(exclude_none=True, exclude_defaults=True)))
    return _INNERMOST_LIST.sub(lambda found: f"[{', '.join(item.strip(' ,') for item in found[1].splitlines())}]", text)
