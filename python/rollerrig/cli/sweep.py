"""`rollerrig sweep PLAN.toml --out DIR`."""

from typing import Annotated

import typer

from rollerrig.cli.command import AllowCode, Changes, Force, Out, carry_out, changes_of, code_lines
from rollerrig.cli.termination import say, stop


def command(
    plan: Annotated[str, typer.Argument(metavar="PLAN", help="Plan: a name of the catalogue or a TOML file.")],
    out: Out,
    workers: Annotated[int, typer.Option(min=1, max=256, help="Processes of this machine.")] = 2,
    dask: Annotated[
        str | None,
        typer.Option(
            metavar="ADDRESS", help="Scheduler of a dask cluster that does the work instead, e.g. tcp://127.0.0.1:8786."
        ),
    ] = None,
    samples: Annotated[
        int | None,
        typer.Option(min=2, help="Another number of samples than the plan's; of a grid the values of each range."),
    ] = None,
    yes: Annotated[bool, typer.Option("--yes", help="More than 100 000 cases are meant.")] = False,
    change: Changes = None,
    allow_code: AllowCode = False,
    force: Force = False,
) -> None:
    """Many cases that differ in a few keys: maps, scatter and tornado pictures, quantiles, Sobol indices.

    Every finished case is kept at once: after Ctrl-C, or a machine that went down, the same command continues with the rest.
    """
    from rollerrig.config import load_plan
    from rollerrig.study.cluster import ClusterError, cluster
    from rollerrig.study.runs.sweep import resized
    from rollerrig.study.sweep import SweepStudy

    whole = load_plan(plan, allow_code=allow_code, changes=changes_of(change))
    for line in code_lines(whole.code):
        say(f"rollerrig: {plan}: {line}")
    study = SweepStudy(whole if samples is None else resized(whole, samples), many=yes)
    if dask is None:
        carry_out(study, out, workers, force=force)
    try:
        with cluster(dask) as executor:
            carry_out(study, out, force=force, executor=executor)
    except ClusterError as error:
        stop(f"--dask: {error}")
