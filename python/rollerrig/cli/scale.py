"""`rollerrig scale CASE --strategy dlr --out DIR`."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Annotated, Any

import typer

from rollerrig.cli.progress import progress_bar
from rollerrig.cli.termination import INTERRUPTED, OK, exit_code, say, stop


def command(
    case: Annotated[str, typer.Argument(help="Full-scale case on rollers: a name of the catalogue or a TOML file.")],
    out: Annotated[Path, typer.Option(help="Folder for the results; made if it does not exist.")],
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
    causes: Annotated[bool, typer.Option(help="With --run: also each violation alone, for its share.")] = True,
    processes: Annotated[int, typer.Option(min=1, max=64, help="Runs at a time.")] = 2,
) -> None:
    """A scaled rig by similitude: case.toml, to be run like any other, and what it violates."""
    from rollerrig.config import load_case
    from rollerrig.results import output_folder, write_text
    from rollerrig.similitude import requirements, similitude
    from rollerrig.studies.scaled import compare_scaled, lead, plan_scaled, verdict, write_scaled

    full = load_case(case)
    kept = tuple(name.strip() for name in keep.split(",") if name.strip() and keep != "none")
    factors = similitude(strategy, length, time, density)
    plan = plan_scaled(
        full, factors, strategy=strategy, keep=kept, changes=_changes(change or []), causes=run and causes
    )
    folder = output_folder(out)
    typer.echo(write_text(folder / "case.toml", plan.model.to_short_toml()))
    if not run:
        say(lead(plan.model, requirements(full, plan.model)))
        return
    with progress_bar(plan.model.name) as progress:
        results = compare_scaled(plan, processes=processes, progress=progress)
    if results is None:
        stop("interrupted", INTERRUPTED)
    for path in write_scaled(results, folder):
        typer.echo(path)
    say(verdict(results))
    codes = {exit_code(one.attrs["status"]) for one in (results.run, results.mapped)}
    raise typer.Exit(INTERRUPTED if results.interrupted else max(codes, default=OK))


def _changes(texts: list[str]) -> dict[str, Any]:
    changes: dict[str, Any] = {}
    for text in texts:
        key, equals, value = text.partition("=")
        try:
            changes[key.strip()] = tomllib.loads(f"value = {value}")["value"]
        except (tomllib.TOMLDecodeError, ValueError):
            equals = ""
        if not equals or not key.strip():
            raise typer.BadParameter(
                f"'{text}': allowed: KEY=VALUE with a value of TOML, e.g. brake.motors_stand_in=true or "
                """traction.motor.bandwidth='"100 Hz"'""",
                param_hint="--set",
            )
    return changes
