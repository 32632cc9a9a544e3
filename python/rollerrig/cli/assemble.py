"""`rollerrig assemble CASE --out rig.model`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from rollerrig.cli.command import AllowCode, CaseName, Changes, Force, read_case
from rollerrig.cli.termination import say


def command(
    case: CaseName,
    out: Annotated[Path, typer.Option(help="The model file.")],
    external: Annotated[
        str,
        typer.Option(
            metavar="TABLES", help="Controllers whose commands come from outside, with commas: slide_protection, ..."
        ),
    ] = "",
    force: Force = False,
    change: Changes = None,
    allow_code: AllowCode = False,
) -> None:
    """Write everything that a run of a case needs into one file, for other tools and without Python."""
    from rollerrig.interfaces.plant import assemble_file, contents, read_model

    roles = [name.strip() for name in external.split(",") if name.strip()]
    path = assemble_file(read_case(case, allow_code=allow_code, changes=change), out, external=roles, force=force)
    typer.echo(path)
    say(contents(read_model(path)))
