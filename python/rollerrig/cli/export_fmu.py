"""`rollerrig export-fmu CASE --out FILE.fmu`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from rollerrig.cli.command import AllowCode, CaseName, Changes, Force, read_case
from rollerrig.cli.termination import stop


def command(
    case: CaseName,
    out: Annotated[Path, typer.Option(metavar="FILE.fmu", help="File to write.")],
    fmi: Annotated[str, typer.Option(help="Version of the standard: 2 or 3.")] = "2",
    kind: Annotated[str, typer.Option(help="cs: co-simulation; me: model exchange; both.")] = "cs",
    external: Annotated[
        str, typer.Option(help="Tables of the controllers whose commands become inputs, with commas.")
    ] = "",
    part: Annotated[
        str,
        typer.Option(
            help="One controller of the case alone: slide_protection, wheel_slip_control, rig_control or brake_unit."
        ),
    ] = "",
    force: Force = False,
    change: Changes = None,
    allow_code: AllowCode = False,
) -> None:
    """A case as an FMU (Functional Mock-up Unit) for Simulink, Dymola, FMPy and others; no compiler is needed."""
    from rollerrig.interfaces.fmu.export import ExportError, export_fmu
    from rollerrig.interfaces.fmu.part import export_part
    from rollerrig.interfaces.fmu.shells import WINDOWS, shells

    roles = [role.strip() for role in external.split(",") if role.strip()]
    whole = read_case(case, allow_code=allow_code, changes=change)
    if part and roles:
        text = "a controller alone has no others: leave out one of --part and --external"
        raise typer.BadParameter(text, param_hint="--part")
    if part and kind != "cs":
        raise typer.BadParameter("a controller alone is sampled: allowed with --part: cs", param_hint="--kind")
    try:
        if part:
            typer.echo(export_part(whole, part, out, fmi=fmi, force=force))
        else:
            typer.echo(export_fmu(whole, out, fmi=fmi, kind=kind, external=roles, force=force))
    except ExportError as error:
        stop(error)
    carried = shells()
    for shell in carried:
        typer.echo(f"   runs on {shell.platform}" + (f", processor with {shell.needs}" if shell.needs else ""))
    if WINDOWS not in {shell.platform for shell in carried}:
        typer.echo("   not on Windows: this package was built without scripts/build_windows_shell")
