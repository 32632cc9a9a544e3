"""`rollerrig new NAME [--from CASE]`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from rollerrig.cli.command import Force
from rollerrig.cli.termination import say


def command(
    name: Annotated[str, typer.Argument(metavar="NAME", help="Name of the new case; the file is NAME.toml.")],
    source: Annotated[
        str, typer.Option("--from", metavar="CASE", help="Case to start from: a name of the catalogue or a TOML file.")
    ] = "bogie_rollers_constant",
    out: Annotated[Path, typer.Option(help="Folder for the file; made if it does not exist.")] = Path(),
    force: Force = False,
) -> None:
    """Write a case to begin with, which runs as it stands: its keys explained, the defaults beside them as comments."""
    from rollerrig.catalog.starting_case import starting_case
    from rollerrig.results import OutputError, output_folder, write_text

    target = Path(f"{name.removesuffix('.toml')}.toml")
    if out.suffix == ".toml":
        raise OutputError(out, f"--out is the folder; the file in it is {target}")
    text = starting_case(target.stem, source)
    if (out / target).exists() and not force:
        raise OutputError(out / target, "there is a case of that name; choose another name, or replace it with --force")
    target = output_folder(out) / target
    typer.echo(write_text(target, text, force=force))
    say(f"It runs as it stands: rollerrig run {target} --out {target.stem}-run")
