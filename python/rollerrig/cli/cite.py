"""`rollerrig cite [RUN.nc | CASE]`."""

from __future__ import annotations

from typing import Annotated

import typer

from rollerrig.cli.termination import stop


def command(
    what: Annotated[
        str | None, typer.Argument(metavar="[RUN.nc or CASE]", help="Also the sources of its models and data.")
    ] = None,
) -> None:
    """Print BibTeX: the program, the paper and, of a run or a case, the sources of the models and data in it."""
    from rollerrig.results import ResultsError, cite, load_run

    try:
        typer.echo(cite(load_run(what) if what and what.endswith(".nc") else what), nl=False)
    except (ResultsError, FileNotFoundError) as error:
        stop(error)
