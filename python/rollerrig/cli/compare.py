"""`rollerrig compare VEHICLE --on rig,track --speeds-kmh 60:300:20 --out DIR`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from rollerrig.cli.progress import progress_bar
from rollerrig.cli.ranges import read_range
from rollerrig.cli.termination import INTERRUPTED, say


def command(
    vehicle: Annotated[str, typer.Argument(help="Vehicle or case: a name of the catalogue or a TOML file.")],
    out: Annotated[Path, typer.Option(help="Folder for the results; made if it does not exist.")],
    on: Annotated[
        str, typer.Option(help="Supports, with commas: rig, track, names of the catalogue or files.")
    ] = "rig,track",
    speeds_kmh: Annotated[
        str, typer.Option(help="Speeds [km/h] as start:stop:step, or a list with commas.")
    ] = "60:300:20",
    cut: Annotated[
        str | None, typer.Option(help="Part of the vehicle; by default all of it, or what the case has.")
    ] = None,
    radii_m: Annotated[
        str, typer.Option(help="Radii of the rollers in the table of critical speeds [m].")
    ] = "0.46,0.725,1,2,5,10",
    disturbance_mm: Annotated[
        float, typer.Option(min=0.01, max=20.0, help="Lateral offset of the leading wheelset in the runs [mm].")
    ] = 3.0,
    duration: Annotated[float, typer.Option(min=1.0, max=600.0, help="Length of each of these runs [s].")] = 6.0,
    processes: Annotated[int, typer.Option(min=1, max=64, help="Runs at a time.")] = 2,
) -> None:
    """One vehicle on several supports side by side: modes, critical speeds, limit cycles, forces, and what a rig changes."""
    from rollerrig.analysis import HuntingSettings
    from rollerrig.results import output_folder
    from rollerrig.studies.compare import ComparePlan, compared_cases, compute, write_comparison
    from rollerrig.studies.compare.page import lead

    speeds = read_range(speeds_kmh, "--speeds-kmh")
    if speeds[0] <= 0 or any(b <= a for a, b in zip(speeds, speeds[1:], strict=False)):
        raise typer.BadParameter(f"'{speeds_kmh}': speeds must be positive and rise", param_hint="--speeds-kmh")
    radii = read_range(radii_m, "--radii-m")
    if any(not 0.05 <= radius <= 1e6 for radius in radii):
        raise typer.BadParameter(f"'{radii_m}': radii must lie between 0.05 and 1e6 m", param_hint="--radii-m")
    supports = [name.strip() for name in on.split(",")]
    if not all(supports) or len({Path(name).name.removesuffix(".toml") for name in supports}) < len(supports):
        raise typer.BadParameter(f"'{on}': name each support once, like rig,track", param_hint="--on")
    cases = compared_cases(vehicle, supports, cut)
    parts = next(iter(cases.values())).vehicle.data.cut_names()[::-1]
    settings = HuntingSettings(disturbance=1e-3 * disturbance_mm, duration=duration)
    plan = ComparePlan(cases, tuple(speeds), parts, tuple(sorted(set(radii))), hunting=settings)
    folder = output_folder(out)
    with progress_bar(f"compare {' and '.join(cases)}") as progress:
        results = compute(plan, processes=processes, progress=progress)
    written = write_comparison(results, folder)
    say(lead(results))
    typer.echo(written[-1])
    if results.interrupted:
        raise typer.Exit(INTERRUPTED)
