"""The commands and where each of them stands."""

import typer

from rollerrig import __version__
from rollerrig.cli import cases, interfaces, runs
from rollerrig.cli.study_command import study_command
from rollerrig.cli.termination import readable_errors
from rollerrig.study import heads

OTHERS = {name: getattr(module, name) for module in (runs, interfaces, cases) for name in module.__all__}
COMMANDS = (*heads(), *OTHERS)

HELP = """A roller rig for railway bogies, in software.

CASE is the name of a case in the catalogue (rollerrig catalog) or a TOML file. Exit codes: 0 done, 1 output closed, 2 bad input,
3 the run left the model's validity (results up to there are kept), 130 interrupted (results up to there are kept)."""


def print_version(wanted: bool) -> None:
    """Print the version and end."""
    if wanted:
        typer.echo(__version__)
        raise typer.Exit


def build_app() -> typer.Typer:
    """The application with all its commands."""
    app = typer.Typer(
        help=HELP, rich_markup_mode=None, no_args_is_help=True, add_completion=False, pretty_exceptions_enable=False
    )

    @app.callback()
    def common(
        version: bool = typer.Option(
            False, "--version", help="Print the version and exit.", is_eager=True, callback=print_version
        ),
    ) -> None:
        pass

    for name in COMMANDS:
        word = name.replace("_", "-")
        command = OTHERS.get(name) or study_command(name)
        if isinstance(command, typer.Typer):
            app.add_typer(command, name=word)
            continue
        whole = (command.__doc__ or "").strip().partition("\n")[0]  # the list of commands would cut it off
        app.command(word, short_help=whole)(readable_errors(command))
    return app
