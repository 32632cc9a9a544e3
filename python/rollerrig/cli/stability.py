"""`rollerrig stability CASE --speeds-kmh 60:300:20 --out DIR`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from rollerrig.cli.ending import INTERRUPTED, say
from rollerrig.cli.progress import progress_bar
from rollerrig.cli.ranges import read_range


def command(
    case: Annotated[str, typer.Argument(help="Case: a name of the catalogue or a TOML file.")],
    out: Annotated[Path, typer.Option(help="Folder for the results; made if it does not exist.")],
    speeds_kmh: Annotated[
        str, typer.Option(help="Speeds [km/h] as start:stop:step, or a list with commas.")
    ] = "60:300:20",
    nonlinear: Annotated[
        bool, typer.Option("--nonlinear", help="Also run from a disturbance, for limit cycles.")
    ] = False,
    disturbance_mm: Annotated[
        float, typer.Option(min=0.01, max=20.0, help="Its size: lateral offset of the leading wheelset [mm].")
    ] = 3.0,
    duration: Annotated[float, typer.Option(min=1.0, max=600.0, help="Length of each of these runs [s].")] = 6.0,
    processes: Annotated[int, typer.Option(min=1, max=64, help="Runs at a time.")] = 2,
) -> None:
    """Eigenvalues, damping, frequency and mode shapes over speed, and the linear critical speed."""
    from rollerrig.analysis import HuntingSettings
    from rollerrig.config import load_case
    from rollerrig.results import output_folder
    from rollerrig.studies.stability import lead, stability_study, write_study

    option = "--speeds-kmh"
    speeds = read_range(speeds_kmh, option)
    if speeds[0] <= 0 or any(b <= a for a, b in zip(speeds, speeds[1:], strict=False)):
        raise typer.BadParameter(f"'{speeds_kmh}': speeds must be positive and rise", param_hint=option)
    chosen = load_case(case)
    folder = output_folder(out)
    settings = HuntingSettings(disturbance=1e-3 * disturbance_mm, duration=duration)
    with progress_bar(chosen.name) as progress:
        study = stability_study(
            chosen, speeds, nonlinear=nonlinear, settings=settings, processes=processes, progress=progress
        )
    for path in write_study(study, folder):
        typer.echo(path)
    say(lead(study))
    if study.interrupted:
        raise typer.Exit(INTERRUPTED)
