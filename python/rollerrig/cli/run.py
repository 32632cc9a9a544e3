"""`rollerrig run CASE --out DIR`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from rollerrig.cli.progress import progress_bar
from rollerrig.cli.termination import exit_code, say


def command(
    case: Annotated[str, typer.Argument(help="Case: a name of the catalogue or a TOML file.")],
    out: Annotated[Path, typer.Option(help="Folder for the results; made if it does not exist.")],
) -> None:
    """Simulate one case: run.nc (every signal), summary.json, motion.csv, wheels.csv, readings.csv, report.html."""
    from rollerrig.config import load_case
    from rollerrig.results import output_folder
    from rollerrig.simulation import simulate
    from rollerrig.studies.run import write_run

    chosen = load_case(case)
    folder = output_folder(out)
    with progress_bar(chosen.name) as progress:
        run = simulate(chosen, progress=progress)
    for path in write_run(run, folder):
        typer.echo(path)
    for warning in run.attrs["warnings"].splitlines():
        say(f"rollerrig: {chosen.name}: warning: {warning}")
    if run.attrs["status"] != "ok":
        say(f"rollerrig: {chosen.name}: {run.attrs['status_message']}")
    raise typer.Exit(exit_code(run.attrs["status"]))
