"""`rollerrig view RUN.nc [OTHER.nc] --out view.html`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from rollerrig.cli.command import Force
from rollerrig.cli.termination import stop


def command(
    run: Annotated[Path, typer.Argument(help="A run, e.g. run.nc of `rollerrig run`.")],
    other: Annotated[Path | None, typer.Argument(help="Another run, shown beside it in step.")] = None,
    out: Annotated[Path, typer.Option(help="The page: one file, for any browser, without a network.")] = Path(
        "view.html"
    ),
    force: Force = False,
) -> None:
    """Show a run in motion: one HTML file with the vehicle, its contacts and forces, and curves in step."""
    from rollerrig.results import ResultsError
    from rollerrig.viewer import view

    try:
        typer.echo(view(run, other, path=out, force=force))
    except (ResultsError, FileNotFoundError) as error:
        stop(error)
