"""`rollerrig stability CASE --speeds-kmh 60:300:20 --out DIR`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from rollerrig.cli.progress import progress_bar
from rollerrig.cli.ranges import read_range
from rollerrig.cli.termination import INTERRUPTED, say


def command(
    case: Annotated[str, typer.Argument(help="Case: a name of the catalogue or a TOML file.")],
    out: Annotated[Path, typer.Option(help="Folder for the results; made if it does not exist.")],
    speeds_kmh: Annotated[
        str, typer.Option(help="Speeds [km/h] as start:stop:step, or a list with commas.")
    ] = "60:300:20",
    limit_cycles: Annotated[
        bool, typer.Option(help="Also run at up to 20 of the speeds, stepped up and down, for limit cycles.")
    ] = True,
    disturbance_mm: Annotated[
        float,
        typer.Option(min=0.01, max=20.0, help="Lateral offset of the leading wheelset that starts the way down [mm]."),
    ] = 3.0,
    perturbation_mm: Annotated[float, typer.Option(min=0.001, max=20.0, help="The same for the way up [mm].")] = 0.1,
    longest: Annotated[
        float, typer.Option(min=2.0, max=600.0, help="A run that has not settled by then ends [s].")
    ] = 16.0,
    tolerance_kmh: Annotated[
        float, typer.Option(min=0.01, max=100.0, help="To which the critical speed by continuation is found [km/h].")
    ] = 1.0,
    processes: Annotated[int, typer.Option(min=1, max=2, help="With 2, the two ways run at a time.")] = 2,
    contacts_kmh: Annotated[
        float | None,
        typer.Option(
            min=1.0,
            max=600.0,
            help="Also compare the contact models, on rig and track, with a run at this speed [km/h].",
        ),
    ] = None,
) -> None:
    """Eigenvalues, damping, frequency and mode shapes over speed; limit cycles; critical speeds."""
    from rollerrig.analysis import LimitCycleSettings
    from rollerrig.config import load_case
    from rollerrig.results import output_folder
    from rollerrig.studies.stability import stability_study, with_contact_effects, write_study
    from rollerrig.studies.stability_page import lead

    option = "--speeds-kmh"
    speeds = read_range(speeds_kmh, option)
    if speeds[0] <= 0 or any(b <= a for a, b in zip(speeds, speeds[1:], strict=False)):
        raise typer.BadParameter(f"'{speeds_kmh}': speeds must be positive and rise", param_hint=option)
    chosen = load_case(case)
    folder = output_folder(out)
    settings = LimitCycleSettings(
        disturbance=1e-3 * disturbance_mm,
        perturbation=1e-3 * perturbation_mm,
        longest=longest,
        tolerance_kmh=tolerance_kmh,
    )
    with progress_bar(chosen.name) as progress:
        study = stability_study(
            chosen,
            speeds,
            with_limit_cycles=limit_cycles,
            settings=settings,
            processes=processes,
            progress=progress,
        )
    if contacts_kmh is not None and not study.interrupted:
        with progress_bar("contact models") as progress:
            study = with_contact_effects(study, speeds, contacts_kmh, progress=progress)
    for path in write_study(study, folder):
        typer.echo(path)
    say(lead(study.modes, study.cycles))
    if study.interrupted:
        raise typer.Exit(INTERRUPTED)
