"""`rollerrig adhesion CASE --out DIR`."""

from __future__ import annotations

from typing import Annotated

import typer

from rollerrig.cli.command import AllowCode, Changes, Force, Out, Processes, RigCaseName, carry_out, read_case


def command(
    case: RigCaseName,
    out: Out,
    error_budget: Annotated[
        bool,
        typer.Option(
            help="Also run the rig without one imperfection after the other, and the track with later protection."
        ),
    ] = True,
    quick: Annotated[
        bool, typer.Option("--quick", help="Two starts of each test: to see that everything works.")
    ] = False,
    processes: Processes = 2,
    change: Changes = None,
    allow_code: AllowCode = False,
    force: Force = False,
) -> None:
    """A brake or traction test on degraded track and on the dry rig that reproduces it, side by side."""
    from rollerrig.study.adhesion import AdhesionStudy

    study = AdhesionStudy(read_case(case, allow_code=allow_code, changes=change), error_budget, quick)
    carry_out(study, out, processes, force=force)
