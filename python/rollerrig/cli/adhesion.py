"""`rollerrig adhesion CASE --out DIR`."""

from __future__ import annotations

from typing import Annotated

import typer

from rollerrig.cli.command import Out, Processes, RigCaseName, carry_out


def command(
    case: RigCaseName,
    out: Out,
    error_budget: Annotated[
        bool, typer.Option(help="Also run the rig without one imperfection after the other, and repeated tests.")
    ] = True,
    processes: Processes = 2,
) -> None:
    """A brake or traction test on degraded track and on the dry rig that reproduces it, side by side."""
    from rollerrig.config import load_case
    from rollerrig.study.adhesion import AdhesionStudy

    carry_out(AdhesionStudy(load_case(case), error_budget), out, processes)
