"""`rollerrig catalog` and `rollerrig catalog show NAME`."""

from __future__ import annotations

from difflib import get_close_matches
from typing import Annotated

import typer

from rollerrig.cli.termination import readable_errors, stop

app = typer.Typer(rich_markup_mode=None, invoke_without_command=True, add_completion=False)


@app.callback()
def catalog(context: typer.Context) -> None:
    """What ships: vehicles, supports, cases, plans."""
    if context.invoked_subcommand is not None:
        return
    from rollerrig.catalog import catalog_entries

    entries = catalog_entries()
    width = max(len(name) for _, name, _ in entries)
    heading = ""
    for kind, name, description in entries:
        if kind != heading:
            typer.echo(f"{'' if not heading else chr(10)}{kind}s")
            heading = kind
        typer.echo(f"  {name:{width}}  {description}")


@app.command("show")
@readable_errors
def show(name: Annotated[str, typer.Argument(help="Name of an entry.")]) -> None:
    """Print one entry as TOML, to copy and edit."""
    from rollerrig.catalog import catalog_entries, catalog_text

    try:
        typer.echo(catalog_text(name), nl=False)
    except KeyError:
        names = [entry for _, entry, _ in catalog_entries()]
        near = get_close_matches(name, names, n=1)
        stop(
            f"catalog: {name}: not in the catalogue"
            + (f"; did you mean '{near[0]}'?" if near else f"; it has {', '.join(names)}")
        )
