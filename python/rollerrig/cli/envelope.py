"""`rollerrig envelope CASE --torques-knm -18:-1.5:1.5 --out DIR`."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Annotated

import typer

from rollerrig.cli.progress import progress_bar
from rollerrig.cli.ranges import check_finite, read_range
from rollerrig.cli.termination import INTERRUPTED, say, stop


def command(
    case: Annotated[
        str, typer.Argument(help="Case on rollers with [rig_control]: a name of the catalogue or a TOML file.")
    ],
    out: Annotated[
        Path, typer.Option(help="Folder for the results; runs that an earlier command finished there are taken over.")
    ],
    torques_knm: Annotated[
        str | None,
        typer.Option(
            help="Torques on each axle [kN m], negative brakes: start:stop:step, or a list with commas. By default up to "
            "beyond what dry rollers carry, braking for a case with [brake]."
        ),
    ] = None,
    adhesions: Annotated[
        str | None, typer.Option(help="Adhesions of the reproduced rail, in the same forms; 0.02 to 0.36 if absent.")
    ] = None,
    loads: Annotated[
        str | None, typer.Option(help="Axle loads over the case's own, in the same forms; 0.6,1,1.4 if absent.")
    ] = None,
    speed_kmh: Annotated[float | None, typer.Option(help="Speed at the start [km/h]; the case's if absent.")] = None,
    duration: Annotated[float, typer.Option(help="Length of each run [s].")] = 3.0,
    refine: Annotated[
        int, typer.Option(min=0, max=4, help="How many times cells between different regions are halved.")
    ] = 1,
    processes: Annotated[int, typer.Option(min=1, max=64, help="Runs at a time.")] = 2,
) -> None:
    """Where the rig can reproduce a degraded rail: regions over torque, adhesion and axle load, and what limits each.

    Ctrl-C keeps all finished runs; the same command goes on with the rest.
    """
    from rollerrig.config import load_case
    from rollerrig.results import output_folder
    from rollerrig.studies.envelope import make_plan, run_plan
    from rollerrig.studies.envelope.write import example_runs, lead, write_envelope

    check_finite(speed_kmh, "--speed-kmh")
    check_finite(duration, "--duration")
    chosen = load_case(case)
    if speed_kmh is not None:
        chosen = chosen.with_changes({"motion.speed": speed_kmh / 3.6})
    plan = make_plan(
        chosen,
        torques=None if torques_knm is None else [1e3 * t for t in sorted(read_range(torques_knm, "--torques-knm"))],
        adhesions=None if adhesions is None else sorted(read_range(adhesions, "--adhesions")),
        loads=None if loads is None else sorted(read_range(loads, "--loads")),
        duration=duration,
        refine=refine,
    )
    folder, begun = output_folder(out), time.monotonic()
    with progress_bar(chosen.name) as progress:
        found = run_plan(plan, folder=folder, processes=processes, progress=progress)
        if found.attrs["interrupted"]:
            stop(f"interrupted; {found.attrs['runs']} finished runs are kept: the same command goes on", INTERRUPTED)
        progress(1.0, "runs over time")
        examples = example_runs(plan, found)
    written = write_envelope(chosen, found, examples, folder)
    say(lead(found))
    runs, before = found.attrs["runs"], found.attrs["runs_from_before"]
    each = found.attrs["processor_seconds"] / max(1, runs)
    taken = f", {before} of them from before" if before else ""
    say(f"{runs} runs{taken} in {time.monotonic() - begun:.0f} s; {each:.2f} s of processor time for each.")
    typer.echo(written[-1])
