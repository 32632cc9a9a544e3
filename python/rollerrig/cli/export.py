"""`rollerrig export RUN.nc --to mat|csv|parquet`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from rollerrig.cli.command import Force
from rollerrig.cli.termination import stop


def command(
    run: Annotated[Path, typer.Argument(help="A file of results, e.g. run.nc.")],
    to: Annotated[str, typer.Option(help="mat, csv or parquet.")] = "mat",
    out: Annotated[Path | None, typer.Option(help="The file; beside the run, with its name, if absent.")] = None,
    over: Annotated[str, typer.Option(help="Of a table: time, or reading_time of the finer readings.")] = "time",
    force: Force = False,
) -> None:
    """Write a run for other programs: MATLAB, a CSV table, Parquet."""
    from rollerrig.results import ResultsError, export

    try:
        typer.echo(export(run, out or run.with_suffix(f".{to}"), to=to, over=over, force=force))
    except (ResultsError, FileNotFoundError) as error:
        stop(error)
