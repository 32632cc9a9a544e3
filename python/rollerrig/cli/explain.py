"""`rollerrig explain KEY`."""

from __future__ import annotations

from typing import Annotated

import typer

from rollerrig.cli.termination import stop


def command(
    key: Annotated[
        str,
        typer.Argument(metavar="KEY", help="Dotted key like motion.speed, its last part alone, or a word to look for."),
    ],
) -> None:
    """What a key of a file means: its unit, default, what is allowed, where it stands, which shipped files have it."""
    from rollerrig.config import explain

    try:
        typer.echo(explain(key))
    except KeyError as error:
        stop(error.args[0])
