"""`rollerrig control CASE --out DIR`."""

from __future__ import annotations

from typing import Annotated

import typer

from rollerrig.cli.command import AllowCode, Changes, Force, Out, Processes, RigCaseName, carry_out, read_case


def command(
    case: RigCaseName,
    out: Out,
    duration: Annotated[
        float,
        typer.Option(min=1.0, max=600.0, help="Length of each run [s]: until adhesion has broken away and recovered."),
    ] = 10.0,
    families: Annotated[
        str | None, typer.Option(help="What is varied, by name with commas between; absent: everything.")
    ] = None,
    controller: Annotated[
        str | None, typer.Option(help="Your own controller to compare: 'file.py:Class' or 'module:Class'.")
    ] = None,
    loop: Annotated[
        bool, typer.Option(help="Also find the gains at which the loop becomes unstable, computed and measured.")
    ] = True,
    lags: Annotated[
        bool, typer.Option(help="Also compare ways to compensate the lags, in tests of the case's own length.")
    ] = True,
    processes: Processes = 2,
    change: Changes = None,
    allow_code: AllowCode = False,
    force: Force = False,
) -> None:
    """Controllers of the roller drives: estimators, feedbacks, sample times, drives, wrong parameters; which fails first."""
    from rollerrig.study.control import ControlStudy, study_case

    names = tuple(name.strip() for name in families.split(",")) if families else ()
    whole = read_case(case, allow_code=allow_code, changes=change)
    length = whole.time.duration if lags else 0.0
    carry_out(
        ControlStudy(study_case(whole, duration), names, controller, loop, length),
        out,
        processes,
        force=force,
    )
