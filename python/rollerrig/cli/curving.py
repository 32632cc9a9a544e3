"""`rollerrig curving CASE --radii-m 150,300,1000 --deficiencies-mm -60:150:30 --out DIR`."""

from __future__ import annotations

from typing import Annotated

import typer

from rollerrig.cli.command import AllowCode, CaseName, Changes, Force, Out, carry_out, read_case
from rollerrig.cli.ranges import read_range


def command(
    case: CaseName,
    out: Out,
    radii_m: Annotated[
        str, typer.Option(help="Radii of the curves: a list, one number or start:stop:step [m].")
    ] = "150,200,250,300,400,500,700,1000",
    deficiencies_mm: Annotated[
        str, typer.Option(help="Cant deficiencies, which decide the speed, in the same forms; negative: excess [mm].")
    ] = "-60,0,60,100,150",
    cant_mm: Annotated[
        float | None,
        typer.Option(min=0.0, max=300.0, help="Cant [mm]; absent: that of the case's first curve, or 100."),
    ] = None,
    change: Changes = None,
    allow_code: AllowCode = False,
    force: Force = False,
) -> None:
    """Steady curving: Y, Q, Y/Q, sum of Y, angle of attack and wear number over radius and cant deficiency, with their limits."""
    from rollerrig.study.curving import CurvingStudy

    radii, deficiencies = read_range(radii_m, "--radii-m"), read_range(deficiencies_mm, "--deficiencies-mm")
    chosen = read_case(case, allow_code=allow_code, changes=change)
    cant = None if cant_mm is None else 1e-3 * cant_mm
    carry_out(CurvingStudy(chosen, tuple(radii), tuple(1e-3 * d for d in deficiencies), cant), out, force=force)
