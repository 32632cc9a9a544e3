"""`rollerrig envelope CASE --out DIR`."""

from __future__ import annotations

from typing import Annotated

import typer

from rollerrig.cli.command import AllowCode, Changes, Force, Out, Processes, RigCaseName, carry_out, read_case
from rollerrig.cli.ranges import check_finite, read_range


def command(
    case: RigCaseName,
    out: Out,
    torques_knm: Annotated[
        str | None,
        typer.Option(
            help="Torques on each axle [kN m], negative brakes: start:stop:step, or a list with commas. By default up to "
            "beyond what dry rollers carry, braking for a case with [brake]."
        ),
    ] = None,
    adhesions: Annotated[
        str | None, typer.Option(help="Adhesions of the reproduced rail, in the same forms; 0.02 to 0.36 if absent.")
    ] = None,
    loads: Annotated[
        str | None, typer.Option(help="Axle loads over the case's own, in the same forms; 0.6,1,1.4 if absent.")
    ] = None,
    speed_kmh: Annotated[float | None, typer.Option(help="Speed at the start [km/h]; the case's if absent.")] = None,
    duration: Annotated[float, typer.Option(help="Length of each run [s].")] = 3.0,
    refine: Annotated[
        int, typer.Option(min=0, max=4, help="How many times cells between different regions are halved.")
    ] = 1,
    processes: Processes = 2,
    change: Changes = None,
    allow_code: AllowCode = False,
    force: Force = False,
) -> None:
    """Operating envelope: where the rig reproduces a degraded rail over torque, adhesion and axle load, and what limits it.

    Ctrl-C keeps all finished runs; the same command continues with the rest, and another grid takes over those it shares.
    """
    from rollerrig.study.envelope import EnvelopeStudy

    check_finite(speed_kmh, "--speed-kmh")
    check_finite(duration, "--duration")
    chosen = read_case(case, allow_code=allow_code, changes=change)
    if speed_kmh is not None:
        chosen = chosen.with_changes({"motion.speed": f"{speed_kmh} km/h"})
    texts = {"torques": (torques_knm, 1e3), "adhesions": (adhesions, 1.0), "loads": (loads, 1.0)}
    ranges = {
        name: tuple(
            factor * value for value in sorted(read_range(text, f"--{name}{'-knm' if name == 'torques' else ''}"))
        )
        for name, (text, factor) in texts.items()
        if text is not None
    }
    carry_out(EnvelopeStudy(chosen, duration=duration, refine=refine, **ranges), out, processes, force=force)
