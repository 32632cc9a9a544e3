"""`rollerrig compare VEHICLE --on rig,track --speeds-kmh 60:300:20 --out DIR`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from rollerrig.cli.command import AllowCode, Force, Out, Processes, SpeedsKmh, carry_out, code_lines
from rollerrig.cli.ranges import read_range, read_speeds
from rollerrig.cli.termination import say


def command(
    vehicle: Annotated[str, typer.Argument(help="Vehicle or case: a name of the catalogue or a TOML file.")],
    out: Out,
    on: Annotated[
        str, typer.Option(help="Supports, with commas: rig, track, names of the catalogue or files.")
    ] = "rig,track",
    speeds_kmh: SpeedsKmh = "60:300:20",
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
    processes: Processes = 2,
    allow_code: AllowCode = False,
    force: Force = False,
) -> None:
    """One vehicle on several supports side by side: modes, critical speeds, limit cycles, forces, effects of the rollers."""
    from rollerrig.analysis import HuntingSettings
    from rollerrig.config import code_of
    from rollerrig.study.compare import CompareStudy
    from rollerrig.study.runs.compare import compared_cases

    speeds, radii = read_speeds(speeds_kmh), read_range(radii_m, "--radii-m")
    if any(not 0.05 <= radius <= 1e6 for radius in radii):
        raise typer.BadParameter(f"'{radii_m}': radii must lie between 0.05 and 1e6 m", param_hint="--radii-m")
    supports = [name.strip() for name in on.split(",")]
    if not all(supports) or len({Path(name).name.removesuffix(".toml") for name in supports}) < len(supports):
        raise typer.BadParameter(f"'{on}': name each support once, like rig,track", param_hint="--on")
    cases = compared_cases(vehicle, supports, cut, allow_code=allow_code)
    for line in dict.fromkeys(line for case in cases.values() for line in code_lines(code_of(case))):
        say(f"rollerrig: {vehicle}: {line}")
    parts = next(iter(cases.values())).vehicle.data.cut_names()[::-1]
    settings = HuntingSettings(disturbance=1e-3 * disturbance_mm, duration=duration)
    study = CompareStudy(cases, speeds, tuple(parts), tuple(sorted(set(radii))), hunting=settings)
    carry_out(study, out, processes, force=force)
