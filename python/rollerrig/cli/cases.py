"""Commands about cases and other files: new, explain, schema, check, catalog, show, profile, contact, cite."""

import json
from difflib import get_close_matches
from pathlib import Path
from typing import Annotated, Literal

import typer

from rollerrig.cli.command import AllowCode, CaseName, Changes, Force, changes_of, code_lines, picture_kind, read_case
from rollerrig.cli.ranges import check_finite, read_range
from rollerrig.cli.termination import LEFT_VALIDITY, readable_errors, say, stop

__all__ = ["catalog", "check", "cite", "contact", "explain", "new", "profile", "schema", "show"]


def new(
    name: Annotated[str, typer.Argument(metavar="NAME", help="Name of the new case; the file is NAME.toml.")],
    source: Annotated[
        str, typer.Option("--from", metavar="CASE", help="Case to start from: a name of the catalogue or a TOML file.")
    ] = "bogie_rollers_constant",
    out: Annotated[Path, typer.Option(help="Folder for the file; made if it does not exist.")] = Path(),
    force: Force = False,
) -> None:
    """Write a case to begin with, which runs as it stands: its keys explained, the defaults beside them as comments."""
    from rollerrig.catalog.starting_case import starting_case
    from rollerrig.results import OutputError, output_folder, write_text

    target = Path(f"{name.removesuffix('.toml')}.toml")
    if out.suffix == ".toml":
        raise OutputError(out, f"--out is the folder; the file in it is {target}")
    text = starting_case(target.stem, source)
    if (out / target).exists() and not force:
        raise OutputError(out / target, "there is a case of that name; choose another name, or replace it with --force")
    target = output_folder(out) / target
    typer.echo(write_text(target, text, force=force))
    say(f"It runs as it stands: rollerrig run {target} --out {target.stem}-run")


def explain(
    key: Annotated[
        str,
        typer.Argument(metavar="KEY", help="Dotted key like motion.speed, its last part alone, or a word to look for."),
    ],
) -> None:
    """What a key of a file means: its unit, default, what is allowed, where it stands, which shipped files have it."""
    from rollerrig.config import explain

    try:
        typer.echo(explain(key))
    except KeyError as error:
        stop(error.args[0])


def schema(
    kind: Annotated[
        Literal["case", "vehicle", "support", "material", "profile", "programme", "plan", "fit"],
        typer.Argument(help="Kind of file.", metavar="KIND"),
    ] = "case",
) -> None:
    """Print the JSON Schema of a kind of file (case, vehicle, support, material, profile, programme, plan, fit), for editors."""
    from rollerrig.config import json_schema

    typer.echo(json.dumps(json_schema(kind), indent=1, ensure_ascii=False))


def check(
    file: Annotated[str, typer.Argument(help="A TOML file, or a name of the catalogue.")],
    change: Changes = None,
    allow_code: Annotated[
        bool,
        typer.Option(
            "--allow-code", help="Also run the controllers that a case brings, wherever they lie, to check them."
        ),
    ] = False,
) -> None:
    """Validate a file; of a case, print the assembled model, its static wheel loads and masses.

    The file must be valid by itself, before --set changes it.
    """
    from rollerrig.config import Case, ConfigError, FitPlan, Plan, code_of, load_any, load_plan
    from rollerrig.config.load.fit import load_fit

    kind, part = load_any(file, allow_code=allow_code)
    from rollerrig.cli.describe import describe_case, describe_part  # a wrong file needs none of it

    changes = changes_of(change)
    if changes and not isinstance(part, Case | Plan | FitPlan):
        raise typer.BadParameter(f"'{file}' is a {kind}; allowed: with a case or a plan", param_hint="--set")
    if isinstance(part, Case) and changes:
        part = part.with_changes(changes)
    if isinstance(part, Plan):
        from rollerrig.study.sweep import SweepStudy

        whole = load_plan(file, allow_code=allow_code, changes=changes)
        lines = [*code_lines(whole.code), *SweepStudy(whole, many=True).described()]
    elif isinstance(part, FitPlan):
        fit = load_fit(file, allow_code=allow_code, changes=changes)
        sought = (
            f"{one.key}: {one.start:g} {one.quantity.unit}, from {one.least:g} to {one.most:g}" for one in fit.free
        )
        lines = [*code_lines(fit.code), f"{part.name}: {part.description or part.case}", *sought]
    elif isinstance(part, Case):
        lines = [*code_lines(code_of(part)), *describe_case(part, run_code=allow_code)]
        if part.brake is not None or part.traction is not None:  # else no command makes an ensemble of it
            from rollerrig.study.ensemble import check_ensemble

            try:
                check_ensemble(part)
            except ConfigError as error:
                lines += [f"no test for adhesion, tune, wsp: {problem}" for problem in error.problems]
    else:
        lines = describe_part(part)
    typer.echo(f"{file}: a valid {kind}\n")
    typer.echo("\n".join(lines))


catalog = typer.Typer(rich_markup_mode=None, invoke_without_command=True, add_completion=False)


@catalog.callback()
def list_catalog(context: typer.Context) -> None:
    """What ships: vehicles, supports, cases, plans."""
    if context.invoked_subcommand is not None:
        return
    from rollerrig.catalog import catalog_entries

    entries = catalog_entries()
    width = max(len(name) for _, name, _ in entries)
    heading = ""
    for kind, name, description in entries:
        if kind != heading:
            typer.echo(f"{'' if not heading else chr(10)}{kind}s")
            heading = kind
        typer.echo(f"  {name:{width}}  {description}")


@catalog.command("show")
@readable_errors
def show_entry(name: Annotated[str, typer.Argument(help="Name of an entry.")]) -> None:
    """Print one entry as TOML, to copy and edit."""
    from rollerrig.catalog import catalog_entries, catalog_text

    try:
        typer.echo(catalog_text(name), nl=False)
    except KeyError:
        names = [entry for _, entry, _ in catalog_entries()]
        near = get_close_matches(name, names, n=1)
        cure = f"did you mean '{near[0]}'?" if near else f"it has {', '.join(names)}"
        stop(f"catalog: {name}: not in the catalogue; {cure}")


def show(
    case: CaseName,
    out: Annotated[Path, typer.Option(help="Picture: a file that ends in .svg, .png or .pdf.")] = Path("vehicle.svg"),
    change: Changes = None,
    allow_code: AllowCode = False,
    force: Force = False,
) -> None:
    """Draw the vehicle on its rig or track to scale, from three sides: bodies, springs, dampers, locks, actuators, axes."""
    kind = picture_kind(out)
    chosen = read_case(case, allow_code=allow_code, changes=change)
    from rollerrig.plot import figure_bytes, vehicle
    from rollerrig.results import output_file, write_bytes

    output_file(out, force=force)
    typer.echo(write_bytes(out, figure_bytes(vehicle(chosen), kind), force=force))


def profile(
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
    from rollerrig.results import output_file, write_bytes, write_text

    curve = profile(source, kind, None if smoothing_mm is None else 1e-3 * smoothing_mm)
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


def contact(
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
    plot: Annotated[Path | None, typer.Option(help="Picture of the table (.svg, .png or .pdf).")] = None,
    compare: Annotated[
        bool, typer.Option("--compare", help="Every normal contact and creep law side by side, with its cost.")
    ] = False,
    change: Changes = None,
    allow_code: AllowCode = False,
    force: Force = False,
) -> None:
    """List the contact patches of the leading wheelset under its axle load."""
    from rollerrig.contact_analysis import comparison
    from rollerrig.contact_analysis.static_contact import COLUMNS, contact, contact_rows
    from rollerrig.results import output_file, write_bytes, write_text
    from rollerrig.study.frame import csv_text

    kind = None if plot is None else picture_kind(plot, "--plot")
    check_finite(roll_mrad, "--roll-mrad")
    places = _positions(lateral_mm, yaw_mrad, yaw_mrad_per_mm)
    chosen = read_case(case, allow_code=allow_code, changes=change)
    tables = tuple(",".join(head) for head in (COLUMNS, comparison.NORMALS_COLUMNS, comparison.CREEP_COLUMNS))
    for path in (csv, plot, *((_beside(csv), plot and _beside(plot)) if compare else ())):
        if path is not None:
            output_file(path, tables=tables, force=force)
    roll = None if roll_mrad is None else 1e-3 * roll_mrad
    written: tuple[list[list[object]], ...]
    if compare:
        try:
            table = comparison.compare_contacts(chosen, places, roll=roll)
        except ValueError as error:
            stop(error)
        typer.echo(comparison.comparison_text(table))
        written = comparison.comparison_rows(table)
    else:
        table = contact(chosen, places, roll=roll)
        written = (contact_rows(table, COLUMNS),)
    for path, rows in zip((csv, _beside(csv)), written, strict=False):
        typer.echo(write_text(path, csv_text(rows), tables=tables, force=force))
    if plot is not None and kind is not None:
        from rollerrig.plot import comparison_figure, contact_figure, creep_comparison_figure, figure_bytes

        draws = (comparison_figure, creep_comparison_figure) if compare else (contact_figure,)
        for path, draw in zip((plot, _beside(plot)), draws, strict=False):
            typer.echo(write_bytes(path, figure_bytes(draw(table), kind), force=force))
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


def _beside(path: Path) -> Path:
    """The file of the creep laws: contact.csv -> contact_creep.csv."""
    return path.with_name(f"{path.stem}_creep{path.suffix}")


def cite(
    what: Annotated[
        str | None, typer.Argument(metavar="[RUN.nc or CASE]", help="Also the sources of its models and data.")
    ] = None,
) -> None:
    """Print BibTeX: the program, the paper and, of a run or a case, the sources of the models and data in it."""
    from rollerrig.results import cite, load_run

    typer.echo(cite(load_run(what) if what and what.endswith(".nc") else what), nl=False)
