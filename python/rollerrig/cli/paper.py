"""`rollerrig paper --out DIR`."""

from __future__ import annotations

from typing import Annotated

import typer

from rollerrig.cli.command import Force, Out, Processes, carry_out


def command(
    out: Out,
    quick: Annotated[bool, typer.Option("--quick", help="Few and short runs: to see that everything works.")] = False,
    processes: Processes = 2,
    force: Force = False,
) -> None:
    """Reproduce the paper's two studies: figures 7 and 8, checks against theory, one report."""
    from rollerrig.study.paper import PaperStudy
    from rollerrig.study.runs.paper import FULL, QUICK

    carry_out(PaperStudy(QUICK if quick else FULL), out, processes, force=force)
