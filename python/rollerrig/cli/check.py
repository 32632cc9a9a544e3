"""`rollerrig check FILE.toml`."""

from __future__ import annotations

from typing import Annotated

import typer


def command(file: Annotated[str, typer.Argument(help="A TOML file, or a name of the catalogue.")]) -> None:
    """Validate a file; of a case, print the assembled model, its static wheel loads and masses."""
    from rollerrig.cli.describe import describe_case, describe_part
    from rollerrig.config import Case, load_any

    kind, part = load_any(file)
    lines = describe_case(part) if isinstance(part, Case) else describe_part(part)
    typer.echo(f"{file}: a valid {kind}\n")
    typer.echo("\n".join(lines))
