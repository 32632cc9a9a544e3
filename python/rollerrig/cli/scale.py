"""`rollerrig scale CASE --strategy dlr --out DIR`."""

from __future__ import annotations

from typing import Annotated

import typer

from rollerrig.cli.command import AllowCode, Force, Out, Processes, carry_out, changes_of, read_case
from rollerrig.cli.termination import say


def command(
    case: Annotated[str, typer.Argument(help="Full-scale case on rollers: a name of the catalogue or a TOML file.")],
    out: Out,
    strategy: Annotated[str, typer.Option(help="mmu keeps time, dlr gravity, inrets speed and elastic contact.")],
    length: Annotated[
        float | None, typer.Option(help="Length at full scale over that of the model; 5, 5, 4 by default.")
    ] = None,
    time: Annotated[float | None, typer.Option(help="Time at full scale over that of the model.")] = None,
    density: Annotated[float | None, typer.Option(help="Density at full scale over that of the model.")] = None,
    keep: Annotated[
        str,
        typer.Option(
            help="What the model does not scale: gravity, material, clock, drives, with commas; 'none': ideal similitude."
        ),
    ] = "gravity,material",
    change: Annotated[
        list[str] | None,
        typer.Option("--set", help="What the model has of its own, at its own scale: KEY=VALUE, as in a TOML file."),
    ] = None,
    run: Annotated[
        bool, typer.Option("--run", help="Also run the test at full scale and on the model, mapped back: report.html.")
    ] = False,
    error_budget: Annotated[bool, typer.Option(help="With --run: also each violation alone.")] = True,
    processes: Processes = 2,
    allow_code: AllowCode = False,
    force: Force = False,
) -> None:
    """A scaled rig by similitude: case.toml, to be run like any other, and what it violates."""
    from rollerrig.config.write.toml import to_short_toml
    from rollerrig.results import ResultFolder, check_folder
    from rollerrig.similitude import requirements, similitude
    from rollerrig.study.scale import CASE_FILE, model_summary, scale_study

    kept = tuple(name.strip() for name in keep.split(",") if name.strip() and keep != "none")
    factors, changes = similitude(strategy, length, time, density), changes_of(change)
    study = scale_study(
        read_case(case, allow_code=allow_code),
        factors,
        strategy=strategy,
        keep=kept,
        changes=changes,
        error_budget=run and error_budget,
    )
    if run:
        carry_out(study, out, processes, force=force)
    check_folder(out, study.command, (CASE_FILE,), force=force)
    with ResultFolder(out, study.command, {study.model.name: study.model}, force=force) as folder:
        typer.echo(folder.add(CASE_FILE, to_short_toml(study.model).encode()))
        folder.commit()
    say("\n".join(model_summary(study.model, requirements(study.full, study.model))))
