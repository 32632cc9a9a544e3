"""`rollerrig paper --out DIR`."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Annotated

import typer

from rollerrig.cli.progress import progress_bar
from rollerrig.cli.termination import INTERRUPTED, say


def command(
    out: Annotated[Path, typer.Option(help="Folder for the report; made if it does not exist.")],
    quick: Annotated[bool, typer.Option("--quick", help="Few and short runs: to see that everything works.")] = False,
    processes: Annotated[int, typer.Option(min=1, max=64, help="Runs at a time.")] = 2,
) -> None:
    """Repeat the paper's two studies: figures 7 and 8, checks against theory, one report."""
    from rollerrig.results import output_folder
    from rollerrig.studies.paper import FULL, QUICK, compute, write_paper
    from rollerrig.studies.paper.text import lead

    folder = output_folder(out)
    with progress_bar("paper", _lines()) as progress:
        results = compute(QUICK if quick else FULL, processes=processes, progress=progress)
    written = write_paper(results, folder)
    say(lead(results))
    typer.echo(written[-1])
    if results.interrupted:
        raise typer.Exit(INTERRUPTED)


def _lines() -> Callable[[float, str], None]:
    """Progress as a line on stderr per ten per cent, where there is no terminal for a bar."""
    shown = -1

    def report(fraction: float, text: str) -> None:
        nonlocal shown
        tenth = int(10 * fraction)
        if tenth > shown:
            shown = tenth
            say(f"{10 * tenth:3d} %  {text}")

    return report
