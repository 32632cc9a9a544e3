"""`rollerrig show CASE --out vehicle.svg`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from rollerrig.cli.command import AllowCode, CaseName, Changes, Force, picture_kind, read_case


def command(
    case: CaseName,
    out: Annotated[Path, typer.Option(help="Picture: a file that ends in .svg, .png or .pdf.")] = Path("vehicle.svg"),
    change: Changes = None,
    allow_code: AllowCode = False,
    force: Force = False,
) -> None:
    """Draw the vehicle on its rig or track to scale, from three sides: bodies, springs, dampers, locks, actuators, axes."""
    kind = picture_kind(out)
    chosen = read_case(case, allow_code=allow_code, changes=change)
    from rollerrig.plot import figure_bytes, vehicle
    from rollerrig.results import output_file, write_bytes

    output_file(out, force=force)
    typer.echo(write_bytes(out, figure_bytes(vehicle(chosen), kind), force=force))
