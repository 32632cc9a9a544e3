"""`rollerrig adhesion CASE --out DIR`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from rollerrig.cli.progress import progress_bar
from rollerrig.cli.termination import INTERRUPTED, OK, exit_code, say, stop


def command(
    case: Annotated[
        str, typer.Argument(help="Case on rollers with [rig_control]: a name of the catalogue or a TOML file.")
    ],
    out: Annotated[Path, typer.Option(help="Folder for the results; made if it does not exist.")],
    causes: Annotated[
        bool,
        typer.Option(
            help="Also run the rig with nearly ideal drives and estimator: what the tracking error comes from."
        ),
    ] = True,
    processes: Annotated[int, typer.Option(min=1, max=64, help="Runs at a time.")] = 2,
) -> None:
    """A brake or traction test on degraded track and on the dry rig that reproduces it, side by side."""
    from rollerrig.config import load_case
    from rollerrig.results import output_folder
    from rollerrig.studies.adhesion import compare_adhesion, lead, track_case, write_adhesion

    chosen = load_case(case)
    track_case(chosen)  # refused before a folder is made
    folder = output_folder(out)
    with progress_bar(chosen.name) as progress:
        results = compare_adhesion(chosen, causes=causes, processes=processes, progress=progress)
    if results is None:
        stop("interrupted", INTERRUPTED)
    written = write_adhesion(results, folder)
    say(lead(results))
    typer.echo(written[-1])
    codes = {exit_code(run.attrs["status"]) for run in (results.track, results.rig)}
    raise typer.Exit(INTERRUPTED if results.interrupted else max(codes, default=OK))
