"""`rollerrig contact CASE --lateral-mm=-8:8:0.5 --csv FILE [--compare]`."""

from pathlib import Path
from typing import Annotated, Literal

import typer

from rollerrig.cli.command import AllowCode, Changes, Force, read_case
from rollerrig.cli.ranges import check_finite, read_range
from rollerrig.cli.termination import LEFT_VALIDITY, say, stop


def command(
    case: Annotated[str, typer.Argument(help="Case: a name of the catalogue or a TOML file.")],
    lateral_mm: Annotated[
        str, typer.Option(help="Lateral positions of the wheelset: start:stop:step, a list or one number [mm].")
    ],
    csv: Annotated[Path, typer.Option(help="File for the table, one row per contact patch.")],
    yaw_mrad: Annotated[str | None, typer.Option(help="Yaw angles: a range, a list or one number [mrad].")] = None,
    yaw_mrad_per_mm: Annotated[
        float | None, typer.Option(help="Yaw in proportion to the lateral position [mrad/mm].")
    ] = None,
    roll_mrad: Annotated[float | None, typer.Option(help="Roll angle to hold [mrad]; free to roll if absent.")] = None,
    plot: Annotated[Path | None, typer.Option(help="Picture of the table (.png or .svg).")] = None,
    compare: Annotated[
        bool, typer.Option("--compare", help="Every normal contact and creep law side by side, with its cost.")
    ] = False,
    change: Changes = None,
    allow_code: AllowCode = False,
    force: Force = False,
) -> None:
    """List the contact patches of the leading wheelset under its axle load."""
    from rollerrig.contact_analysis.static_contact import contact_csv, contact_table
    from rollerrig.results import output_file, write_bytes, write_text

    if plot is not None and plot.suffix.lower() not in (".png", ".svg"):
        raise typer.BadParameter(f"'{plot}' must end in .png or .svg", param_hint="--plot")
    check_finite(roll_mrad, "--roll-mrad")
    places = _positions(lateral_mm, yaw_mrad, yaw_mrad_per_mm)
    chosen = read_case(case, allow_code=allow_code, changes=change)
    tables = _known_tables()
    for path in (csv, plot, *((_beside(csv), plot and _beside(plot)) if compare else ())):
        if path is not None:
            output_file(path, tables=tables, force=force)
    roll = None if roll_mrad is None else 1e-3 * roll_mrad
    if compare:
        from rollerrig.contact_analysis.creep_laws import compare_creep, creep_csv, creep_text
        from rollerrig.contact_analysis.static_contact import compare_contacts, comparison_csv, comparison_text

        try:
            creep = compare_creep(chosen, places, roll=roll)
        except ValueError as error:
            stop(error)
        table = compare_contacts(chosen, places, roll=roll)
        typer.echo(comparison_text(table))
        typer.echo(creep_text(creep))
        typer.echo(write_text(csv, comparison_csv(table), tables=tables, force=force))
        typer.echo(write_text(_beside(csv), creep_csv(creep), tables=tables, force=force))
    else:
        table = contact_table(chosen, places, roll=roll)
        typer.echo(write_text(csv, contact_csv(table), tables=tables, force=force))
    if plot is not None:
        from rollerrig.plot import figure_bytes
        from rollerrig.plot.contact import comparison_figure, contact_figure, creep_comparison_figure

        kind: Literal["svg", "png"] = "svg" if plot.suffix.lower() == ".svg" else "png"
        figure = comparison_figure(table) if compare else contact_figure(table)
        typer.echo(write_bytes(plot, figure_bytes(figure, kind), force=force))
        if compare:
            typer.echo(write_bytes(_beside(plot), figure_bytes(creep_comparison_figure(creep), kind), force=force))
    if table.attrs["failed_positions"]:
        for line in table.attrs["failed_positions"].splitlines():
            say(f"rollerrig: {chosen.name}: {line}")
        raise typer.Exit(LEFT_VALIDITY)


def _positions(lateral_mm: str, yaw_mrad: str | None, yaw_mrad_per_mm: float | None) -> list[tuple[float, float]]:
    """Lateral positions [m] and yaw angles [rad] of the options."""
    if yaw_mrad is not None and yaw_mrad_per_mm is not None:
        raise typer.BadParameter("give --yaw-mrad or --yaw-mrad-per-mm, not both", param_hint="--yaw-mrad")
    check_finite(yaw_mrad_per_mm, "--yaw-mrad-per-mm")
    lateral = read_range(lateral_mm, "--lateral-mm")
    if yaw_mrad_per_mm is not None:
        return [(1e-3 * y, 1e-3 * (y * yaw_mrad_per_mm)) for y in lateral]
    yaw = read_range(yaw_mrad, "--yaw-mrad") if yaw_mrad is not None else [0.0]
    return [(1e-3 * y, 1e-3 * psi) for psi in yaw for y in lateral]


def _known_tables() -> tuple[str, ...]:
    """First lines of the tables that this command writes: those it may replace."""
    from rollerrig.contact_analysis.creep_laws import SIDE_BY_SIDE_HEAD
    from rollerrig.contact_analysis.static_contact import CSV_HEAD, NORMALS_HEAD

    return CSV_HEAD, NORMALS_HEAD, SIDE_BY_SIDE_HEAD


def _beside(path: Path) -> Path:
    """The file of the creep laws: contact.csv -> contact_creep.csv."""
    return path.with_name(f"{path.stem}_creep{path.suffix}")
