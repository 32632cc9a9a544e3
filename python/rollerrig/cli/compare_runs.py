"""`rollerrig compare-runs A.nc B.nc --out runs.svg`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from rollerrig.cli.command import Force, picture_kind
from rollerrig.cli.termination import stop


def command(
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
    from rollerrig.plot.runs_together import shown_unit
    from rollerrig.results import ResultsError, load_run, output_file, write_bytes

    output_file(out, force=force)
    try:
        found = compare_runs(dict(zip(_labels(runs), map(load_run, runs), strict=True)), signal or ())
    except (ResultsError, FileNotFoundError, ValueError) as error:
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
    stems = [path.stem for path in runs]
    if len(set(stems)) == len(stems):
        return stems
    folders = [
        path.absolute().parent.parts if len(set(stems)) == 1 else path.absolute().with_suffix("").parts for path in runs
    ]
    for depth in range(1, max(map(len, folders)) + 1):
        names = ["/".join(parts[-depth:]) for parts in folders]
        if len(set(names)) == len(names):
            return names
    return [f"{path} ({number})" for number, path in enumerate(runs, 1)]
