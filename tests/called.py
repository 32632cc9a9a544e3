"""Commands of the program, called in this process."""

from __future__ import annotations

from typer.testing import CliRunner, Result

from rollerrig.cli.app import build_app


def called(*words: object) -> Result:
    """How a command ended, what it printed; an error that no user should see is raised."""
    result = CliRunner().invoke(build_app(), [str(word) for word in words])
    if result.exception is not None and not isinstance(result.exception, SystemExit):
        raise result.exception
    return result


def call(*words: object) -> tuple[int, str]:
    """Exit code, and all that was printed."""
    result = called(*words)
    return result.exit_code, result.stdout + result.stderr
