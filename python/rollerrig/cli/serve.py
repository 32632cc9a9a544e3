"""`rollerrig serve CASE --rate 1kHz --udp 127.0.0.1:PORT`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from rollerrig.cli.command import AllowCode
from rollerrig.cli.termination import LEFT_VALIDITY, exit_code, say, stop

Case = Annotated[
    str,
    typer.Argument(metavar="CASE", help="Case: a name of the catalogue or a TOML file; or a model file, rig.model."),
]
Rate = Annotated[str, typer.Option(help="Of commands and sensors.")]
Udp = Annotated[
    str | None,
    typer.Option(
        metavar="[ADDRESS:]PORT",
        help="Where to listen; the loopback unless an address is given. Absent: a free port.",
    ),
]
Shm = Annotated[
    str | None, typer.Option(metavar="NAME", help="Shared memory of this name, to be made, in place of UDP.")
]
LockStep = Annotated[
    bool,
    typer.Option("--lock-step", help="Wait for the command of each step: no real time, the same run on any machine."),
]
AtOnce = Annotated[
    bool,
    typer.Option("--at-once", help="Begin without a controller, and go on without one: commands at their start."),
]
External = Annotated[
    str | None,
    typer.Option(help="Tables of the controllers that are outside, with commas; absent: all but rig_control."),
]
Outputs = Annotated[
    str,
    typer.Option(help="Names of what is sent, with commas, '*' for anything; absent: what those controllers measure."),
]
Safe = Annotated[str, typer.Option(help="Commands of the safe state, NAME=VALUE with commas; the others are 0.")]
Patience = Annotated[int, typer.Option(min=1, help="Periods without a command until the watchdog acts.")]
Ramp = Annotated[float, typer.Option(min=0.0, max=60.0, help="From there to the safe state [s].")]
Record = Annotated[Path | None, typer.Option(help="File for what acted and what was sent in each period (.npz).")]
Replay = Annotated[
    Path | None,
    typer.Option(help="Run with the commands of such a file, without a network, and compare what is sent."),
]
Watch = Annotated[bool, typer.Option("--watch", help="Show deadlines and frames while it runs.")]


def command(
    case: Case,
    rate: Rate = "1 kHz",
    udp: Udp = None,
    shm: Shm = None,
    lock_step: LockStep = False,
    at_once: AtOnce = False,
    external: External = None,
    outputs: Outputs = "",
    safe: Safe = "",
    patience: Patience = 10,
    ramp: Ramp = 0.2,
    record: Record = None,
    replay: Replay = None,
    watch: Watch = False,
    allow_code: AllowCode = False,
) -> None:
    """The rig as a server for a controller in another process or on a test bench, in real time."""
    from rollerrig.cli import serving
    from rollerrig.interfaces.realtime.server import check_rate, open_server

    address, port = serving.address_of(udp, shm, case)
    kept = None if replay is None else serving.read_record(replay)
    served = serving.prepared(
        case,
        rate,
        external=external,
        outputs=[name.strip() for name in outputs.split(",") if name.strip()],
        safe=serving.values_of(safe, case),
        lock_step=lock_step if kept is None else bool(kept["lock_step"]),
        allow_code=allow_code,
    )
    if kept is not None:
        typer.echo(serving.replayed(served, kept, str(replay)))
        raise typer.Exit
    serving.check_target(record)
    if not lock_step:
        check_rate(served)
    server = open_server(
        served,
        address,
        port,
        lock_step=lock_step,
        at_once=at_once,
        patience=patience,
        ramp=ramp,
        record=record is not None,
    )
    for line in serving.opening_lines(served, address, server.port, lock_step=lock_step):
        say(f"rollerrig: {line}")
    ended = serving.run_watched(server, live=watch)
    if record is not None:
        serving.write_record(record, served, server, lock_step=lock_step)
    typer.echo("\n".join(serving.closing_lines(served, server, ended)))
    if ended.ending == "controller_silent":
        stop("in lock-step the run cannot go on without commands", LEFT_VALIDITY)
    raise typer.Exit(exit_code("interrupted" if ended.ending == "stopped_by_caller" else ended.status))
