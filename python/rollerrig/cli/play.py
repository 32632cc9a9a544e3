"""`rollerrig play CASE`."""

from __future__ import annotations

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
    """Move a simulation that runs in real time: sliders for speed, radius, friction, torque, gains; until Ctrl-C."""
    from rollerrig.viewer.play import play

    def tell(address: str) -> None:
        typer.echo(address)
        say("Ctrl-C ends it.")

    try:
        play(read_case(case, allow_code=allow_code, changes=change), port=port, browser=browser, tell=tell)
    except OSError as error:
        stop(f"--port {port}: {error.strerror or error}; choose another one, or 0 for any free one")
