"""`rollerrig lateral CASE --out DIR`."""

from __future__ import annotations

from typing import Annotated

import typer

from rollerrig.cli.command import AllowCode, Changes, Force, Out, Processes, carry_out, read_case

HELP = "Case on elastic rollers with [rig_control] and a lateral disturbance: adhesion_lateral, or a TOML file."


def command(
    case: Annotated[str, typer.Argument(metavar="CASE", help=HELP)],
    out: Out,
    processes: Processes = 2,
    change: Changes = None,
    allow_code: AllowCode = False,
    force: Force = False,
) -> None:
    """Lateral motion during a slide: does hunting disturb the rig's control, and does the rig show what the track does?"""
    from rollerrig.study.lateral import LateralStudy

    carry_out(LateralStudy(read_case(case, allow_code=allow_code, changes=change)), out, processes, force=force)
