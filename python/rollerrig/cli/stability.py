"""`rollerrig stability CASE --speeds-kmh 60:300:20 --out DIR`."""

from __future__ import annotations

from typing import Annotated

import typer

from rollerrig.cli.command import AllowCode, CaseName, Changes, Force, Out, SpeedsKmh, carry_out, read_case
from rollerrig.cli.ranges import read_speeds


def command(
    case: CaseName,
    out: Out,
    speeds_kmh: SpeedsKmh = "60:300:20",
    limit_cycles: Annotated[
        bool, typer.Option(help="Also run at up to 20 of the speeds, stepped up and down, for limit cycles.")
    ] = True,
    disturbance_mm: Annotated[
        float,
        typer.Option(
            min=0.01, max=20.0, help="Lateral offset of the leading wheelset that starts the downward sweep [mm]."
        ),
    ] = 3.0,
    perturbation_mm: Annotated[
        float, typer.Option(min=0.001, max=20.0, help="The same for the upward sweep [mm].")
    ] = 0.1,
    longest: Annotated[
        float, typer.Option(min=2.0, max=600.0, help="A run that has not settled by then ends [s].")
    ] = 16.0,
    tolerance_kmh: Annotated[
        float, typer.Option(min=0.01, max=100.0, help="To which the critical speed by continuation is found [km/h].")
    ] = 1.0,
    processes: Annotated[int, typer.Option(min=1, max=2, help="With 2, the two sweeps run at a time.")] = 2,
    contacts_kmh: Annotated[
        float | None,
        typer.Option(
            min=1.0,
            max=600.0,
            help="Also compare the contact models, on rig and track, with a run at this speed [km/h].",
        ),
    ] = None,
    change: Changes = None,
    allow_code: AllowCode = False,
    force: Force = False,
) -> None:
    """Eigenvalues, damping, frequency and mode shapes over speed; limit cycles; critical speeds."""
    from rollerrig.analysis import LimitCycleSettings
    from rollerrig.study.stability import StabilityStudy

    settings = LimitCycleSettings(
        disturbance=1e-3 * disturbance_mm,
        perturbation=1e-3 * perturbation_mm,
        longest=longest,
        tolerance_kmh=tolerance_kmh,
    )
    speeds = read_speeds(speeds_kmh)
    study = StabilityStudy(
        read_case(case, allow_code=allow_code, changes=change), speeds, limit_cycles, settings, contacts_kmh
    )
    carry_out(study, out, processes, force=force)
