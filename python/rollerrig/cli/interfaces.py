"""Commands for other programs: assemble, export-fmu, serve.

options of `serve` -> addresses, safe values;  server -> [run_watched] -> lines at its end;  record -> file -> the same run again
"""

from __future__ import annotations

import ipaddress
import math
import sys
import zipfile
from concurrent.futures import ThreadPoolExecutor, wait
from contextlib import nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from rollerrig.cli.command import AllowCode, CaseName, Changes, Force, read_case
from rollerrig.cli.termination import LEFT_VALIDITY, exit_code, say, stop

if TYPE_CHECKING:
    from rollerrig.interfaces.realtime.server import Ended, Served

__all__ = ["assemble", "export_fmu", "serve"]


def names_in(text: str) -> list[str]:
    """Names with commas between."""
    return [name.strip() for name in text.split(",") if name.strip()]


def assemble(
    case: CaseName,
    out: Annotated[Path, typer.Option(help="The model file.")],
    external: Annotated[
        str,
        typer.Option(
            metavar="TABLES", help="Controllers whose commands come from outside, with commas: slide_protection, ..."
        ),
    ] = "",
    force: Force = False,
    change: Changes = None,
    allow_code: AllowCode = False,
) -> None:
    """Write everything that a run of a case needs into one file, for other tools and without Python."""
    from rollerrig.interfaces.plant import assemble_file, contents, read_model

    whole = read_case(case, allow_code=allow_code, changes=change)
    path = assemble_file(whole, out, external=names_in(external), force=force)
    typer.echo(path)
    say(contents(read_model(path)))


def export_fmu(
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
    from rollerrig.interfaces.fmu.export import WINDOWS, export_fmu, export_part, shells

    roles = names_in(external)
    whole = read_case(case, allow_code=allow_code, changes=change)
    if part and roles:
        text = "a controller alone has no others: leave out one of --part and --external"
        raise typer.BadParameter(text, param_hint="--part")
    if part and kind != "cs":
        raise typer.BadParameter("a controller alone is sampled: allowed with --part: cs", param_hint="--kind")
    if part:
        typer.echo(export_part(whole, part, out, fmi=fmi, force=force))
    else:
        typer.echo(export_fmu(whole, out, fmi=fmi, kind=kind, external=roles, force=force))
    carried = shells()
    for shell in carried:
        typer.echo(f"   runs on {shell.platform}" + (f", processor with {shell.needs}" if shell.needs else ""))
    if WINDOWS not in {shell.platform for shell in carried}:
        typer.echo("   not on Windows: this package was built without scripts/build_windows_shell")


LOOPBACK = "127.0.0.1"
LOOK_SECONDS = 0.25
"""Between two looks at a server that runs."""


def address_of(udp: str | None, shm: str | None, case: str) -> tuple[str, int]:
    """Address and port of '127.0.0.1:5005' or '5005'; or '/name' of shared memory."""
    if shm is not None:
        name = shm.removeprefix("/")
        if udp is not None or not name or "/" in name or len(name) > 100:
            stop(f"{case}: shm: {shm!r}; allowed: a name without '/', in place of --udp")
        return f"/{name}", 0
    text = udp if udp is not None else f"{LOOPBACK}:0"
    host, _, number = text.rpartition(":")
    try:
        address, port = str(ipaddress.IPv4Address(host or LOOPBACK)), int(number)
        if not 0 <= port <= 65535:
            raise ValueError
    except ValueError:
        allowed = f"allowed: a port from 0 to 65535, or an address of IPv4 and a port, {LOOPBACK}:5005"
        stop(f"{case}: udp: {text!r}; {allowed}")
    return address, port


def values_of(text: str, case: str) -> dict[str, float]:
    """Numbers by name of 'a=1, b=2'."""
    found = {}
    for part in names_in(text):
        name, _, number = part.partition("=")
        try:
            found[name.strip()] = float(number)
        except ValueError:
            stop(f"{case}: safe: {part!r}; allowed: NAME=VALUE, with commas between")
    return found


def prepared(case: str, rate: str, external: str | None, lock_step: bool, allow_code: bool, **given: Any) -> Served:
    """The rig of a case or of a model file."""
    from rollerrig.interfaces.plant import read_model
    from rollerrig.interfaces.realtime.server import serve_case, serve_model

    if not case.endswith(".model"):
        roles = None if external is None else names_in(external)
        whole = read_case(case, allow_code=allow_code)
        return serve_case(whole, rate, external=roles, lock_step=lock_step, **given)
    if external is not None:
        allowed = "a model file has its external controllers from `rollerrig assemble --external`"
        stop(f"{case}: external: {external!r}; {allowed}")
    try:
        assembled = read_model(case)
    except OSError as error:
        stop(f"{case}: {error.strerror}")
    return serve_model(assembled, rate, name=case, **given)


def opening_lines(served: Served, address: str, port: int, *, lock_step: bool) -> list[str]:
    """Text before a run."""
    pace = "in lock-step, not in real time" if lock_step else f"{1.0 / served.period:g} Hz"
    place = f"shared memory {address}" if address.startswith("/") else f"UDP {address}:{port}"
    lines = [
        f"{served.name}: {place}, {pace}; {len(served.inputs)} commands, {len(served.outputs)} sensors",
        f"frames are neither encrypted nor signed: whoever reaches {address} can command the rig",
    ]
    if not address.startswith("/") and not ipaddress.IPv4Address(address).is_loopback:
        lines.append(f"{address} is not the loopback: other machines reach it")
    return lines


def run_watched(server: Any, *, live: bool) -> Ended:
    """Run a server; Ctrl-C ends it after the period at work."""
    from rich.console import Console
    from rich.live import Live

    from rollerrig.interfaces.realtime.server import run_server

    with ThreadPoolExecutor(1, "rig") as executor:
        ended = executor.submit(run_server, server)
        try:
            with Live(console=Console(stderr=True)) if live and sys.stderr.isatty() else nullcontext() as show:
                while not wait([ended], LOOK_SECONDS).done:
                    if show is not None:
                        show.update("\n".join(state_lines(server.statistics())))
        except KeyboardInterrupt:
            server.stop()
        return ended.result()


def state_lines(told: dict[str, Any]) -> list[str]:
    """State, deadlines and frames of a server, as it runs and at its end."""
    from rollerrig.interfaces.realtime.frames import STATES

    lines = [f"{STATES[told['state']]}, t = {told['time']:.3f} s, {told['periods']} periods"]
    for name, key in (("step", "step"), ("wake-up", "wake")):
        count, *times = told[key]
        if count:
            shown = zip(("median", "99 %", "99.99 %", "longest"), times, strict=True)
            lines.append(f"{name}: {', '.join(f'{what} {1e-3 * ns:.1f}' for what, ns in shown)} us, of {count}")
    lines.append(f"deadlines missed: {told['misses']}, given up: {told['skipped']}")
    lines.append("frames: " + ", ".join(f"{n} {name}" for name, n in told["frames"].items() if n or name == "accepted"))
    first = f", first at t = {told['first_trip']:.3f} s: safe state" if told["trips"] else ""
    return [*lines, f"silent for {told['silent']} periods; watchdog: {told['trips']} times{first}"]


def histogram_lines(bins: list[tuple[int, int, int]]) -> list[str]:
    """Steps and wake-ups per doubling of the time, from rows (upper edge [ns], steps, wake-ups)."""
    counts: dict[float, list[int]] = {}
    for edge, *both in bins:
        microseconds = 2.0 ** max(0, math.ceil(math.log2(1e-3 * edge)))
        counts[microseconds] = [a + b for a, b in zip(counts.get(microseconds, (0, 0)), both, strict=True)]
    rows = [f"{f'{until:g} us':>12} {steps:>10} {wakes:>10}" for until, (steps, wakes) in sorted(counts.items())]
    return [f"{'up to':>12} {'steps':>10} {'wake-ups':>10}", *rows] if rows else []


def closing_lines(served: Served, server: Any, ended: Ended) -> list[str]:
    """Text after a run."""
    words = {
        "ran": "to its end",
        "stopped_by_caller": "interrupted",
        "plant_ended": ended.sentence,
        "controller_silent": "the controller fell silent",
    }
    state, *others = state_lines(server.statistics())
    how = f"memory: {ended.memory}; scheduling: {ended.scheduling}"
    head = f"{served.name}: {state.partition(', ')[2]}; {words[ended.ending]}"
    return [head, *others, *histogram_lines(server.histogram()), how]


# ---------------------------------------------------------------------------------------------------- records


def write_record(path: Path, served: Served, server: Any, *, lock_step: bool) -> None:
    """What acted and what was sent in each period, with the names."""
    import numpy as np

    with path.open("xb") as file:
        np.savez(
            file,
            commands=server.commands(),
            sensors=server.sensors(),
            inputs=np.array([v.name for v in served.inputs]),
            outputs=np.array([v.name for v in served.outputs]),
            units=np.array([v.unit for v in served.outputs]),
            period=served.period,
            lock_step=lock_step,
        )


def read_record(path: Path) -> dict[str, Any]:
    """What `write_record` wrote."""
    import numpy as np

    names = ("commands", "sensors", "inputs", "outputs", "period", "lock_step")
    try:
        with np.load(path, allow_pickle=False) as file:
            return {name: file[name] for name in names}
    except (OSError, ValueError, KeyError, AttributeError, TypeError, zipfile.BadZipFile, EOFError) as error:
        stop(f"{path}: {(str(error) or 'empty').splitlines()[0]}; needed: a file of `rollerrig serve --record`")


def replayed(served: Served, kept: dict[str, Any], path: str) -> str:
    """Run with the commands of a record; the sentence that says whether the sensors are the same, byte for byte."""
    import numpy as np

    from rollerrig.interfaces.realtime.server import replay

    now = {"inputs": [v.name for v in served.inputs], "outputs": [v.name for v in served.outputs]}
    for what, names in now.items():
        if names != kept[what].tolist():
            allowed = "allowed: the case and options of the record"
            stop(f"{path}: {what}: recorded with others than this case has; {allowed}")
    if float(kept["period"]) != served.period:
        stop(f"{path}: recorded at {1.0 / float(kept['period']):g} Hz; allowed: that --rate")
    found, rows = replay(served, kept["commands"]), len(kept["sensors"])
    if found[:rows].tobytes() != kept["sensors"].tobytes():
        unlike = np.flatnonzero((found[:rows] != kept["sensors"]).any(axis=1)) if len(found) >= rows else [len(found)]
        first = unlike[0] if len(unlike) else 0
        stop(f"{path}: not the same run: sensors differ from t = {first * served.period:.4f} s on", LEFT_VALIDITY)
    return f"{path}: {rows - 1} periods, {found.shape[1]} sensors: the same bytes"


def serve(
    case: Annotated[
        str,
        typer.Argument(
            metavar="CASE", help="Case: a name of the catalogue or a TOML file; or a model file, rig.model."
        ),
    ],
    rate: Annotated[str, typer.Option(help="Of commands and sensors.")] = "1 kHz",
    udp: Annotated[
        str | None,
        typer.Option(
            metavar="[ADDRESS:]PORT",
            help="Where to listen; the loopback unless an address is given. Absent: a free port.",
        ),
    ] = None,
    shm: Annotated[
        str | None, typer.Option(metavar="NAME", help="Shared memory of this name, to be made, in place of UDP.")
    ] = None,
    lock_step: Annotated[
        bool,
        typer.Option(
            "--lock-step", help="Wait for the command of each step: no real time, the same run on any machine."
        ),
    ] = False,
    at_once: Annotated[
        bool,
        typer.Option("--at-once", help="Begin without a controller, and go on without one: commands at their start."),
    ] = False,
    external: Annotated[
        str | None,
        typer.Option(help="Tables of the controllers that are outside, with commas; absent: all but rig_control."),
    ] = None,
    outputs: Annotated[
        str,
        typer.Option(
            help="Names of what is sent, with commas, '*' for anything; absent: what those controllers measure."
        ),
    ] = "",
    safe: Annotated[
        str, typer.Option(help="Commands of the safe state, NAME=VALUE with commas; the others are 0.")
    ] = "",
    patience: Annotated[int, typer.Option(min=1, help="Periods without a command until the watchdog acts.")] = 10,
    ramp: Annotated[float, typer.Option(min=0.0, max=60.0, help="From there to the safe state [s].")] = 0.2,
    record: Annotated[
        Path | None, typer.Option(help="File for what acted and what was sent in each period (.npz).")
    ] = None,
    replay: Annotated[
        Path | None,
        typer.Option(help="Run with the commands of such a file, without a network, and compare what is sent."),
    ] = None,
    watch: Annotated[bool, typer.Option("--watch", help="Show deadlines and frames while it runs.")] = False,
    allow_code: AllowCode = False,
) -> None:
    """The rig as a server for a controller in another process or on a test bench, in real time."""
    from rollerrig.interfaces.realtime.server import check_rate, open_server
    from rollerrig.results import output_file

    address, port = address_of(udp, shm, case)
    kept = None if replay is None else read_record(replay)
    served = prepared(
        case,
        rate,
        external=external,
        lock_step=lock_step if kept is None else bool(kept["lock_step"]),
        allow_code=allow_code,
        outputs=names_in(outputs),
        safe=values_of(safe, case),
    )
    if kept is not None:
        typer.echo(replayed(served, kept, str(replay)))
        raise typer.Exit
    if record is not None and output_file(record).exists():
        stop(f"{record}: exists already; allowed: a new file, or remove it first")
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
    for line in opening_lines(served, address, server.port, lock_step=lock_step):
        say(f"rollerrig: {line}")
    ended = run_watched(server, live=watch)
    if record is not None:
        write_record(record, served, server, lock_step=lock_step)
    typer.echo("\n".join(closing_lines(served, server, ended)))
    if ended.ending == "controller_silent":
        stop("in lock-step the run cannot go on without commands", LEFT_VALIDITY)
    raise typer.Exit(exit_code("interrupted" if ended.ending == "stopped_by_caller" else ended.status))
