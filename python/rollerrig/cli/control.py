"""`rollerrig control CASE --out DIR`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from rollerrig.cli.progress import progress_bar
from rollerrig.cli.termination import INTERRUPTED, OK, say, stop


def command(
    case: Annotated[
        str, typer.Argument(help="Case on rollers with [rig_control]: a name of the catalogue or a TOML file.")
    ],
    out: Annotated[Path, typer.Option(help="Folder for the results; made if it does not exist.")],
    duration: Annotated[
        float,
        typer.Option(min=1.0, max=600.0, help="Length of each run [s]: until adhesion has broken away and recovered."),
    ] = 10.0,
    families: Annotated[
        str | None, typer.Option(help="What is varied, by name with commas between; absent: everything.")
    ] = None,
    controller: Annotated[
        str | None, typer.Option(help="Your own controller beside ours: 'file.py:Class' or 'module:Class'.")
    ] = None,
    loop: Annotated[bool, typer.Option(help="Also find where the loop begins to ring, computed and measured.")] = True,
    processes: Annotated[int, typer.Option(min=1, max=64, help="Runs at a time.")] = 2,
) -> None:
    """Controllers of the roller drives: estimators, feedbacks, sample times, drives, wrong numbers; what breaks first."""
    from rollerrig.bench import users_controllers
    from rollerrig.config import load_case
    from rollerrig.results import output_folder
    from rollerrig.studies.control import chosen_families, compare_controllers, lead, study_case, write_control

    chosen = study_case(load_case(case), duration)
    wanted = chosen_families([name.strip() for name in families.split(",")] if families else None, chosen.name)
    if controller is not None:  # refused before a folder is made
        users_controllers(chosen.with_changes({"rig_control.user": controller}), {})
    folder = output_folder(out)
    with progress_bar(chosen.name) as progress:
        study = compare_controllers(
            chosen, families=wanted, user=controller, limits=loop, processes=processes, progress=progress
        )
    if study is None:
        stop("interrupted", INTERRUPTED)
    written = write_control(study, folder)
    say(lead(study))
    typer.echo(written[-1])
    raise typer.Exit(INTERRUPTED if study.interrupted else OK)
