"""`rollerrig lateral CASE --out DIR`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from rollerrig.cli.progress import progress_bar
from rollerrig.cli.termination import INTERRUPTED, exit_code, say, stop


def command(
    case: Annotated[
        str,
        typer.Argument(
            help="Case on elastic rollers with [rig_control] and a lateral disturbance: adhesion_lateral, or a TOML file."
        ),
    ],
    out: Annotated[Path, typer.Option(help="Folder for the results; made if it does not exist.")],
    processes: Annotated[int, typer.Option(min=1, max=64, help="Runs at a time.")] = 2,
) -> None:
    """Lateral motion during a slide: does hunting disturb the rig's control, and does the rig show what the track does?"""
    from rollerrig.config import load_case
    from rollerrig.results import output_folder
    from rollerrig.studies.control.lateral import compare_lateral, lateral_cases
    from rollerrig.studies.control.lateral_page import lead, write_lateral

    chosen = load_case(case)
    lateral_cases(chosen)  # refused before a folder is made
    folder = output_folder(out)
    with progress_bar(chosen.name) as progress:
        study = compare_lateral(chosen, processes=processes, progress=progress)
    if study is None:
        stop("interrupted", INTERRUPTED)
    written = write_lateral(study, folder)
    say(lead(study))
    typer.echo(written[-1])
    codes = {exit_code(run.attrs["status"]) for run in study.runs.values()}
    raise typer.Exit(INTERRUPTED if study.interrupted else max(codes))
