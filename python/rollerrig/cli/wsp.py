"""`rollerrig wsp CASE --out DIR`."""

from __future__ import annotations

from typing import Annotated

import typer

from rollerrig.cli.command import AllowCode, Changes, Force, Out, Processes, RigCaseName, carry_out, read_case


def command(
    case: RigCaseName,
    out: Out,
    programme: Annotated[
        str, typer.Option(help="Stops and limits: a name of the catalogue or a TOML file.")
    ] = "slide_protection_stops",
    starts: Annotated[
        int,
        typer.Option(
            min=0, max=100, help="Tests of each stop on each support; 0: as many as the programme needs for a verdict."
        ),
    ] = 0,
    quick: Annotated[
        bool, typer.Option("--quick", help="Two starts of the first two stops: to see that everything works.")
    ] = False,
    processes: Processes = 2,
    change: Changes = None,
    allow_code: AllowCode = False,
    force: Force = False,
) -> None:
    """A test programme for wheel slide protection: a series of stops on track and on the rig, judged by limits."""
    from rollerrig.config import load_programme
    from rollerrig.study.wsp import WspStudy

    study = WspStudy(read_case(case, allow_code=allow_code, changes=change), load_programme(programme), starts, quick)
    carry_out(study, out, processes, force=force)
