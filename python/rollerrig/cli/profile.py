"""`rollerrig profile FILE --out profile.svg`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

import typer

from rollerrig.cli.command import Force, picture_kind
from rollerrig.cli.termination import say, stop


def command(
    source: Annotated[
        str, typer.Argument(metavar="FILE", help="File of points, TOML file, or a name of the catalogue.")
    ],
    kind: Annotated[
        Literal["wheel", "rail"] | None, typer.Option(help="What it is for: wheel or rail; known from .prw and .prr.")
    ] = None,
    smoothing_mm: Annotated[
        float | None, typer.Option(min=0.01, max=50.0, help="Another cut-off wavelength of measured points [mm].")
    ] = None,
    out: Annotated[Path, typer.Option(help="Picture: a file that ends in .svg, .png or .pdf.")] = Path("profile.svg"),
    export: Annotated[
        Path | None, typer.Option(help="Also the smooth curve as .csv, or for Simpack as .prw (wheel) or .prr (rail).")
    ] = None,
    force: Force = False,
) -> None:
    """A profile: its points beside the smooth curve that the contact search sees, slope and curvature; export."""
    picture = picture_kind(out)
    from rollerrig.contact_analysis.profile_curve import COLUMNS, FIRST_LINE, profile, profile_csv, simpack_text
    from rollerrig.plot import figure_bytes, profile_figure
    from rollerrig.profiles import ProfileError
    from rollerrig.results import output_file, write_bytes, write_text

    try:
        curve = profile(source, kind, None if smoothing_mm is None else 1e-3 * smoothing_mm)
    except ProfileError as error:
        stop(error)
    endings = {".csv": profile_csv, ".prw" if curve.attrs["kind"] == "wheel" else ".prr": simpack_text}
    marks = (COLUMNS, FIRST_LINE)
    if export is not None:
        if export.suffix.lower() not in endings:
            allowed = f"allowed for a {curve.attrs['kind']}: a file that ends in {' or '.join(endings)}"
            raise typer.BadParameter(f"'{export}': {allowed}", param_hint="--export")
        output_file(export, tables=marks, force=force)
    output_file(out, force=force)
    typer.echo(write_bytes(out, figure_bytes(profile_figure(curve), picture), force=force))
    if export is not None:
        typer.echo(write_text(export, endings[export.suffix.lower()](curve), tables=marks, force=force))
    say(f"{curve.attrs['name']}: {curve.attrs['source']}")
