"""How a command ends: exit codes, and mistakes of the user as one line each instead of a traceback."""

import functools
import shutil
import sys
import textwrap
import tomllib
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import NoReturn, ParamSpec, TypeVar

import typer

OK = 0
CLOSED = 1
BAD_INPUT = 2
LEFT_VALIDITY = 3
INTERRUPTED = 130

MISTAKES = {
    "ClusterError", "ConfigError", "ExportError", "FileNotFoundError", "ModelFileError", "OutputError", "ProfileError",
    "ResultsError", "StartError", "WorkerError",
}  # fmt: skip
"""Errors whose message is for the user, by name: no command loads a module for those of others. A command may have more."""

P = ParamSpec("P")
R = TypeVar("R")


def say(line: str) -> None:
    """A line for the user beside the results: to stderr, folded between words where a terminal shows it."""
    typer.echo(folded(line, shutil.get_terminal_size().columns) if sys.stderr.isatty() else line, err=True)


def folded(text: str, width: int) -> str:
    """Text whose lines are at most so many letters wide, no word broken; what continues a line is set in."""
    lines = (textwrap.wrap(line, max(width, 20), subsequent_indent="  ", break_long_words=False, break_on_hyphens=False)
             for line in text.split("\n"))  # fmt: skip
    return "\n".join("\n".join(parts) for parts in lines)


def stop(message: object, code: int = BAD_INPUT) -> NoReturn:
    """End the command with a message on stderr."""
    for line in str(message).splitlines():
        say(f"rollerrig: {line}")
    raise typer.Exit(code)


def exit_code(status: str) -> int:
    """The exit code for the status of a run."""
    return {"ok": OK, "stopped": OK, "interrupted": INTERRUPTED}.get(status, LEFT_VALIDITY)


def _name_in(path: Path, depth: int = 8) -> str:
    """The name of the case in a file, which is that of its base where it has none: of the catalogue, or of another file."""
    from rollerrig.common.input_files import LARGEST_TEXT, read_input

    raw = tomllib.loads(read_input(path, LARGEST_TEXT).decode("utf-8"))
    base = str(raw.get("base", ""))
    if "name" in raw or not base.endswith(".toml") or not depth:
        return str(raw.get("name", base))
    return _name_in(path.parent / base, depth - 1)


def _with_file(message: str, options: Mapping[str, object]) -> str:
    """The message with the user's file in place of the name of the case in it: what is found late knows only the name."""
    source = str(options.get("case") or options.get("file") or "")
    try:
        name = _name_in(Path(source))
    except (OSError, ValueError, RecursionError):
        return message
    return "\n".join(
        f"{source}: {line.removeprefix(f'{name}: ')}" if line.startswith(f"{name}: ") else line
        for line in message.splitlines()
    )


def readable_errors(command: Callable[P, R]) -> Callable[P, R]:
    """Bad input ends the command with its message and exit code 2, Ctrl-C with 130."""

    @functools.wraps(command)
    def wrapped(*arguments: P.args, **options: P.kwargs) -> R:
        try:
            return command(*arguments, **options)
        except MemoryError:
            stop("not enough memory; raise time.output_step or shorten the run")
        except KeyboardInterrupt:
            stop("interrupted", INTERRUPTED)
        except typer.Exit:  # a RuntimeError
            raise
        except Exception as error:
            if not (MISTAKES | getattr(command, "mistakes", set())) & {one.__name__ for one in type(error).__mro__}:
                raise
            stop(_with_file(str(error), options))

    return wrapped
