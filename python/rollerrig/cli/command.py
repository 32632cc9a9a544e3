"""What the commands share: their usual options, and how a study is run."""

from __future__ import annotations

import tomllib
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, NoReturn

import typer

from rollerrig.cli.progress import interrupts_noted, progress_bar
from rollerrig.cli.termination import INTERRUPTED, OK, exit_code, say, stop

if TYPE_CHECKING:
    from collections.abc import Iterable
    from concurrent.futures import Executor

    from rollerrig.config import Case, Code

CaseName = Annotated[str, typer.Argument(metavar="CASE", help="Case: a name of the catalogue or a TOML file.")]
Out = Annotated[Path, typer.Option(help="Folder for the results; made if it does not exist.")]
Force = Annotated[
    bool,
    typer.Option(
        "--force", help="Replace files that this command did not write: of other commands, of other programs, yours."
    ),
]
AllowCode = Annotated[
    bool,
    typer.Option("--allow-code", help="Also take controllers from outside the folder of the case that names them."),
]
Changes = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        metavar="KEY=VALUE",
        help="Another value for a key of the case, as in a TOML file; repeatable. "
        "'vehicle.element.primary_*.x.stiffness=30 MN/m' changes all that match.",
    ),
]


def read_case(name: str, *, allow_code: bool, changes: list[str] | None = None) -> Case:
    """The case with what `--set` changes of it, and a line to the user for every piece of code that it brings."""
    from rollerrig.config import code_of, load_case

    case = load_case(name, allow_code=allow_code)
    if changes:
        case = case.with_changes(changes_of(changes))
    for line in code_lines(code_of(case)):
        say(f"rollerrig: {name}: {line}")
    return case


def changes_of(texts: list[str] | None, flag: str = "--set") -> dict[str, Any]:
    """Key -> value of `KEY=VALUE` texts. A value is one of TOML; what is none and holds no quote or bracket is a text.

    Raises:
        typer.BadParameter: a text is not of that form.
    """
    changes: dict[str, Any] = {}
    for text in texts or []:
        key, equals, value = text.partition("=")
        key, value = key.strip(), value.strip()
        try:
            changes[key] = tomllib.loads(f"value = {value}")["value"]
        except (tomllib.TOMLDecodeError, ValueError, RecursionError):
            equals = "" if not value or set(value) & set("\"'[]{}=\n") else equals
            changes[key] = value
        if not equals or not key:
            raise typer.BadParameter(
                f"'{text}': allowed: KEY=VALUE with a value of TOML, e.g. brake.by_traction_motors=true or "
                "'motion.speed=120 km/h'",
                param_hint=flag,
            )
    return changes


def picture_kind(path: Path, option: str = "--out") -> Literal["svg", "png", "pdf"]:
    """The kind of picture that a file's name asks for.

    Raises:
        typer.BadParameter: it asks for another one.
    """
    kinds: dict[str, Literal["svg", "png", "pdf"]] = {".svg": "svg", ".png": "png", ".pdf": "pdf"}
    kind = kinds.get(path.suffix.lower())
    if kind is None:
        raise typer.BadParameter(f"'{path}': allowed: a file that ends in .svg, .png or .pdf", param_hint=option)
    return kind


def code_lines(codes: Iterable[Code]) -> list[str]:
    """Code that runs with a case or plan, a line each."""
    return [
        f"{code.key}: brings code: {'' if code.is_file else 'module '}{code.source}"
        + ("" if code.is_fmu else f", class {code.name}")
        for code in codes
    ]


def carry_out(
    study: Any,
    out: Path,
    processes: int = 1,
    *,
    force: bool = False,
    executor: Executor | None = None,
) -> NoReturn:
    """Run a study, write what it found and print its summary; the exit code says how its runs ended.

    Args:
        study: a `rollerrig.study.frame.Study`.
        out: folder for the results.
        processes: jobs at a time.
        force: whether files that the command did not write may be replaced in the folder.
        executor: that does the jobs in place of processes of this machine.
    """
    from rollerrig.common.formatting import number
    from rollerrig.results import locked
    from rollerrig.study.frame import REPORT

    def first_results(found: Any) -> None:
        page = next(path for path in found.write(out, force=force) if path.name == REPORT)
        if not shown:
            say(f"first results: {page}")
        shown.append(page)

    made, shown = not out.exists(), list[Path]()
    with interrupts_noted() as interrupts:
        try:
            with locked(out):
                with progress_bar(study.command, interrupts) as progress:
                    outcome = study.run(
                        folder=out,
                        force=force,
                        processes=processes,
                        progress=progress,
                        executor=executor,
                        first_results=first_results,
                    )
                written = [] if outcome is None else outcome.write(out, force=force)
        except Exception:
            if made:
                with suppress(OSError):  # there is something in it
                    out.rmdir()
            raise
    if outcome is None:
        stop("interrupted; finished jobs are kept: the same command continues", INTERRUPTED)
    for path in written:
        if path.parent == out:
            typer.echo(path)
    say(outcome.summary)
    for what, times in outcome.study.timings(outcome.results).items():
        say(f"{what}, as measured now: {', '.join(f'{name} {number(value, 3)}' for name, value in times.items())}")
    if outcome.interrupted and study.resumable:
        say("Finished jobs are kept: the same command continues.")
    ended = max((exit_code(status) for status in outcome.statuses), default=OK)
    raise typer.Exit(INTERRUPTED if interrupts.times else ended)
