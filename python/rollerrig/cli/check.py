"""`rollerrig check FILE.toml`."""

from __future__ import annotations

from typing import Annotated

import typer

from rollerrig.cli.command import code_lines


def command(
    file: Annotated[str, typer.Argument(help="A TOML file, or a name of the catalogue.")],
    allow_code: Annotated[
        bool,
        typer.Option(
            "--allow-code", help="Also run the controllers that a case brings, wherever they lie, to check them."
        ),
    ] = False,
) -> None:
    """Validate a file; of a case, print the assembled model, its static wheel loads and masses."""
    from rollerrig.cli.describe import describe_case, describe_part
    from rollerrig.config import Case, Plan, code_of, load_any, load_plan

    kind, part = load_any(file, allow_code=allow_code)
    if isinstance(part, Plan):
        from rollerrig.study.sweep import SweepStudy

        whole = load_plan(file, allow_code=allow_code)
        lines = [*code_lines(whole.code), *SweepStudy(whole, many=True).described()]
    elif isinstance(part, Case):
        lines = [*code_lines(code_of(part)), *describe_case(part, run_code=allow_code)]
    else:
        lines = describe_part(part)
    typer.echo(f"{file}: a valid {kind}\n")
    typer.echo("\n".join(lines))
