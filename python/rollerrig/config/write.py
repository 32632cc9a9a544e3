"""Cases as TOML text, complete and in SI: what a result file stores."""

from rollerrig.config.base import Table
from rollerrig.config.change import plain


def to_toml(table: Table) -> str:
    """The table as TOML text; unset keys are left out, everything else is written, defaults too."""
    import tomli_w

    return tomli_w.dumps(plain(table))
