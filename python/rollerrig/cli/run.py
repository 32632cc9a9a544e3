"""`rollerrig run CASE --out DIR`."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated

import typer

from rollerrig.cli.ending import exit_code, say
from rollerrig.cli.progress import progress_bar


def command(
    case: Annotated[str, typer.Argument(help="Case: a name of the catalogue or a TOML file.")],
    out: Annotated[Path, typer.Option(help="Folder for the results; made if it does not exist.")],
) -> None:
    """Simulate one case: run.nc (every signal), summary.json, motion.csv, wheels.csv, report.html."""
    from rollerrig.config import load_case
    from rollerrig.results import (
        SUMMARY_KEYS,
        motion_table,
        output_folder,
        save_run,
        summarise,
        wheel_table,
        write_csv,
        write_text,
    )
    from rollerrig.run import simulate

    chosen = load_case(case)
    folder = output_folder(out)
    with progress_bar(chosen.name) as progress:
        run = simulate(chosen, progress=progress)
    summary = summarise(run)
    written = [
        save_run(run, folder / "run.nc"),
        write_text(folder / "summary.json", json.dumps({**summary, "keys": SUMMARY_KEYS}, indent=2) + "\n"),
        write_csv(folder / "motion.csv", motion_table(run)),
        write_csv(folder / "wheels.csv", wheel_table(run)),
    ]
    for path in written:
        typer.echo(path)
    if run.attrs["status"] != "ok":
        say(f"rollerrig: {chosen.name}: {run.attrs['status_message']}")
    raise typer.Exit(exit_code(run.attrs["status"]))
