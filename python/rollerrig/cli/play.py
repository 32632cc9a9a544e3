"""`rollerrig play CASE`."""

from __future__ import annotations

import threading
import webbrowser
from typing import Annotated

import typer

from rollerrig.cli.command import AllowCode, CaseName, Changes, read_case
from rollerrig.cli.termination import say, stop


def command(
    case: CaseName,
    port: Annotated[int, typer.Option(min=0, max=65535, help="Where to listen on the loopback; 0: any free one.")] = 0,
    browser: Annotated[bool, typer.Option(help="Open the page in a browser.")] = True,
    change: Changes = None,
    allow_code: AllowCode = False,
) -> None:
    """Move a simulation that runs in real time: sliders for speed, radius, friction, torque in the browser, until Ctrl-C."""
    from rollerrig.viewer.play import Theatre, server

    theatre = Theatre(read_case(case, allow_code=allow_code, changes=change))
    try:
        listening = server(theatre, port)
    except OSError as error:
        stop(f"--port {port}: {error.strerror or error}; choose another one, or 0 for any free one")
    address = f"http://127.0.0.1:{listening.server_address[1]}/"
    typer.echo(address)
    say("Ctrl-C ends it.")
    threading.Thread(target=listening.serve_forever, daemon=True).start()
    if browser:
        webbrowser.open(address)
    try:
        theatre.play()
    except KeyboardInterrupt:
        theatre.ended = True
        listening.shutdown()
