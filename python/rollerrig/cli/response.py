"""`rollerrig response CASE --input wheelset_1.axle_torque --output wheelset_1.y --out DIR`."""

from __future__ import annotations

from typing import Annotated

import typer

from rollerrig.cli.command import AllowCode, CaseName, Changes, Force, Out, Processes, carry_out, read_case
from rollerrig.cli.ranges import read_speeds


def command(
    case: CaseName,
    out: Out,
    input: Annotated[list[str] | None, typer.Option(help="A command of the bench; again for more.")] = None,  # noqa: A002
    output: Annotated[list[str] | None, typer.Option(help="An output; again for more.")] = None,
    speeds_kmh: Annotated[
        str | None, typer.Option(help="Speeds [km/h] as start:stop:step, or a list; that of the case if absent.")
    ] = None,
    from_hz: Annotated[float, typer.Option(min=1e-4, max=1e4, help="Lowest frequency [Hz].")] = 0.1,
    to_hz: Annotated[float, typer.Option(min=1e-3, max=1e5, help="Highest frequency [Hz].")] = 100.0,
    points: Annotated[int, typer.Option(min=10, max=20000, help="Frequencies of the linear bench.")] = 400,
    measured: Annotated[
        int,
        typer.Option(min=0, max=200, help="Frequencies at which the nonlinear bench is driven with a sine; 0: none."),
    ] = 12,
    amplitude: Annotated[float, typer.Option(min=1e-9, max=1e9, help="Of that sine, in the command's unit.")] = 1000.0,
    brake_pressure: Annotated[
        float,
        typer.Option(min=0.0, max=100.0, help="In all brake cylinders [bar]; the rollers' drives hold the speed."),
    ] = 0.0,
    processes: Processes = 1,
    change: Changes = None,
    allow_code: AllowCode = False,
    force: Force = False,
) -> None:
    """Frequency response from commands to outputs: Bode, Nyquist, poles and zeros, margins, and measured beside it."""
    from rollerrig.study.response import ResponseStudy

    whole = read_case(case, allow_code=allow_code, changes=change)
    speeds = (3.6 * whole.motion.speed,) if speeds_kmh is None else read_speeds(speeds_kmh)
    study = ResponseStudy(
        whole,
        tuple(input or ()),
        tuple(output or ()),
        speeds,
        (from_hz, to_hz),
        points,
        measured,
        amplitude,
        1e5 * brake_pressure,
    )
    carry_out(study, out, processes, force=force)
