"""What the commands share: their usual options, and how a study is run."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, NoReturn

import typer

from rollerrig.cli.progress import lines, progress_bar
from rollerrig.cli.termination import INTERRUPTED, OK, exit_code, say, stop

CaseName = Annotated[str, typer.Argument(metavar="CASE", help="Case: a name of the catalogue or a TOML file.")]
RigCaseName = Annotated[
    str,
    typer.Argument(metavar="CASE", help="Case on rollers with [rig_control]: a name of the catalogue or a TOML file."),
]
Out = Annotated[Path, typer.Option(help="Folder for the results; made if it does not exist.")]
SpeedsKmh = Annotated[str, typer.Option(help="Speeds [km/h] as start:stop:step, or a list with commas.")]
Processes = Annotated[int, typer.Option(min=1, max=64, help="Runs at a time.")]


def carry_out(study: Any, out: Path, processes: int = 1, *, refused: tuple[type[Exception], ...] = ()) -> NoReturn:
    """Run a study, write what it found and print its summary; the exit code says how its runs ended.

    Args:
        study: a `rollerrig.study.frame.Study`.
        out: folder for the results.
        processes: jobs at a time.
        refused: errors of the study that are the user's.
    """
    from rollerrig.results import output_folder

    folder = output_folder(out)
    try:
        with progress_bar(study.command, lines() if study.resumable else None) as progress:
            outcome = study.run(folder=folder, processes=processes, progress=progress)
    except refused as error:
        stop(error)
    if outcome is None:
        stop("interrupted; finished jobs are kept: the same command continues", INTERRUPTED)
    for path in outcome.write(folder):
        if path.parent == folder:
            typer.echo(path)
    say(outcome.summary)
    if outcome.interrupted and study.resumable:
        say("Finished jobs are kept: the same command continues.")
    raise typer.Exit(max((exit_code(status) for status in outcome.statuses), default=OK))
