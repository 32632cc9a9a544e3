"""Commands about runs: export, compare-runs, sweep (many), view, and play, a run that goes on in a browser."""

from pathlib import Path
from typing import Annotated

import typer

from rollerrig.cli.command import (
    AllowCode,
    CaseName,
    Changes,
    Force,
    Out,
    carry_out,
    changes_of,
    code_lines,
    picture_kind,
    read_case,
)
from rollerrig.cli.termination import say, stop

__all__ = ["compare_runs", "export", "play", "sweep", "view"]


def export(
    run: Annotated[Path, typer.Argument(help="A file of results, e.g. run.nc.")],
    to: Annotated[str, typer.Option(help="mat, csv or parquet.")] = "mat",
    out: Annotated[Path | None, typer.Option(help="The file; beside the run, with its name, if absent.")] = None,
    over: Annotated[str, typer.Option(help="Of a table: time, or reading_time of the finer readings.")] = "time",
    force: Force = False,
) -> None:
    """Write a run for other programs: MATLAB, a CSV table, Parquet."""
    from rollerrig.results import export

    typer.echo(export(run, out or run.with_suffix(f".{to}"), to=to, over=over, force=force))


def compare_runs(
    runs: Annotated[list[Path], typer.Argument(metavar="A.nc B.nc ...", help="Two or more files of results.")],
    signal: Annotated[
        list[str] | None,
        typer.Option(help="What to show, repeatable: speed, lateral:wheelset_1, vertical_force:wheelset_1_left, ..."),
    ] = None,
    out: Annotated[Path, typer.Option(help="Picture: a file that ends in .svg, .png or .pdf.")] = Path("runs.svg"),
    force: Force = False,
) -> None:
    """Lay your own runs over each other: a picture, and by how much each differs from the first one."""
    kind = picture_kind(out)
    from rollerrig.analysis.runs_together import compare_runs
    from rollerrig.common.formatting import number
    from rollerrig.plot import figure_bytes, runs_together
    from rollerrig.plot.run import shown_unit
    from rollerrig.results import load_run, output_file, write_bytes

    output_file(out, force=force)
    try:
        found = compare_runs(dict(zip(_labels(runs), map(load_run, runs), strict=True)), signal or ())
    except ValueError as error:
        stop(error)
    typer.echo(write_bytes(out, figure_bytes(runs_together(found), kind), force=force))
    names = [str(name) for name, values in found.data_vars.items() if "time" in values.dims]
    width = max(map(len, [*names, "largest difference to the first"]))
    typer.echo(f"{'largest difference to the first':{width}}  {'  '.join(map(str, found['run'].to_numpy()[1:]))}")
    for name in names:
        unit, factor = shown_unit(found[name])
        apart = (factor * found[f"{name} largest difference"]).to_numpy()[1:]
        typer.echo(f"{name:{width}}  {'  '.join(f'{number(float(value), 3)} {unit}' for value in apart)}")


def _labels(runs: list[Path]) -> list[str]:
    """The files' names; where several have the same, those of their folders, as far up as tells them apart."""
    of_folders = len(runs) > 1 and len({path.stem for path in runs}) == 1
    places = [path.absolute().parent if of_folders else path.absolute().with_suffix("") for path in runs]
    for depth in range(1, max(len(place.parts) for place in places) + 1):
        names = ["/".join(place.parts[-depth:]) for place in places]
        if len(set(names)) == len(names):
            return names
    return [f"{path} ({number})" for number, path in enumerate(runs, 1)]


def sweep(
    plan: Annotated[str, typer.Argument(metavar="PLAN", help="Plan: a name of the catalogue or a TOML file.")],
    out: Out,
    workers: Annotated[int, typer.Option(min=1, max=256, help="Processes of this machine.")] = 2,
    dask: Annotated[
        str | None,
        typer.Option(
            metavar="ADDRESS", help="Scheduler of a dask cluster that does the work instead, e.g. tcp://127.0.0.1:8786."
        ),
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
    from rollerrig.study.cluster import cluster
    from rollerrig.study.sweep import SweepStudy

    whole = load_plan(plan, allow_code=allow_code, changes=changes_of(change))
    for line in code_lines(whole.code):
        say(f"rollerrig: {plan}: {line}")
    study = SweepStudy(whole, many=yes)
    if dask is None:
        carry_out(study, out, workers, force=force)
    with cluster(dask) as executor:
        carry_out(study, out, force=force, executor=executor)


def view(
    run: Annotated[Path, typer.Argument(help="A run, e.g. run.nc of `rollerrig run`.")],
    other: Annotated[Path | None, typer.Argument(help="Another run, shown beside it in step.")] = None,
    out: Annotated[Path, typer.Option(help="The page: one file, for any browser, without a network.")] = Path(
        "view.html"
    ),
    force: Force = False,
) -> None:
    """Show a run in motion: one HTML file with the vehicle, its contacts and forces, and curves in step."""
    from rollerrig.viewer import view

    typer.echo(view(run, other, path=out, force=force))


def play(
    case: CaseName,
    port: Annotated[int, typer.Option(min=0, max=65535, help="Where to listen on the loopback; 0: any free one.")] = 0,
    browser: Annotated[bool, typer.Option(help="Open the page in a browser.")] = True,
    exhibition: Annotated[
        bool,
        typer.Option("--exhibition", help="Say what one sees, enlarge it, move it after a minute without visitors."),
    ] = False,
    change: Changes = None,
    allow_code: AllowCode = False,
) -> None:
    """Move a simulation that runs in real time: sliders for speed, radius, friction, torque, gains; until Ctrl-C."""
    from rollerrig.viewer.play import play

    def tell(address: str) -> None:
        typer.echo(address)
        say("Ctrl-C ends it.")

    try:
        chosen = read_case(case, allow_code=allow_code, changes=change)
        play(chosen, port=port, browser=browser, exhibition=exhibition, tell=tell)
    except OSError as error:
        stop(f"--port {port}: {error.strerror or error}; choose another one, or 0 for any free one")
