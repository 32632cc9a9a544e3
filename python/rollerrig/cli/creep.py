"""`rollerrig creep --a-over-b 1 --law fastsim --law table --out DIR`."""

from __future__ import annotations

from typing import Annotated

import typer

from rollerrig.cli.command import Force, Out, carry_out
from rollerrig.cli.ranges import check_finite, read_range
from rollerrig.cli.termination import stop


def command(
    out: Out,
    a_over_b: Annotated[
        float, typer.Option(help="Semi-axis along the rolling direction over the one across it.")
    ] = 1.0,
    law: Annotated[
        list[str] | None,
        typer.Option(help="A law that contact.creep knows; again for more. All without parameters if absent."),
    ] = None,
    poisson_ratio: Annotated[float, typer.Option(help="Poisson's ratio.")] = 0.28,
    demands: Annotated[
        str, typer.Option(help="Sizes of the creepage, 1 asks for the friction limit: a list or start:stop:step.")
    ] = "0.05,0.1,0.25,0.5,0.75,1,1.5,2,3,5,10",
    k_A: Annotated[float | None, typer.Option("--k-a", help="polach: k_A; dry 1.0, wet 0.3.")] = None,
    k_S: Annotated[float | None, typer.Option("--k-s", help="polach: k_S; dry 0.4, wet 0.1.")] = None,
    force: Force = False,
) -> None:
    """Forces and spin moment of creep laws beside the exact theory, with their errors and cost."""
    from rollerrig.study.creep import CreepStudy

    for value, option in ((a_over_b, "--a-over-b"), (poisson_ratio, "--poisson-ratio")):
        check_finite(value, option)
    if (k_A is None) != (k_S is None):
        stop("--k-a and --k-s belong together")
    laws = law or ["kalker_saturated", "fastsim", "modified_fastsim", "table"]
    polach = {"k_A": k_A, "k_S": k_S} if k_A is not None and k_S is not None else {}
    if polach and "polach" not in laws:
        stop("--k-a and --k-s are for --law polach")
    sizes = tuple(read_range(demands, "--demands"))
    try:
        study = CreepStudy(a_over_b, tuple(laws), poisson_ratio, sizes, {"polach": polach})
    except ValueError as error:
        stop(error)
    carry_out(study, out, refused=(ValueError, RuntimeError), force=force)
