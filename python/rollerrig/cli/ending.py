"""How a command ends: exit codes, and mistakes of the user as one line each instead of a traceback."""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import NoReturn, ParamSpec, TypeVar

import typer

OK = 0
BAD_INPUT = 2
LEFT_VALIDITY = 3
INTERRUPTED = 130

P = ParamSpec("P")
R = TypeVar("R")


def say(line: str) -> None:
    """A line for the user beside the results: to stderr."""
    typer.echo(line, err=True)


def stop(message: object, code: int = BAD_INPUT) -> NoReturn:
    """End the command with a message on stderr."""
    for line in str(message).splitlines():
        say(f"rollerrig: {line}")
    raise typer.Exit(code)


def exit_code(status: str) -> int:
    """The exit code for the status of a run."""
    return {"ok": OK, "interrupted": INTERRUPTED}.get(status, LEFT_VALIDITY)


def readable_errors(command: Callable[P, R]) -> Callable[P, R]:
    """Bad input ends the command with its message and exit code 2, Ctrl-C with 130."""

    @functools.wraps(command)
    def wrapped(*arguments: P.args, **options: P.kwargs) -> R:
        from rollerrig.config import ConfigError
        from rollerrig.results import OutputError
        from rollerrig.start import StartError

        try:
            return command(*arguments, **options)
        except (ConfigError, OutputError, StartError) as error:
            stop(error)
        except MemoryError:
            stop("not enough memory; raise time.output_step or shorten the run")
        except KeyboardInterrupt:
            stop("interrupted", INTERRUPTED)

    return wrapped
