"""The command of a public function: `rollerrig adhesion CASE --out DIR` and its like.

function of rollerrig.cli.commands -> [study_command] -> typer command with the options that all share -> files, summary
"""

from __future__ import annotations

import inspect
import json
from collections.abc import Callable, Iterator, Mapping
from functools import cache, partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from rollerrig.cli import commands
from rollerrig.cli.command import AllowCode, Changes, Force, Out, carry_out, changes_of, code_lines, read_case
from rollerrig.cli.ranges import check_finite, read_range, read_speeds
from rollerrig.cli.termination import say, stop
from rollerrig.study.options import UNITS, Option, Parameter, summary

if TYPE_CHECKING:
    from rollerrig.study.frame import Study

Given = dict[str, Any]
Runner = Callable[..., None]


def study_command(
    function: Callable[..., Any],
    *,
    prepare: Callable[[Given], None] = lambda _given: None,
    refused: tuple[type[Exception], ...] = (),
    switches: Mapping[str, tuple[Any, Any, str]] | None = None,
    run: Callable[[Given], Runner] = lambda given: partial(carry_out, force=given["force"]),
    text: str = "",
) -> Callable[..., None]:
    """The command of a function of `rollerrig.cli.commands`.

    Args:
        function: the function.
        prepare: refuses what the options say together, or completes them.
        refused: errors of the function that are the user's.
        switches: parameters that the function does not have: name -> annotation, default, parameter before which it stands.
        run: what is given -> what is done with the study.
        text: of the help, if not that of the function.
    """
    declared = commands.STUDIES[function.__name__]
    first, others = ([one for one in declared if bool(one.options) == named] for named in (False, True))
    of_case = bool(first) and first[0].kind == "Case | str"
    own = [parameter for one in others for parameter in _options(one)]
    for key, (annotation, default, before) in (switches or {}).items():
        own.insert([one.name for one in own].index(before), _parameter(key, annotation, default))
    shared = [("change", Changes, None), ("allow_code", AllowCode, False)] if of_case else []
    last = [one for one in (*shared, ("force", Force, False)) if one[0] not in {parameter.name for parameter in own}]
    named = [
        _parameter(
            one.name,
            Annotated[ARGUMENTS.get(one.kind, str), typer.Argument(metavar=one.name.upper(), help=_text(one.meaning))],
        )
        for one in first
    ]
    found = [*named, _parameter("out", Out), *own, *(_parameter(*one) for one in last)]

    def command(**given: Any) -> None:
        prepare(given)
        arguments = {one.name: given[one.name] for one in first} | {one.name: _value(one, given) for one in others}
        label = given[first[0].name] if first else function.__name__
        if of_case:
            changes = None if "changes" in arguments else given["change"]
            arguments["case"] = read_case(label, allow_code=given["allow_code"], changes=changes)

        def runner(study: Study[Any], processes: int) -> None:
            from rollerrig.config import code_of

            lines = (line for case in study.cases().values() for line in code_lines(code_of(case)))
            for line in () if of_case else dict.fromkeys(lines):
                say(f"rollerrig: {label}: {line}")
            run(given)(study, given["out"], processes)

        token = commands.RUNNER.set(runner)
        try:
            function(**arguments)
        except typer.Exit:  # a RuntimeError
            raise
        except refused as error:
            stop(error)
        finally:
            commands.RUNNER.reset(token)

    command.__name__, command.__doc__ = function.__name__, (text or summary(function)) + cost(function.__name__)
    command.__annotations__ = {one.name: one.annotation for one in found}
    command.__signature__ = inspect.Signature(found)  # type: ignore[attr-defined]
    return command


@cache
def costs() -> dict[str, dict[str, Any]]:
    """What commands cost, as benchmarks/commands.py measured it: name -> example, processor_s."""
    found: dict[str, dict[str, Any]] = json.loads(Path(__file__).with_name("costs.json").read_text(encoding="utf-8"))
    return found


def cost(name: str) -> str:
    """A paragraph for the help of a command: what its example took."""
    one = costs()[name]
    took = f"{one['processor_s']:.0f} s" if one["processor_s"] < 100.0 else f"{one['processor_s'] / 60.0:.0f} min"
    return f"\n\nCost: 'rollerrig {one['example']}' takes {took} of processor time (docs/performance.md)."


def _parameter(name: str, annotation: Any, default: Any = inspect.Parameter.empty) -> inspect.Parameter:
    return inspect.Parameter(name, inspect.Parameter.POSITIONAL_OR_KEYWORD, default=default, annotation=annotation)


def _text(meaning: str) -> str:
    return meaning[0].upper() + meaning[1:]


FORMS = {"bool": bool, "int": int, "float": float, "float | None": float, "tuple[float, float]": float,
         "Sequence[str]": list[str], "Mapping[str, object] | None": list[str]}  # fmt: skip
"""Type of an argument -> of its options, where that is no text."""
ARGUMENTS: dict[str, Any] = {"Sequence[str | Path | Mapping[str, Any]]": list[str]}
"""Type of an argument without a name -> on the command line, where it is not one text."""


def _options(one: Parameter) -> Iterator[inspect.Parameter]:
    """The options of an argument, as typer takes them."""
    for place, option in enumerate(one.options):
        name, default = option.name or one.name, one.default
        kind: Any = str if option.quantity or option.commas else FORMS.get(one.kind, str)
        if len(one.options) > 1 and default is not None:
            default = default[place]
        default = _shown(default if option.default is None else option.default, option)
        if default is None or default == []:
            kind, default = kind | None, None
        meaning = (option.meaning or one.meaning).replace(f"[{UNITS[option.unit][0]}]", f"[{option.unit}]")
        flag = f"--{name.replace('_', '-').lower()}"
        # what is off by default has no `--no-` beside it
        spelt = ("--set",) if name == "change" else (flag,) * (default is False or name != name.lower())
        info = typer.Option(*spelt, help=_text(meaning), min=option.least, max=option.most)
        yield _parameter(name, Annotated[kind, info], default)


def _shown(value: Any, option: Option) -> Any:
    """A default as the command line shows it: numbers in the option's unit, even steps as start:stop:step."""
    if isinstance(value, float):
        return float(f"{value / UNITS[option.unit][1]:.12g}")
    if not isinstance(value, tuple):
        return value
    if all(isinstance(one, str) for one in value):
        return (",".join(value) or None) if option.commas else list(value)
    texts = [f"{one / UNITS[option.unit][1]:.12g}" for one in value]
    steps = {f"{(b - a) / UNITS[option.unit][1]:.9g}" for a, b in zip(value, value[1:], strict=False)}
    return f"{texts[0]}:{texts[-1]}:{steps.pop()}" if len(steps) == 1 and len(texts) > 3 else ",".join(texts)


def _value(one: Parameter, given: Given) -> Any:
    """The value of an argument from its options."""
    values = {name: _read(one, name, option, given[name])
              for option in one.options for name in (option.name or one.name,)}  # fmt: skip
    if len(values) > 1:
        return tuple(values.values()) if one.kind.startswith("tuple") else values
    (value,) = values.values()
    default = one.options[0].default if one.default is inspect.Parameter.empty else one.default
    return default if value is None else value


def _read(one: Parameter, name: str, option: Option, value: Any) -> Any:
    """What an option says, in SI; None where it is absent."""
    flag, factor = "--set" if name == "change" else f"--{name.replace('_', '-')}", UNITS[option.unit][1]
    if value is None or isinstance(value, bool | int):
        return value
    if isinstance(value, float):
        check_finite(value, flag)
        return factor * value
    if isinstance(value, list):
        return changes_of(value, flag) if one.kind.startswith("Mapping") else tuple(value)
    if option.quantity is not None:
        return _length(value, flag, *option.quantity)
    if option.commas:
        return tuple(text.strip() for text in value.split(","))
    if not one.kind.startswith("Sequence[float]"):
        return value
    numbers = read_speeds(value) if name == "speeds_kmh" else read_range(value, flag)
    if (
        option.least is not None
        and option.most is not None
        and not option.least <= min(numbers) <= max(numbers) <= option.most
    ):
        allowed = f"numbers must lie between {option.least:g} and {option.most:g}"
        raise typer.BadParameter(f"'{value}': {allowed}", param_hint=flag)
    return tuple(factor * number for number in (sorted(numbers) if option.ordered else numbers))


def _length(text: str, option: str, table: str, key: str) -> float:
    """A length with its unit, in metres, in the range of a key of the configuration."""
    from rollerrig import config
    from rollerrig.config.schema.base import quantity_of

    field = getattr(config, table).model_fields[key]
    quantity = quantity_of(field.annotation, field.metadata)
    assert quantity is not None
    try:
        return quantity.parse(text)
    except ValueError:
        needed = f"write it with its unit, like 460mm, from {quantity.least:g} to {quantity.most:g} m"
        raise typer.BadParameter(f"'{text}': {needed}", param_hint=option) from None


# ---------------------------------------------------------------------------------------- what is one command's alone


def check_conicity(given: Given) -> None:
    """Refuse amplitudes beyond the shift.

    Raises:
        typer.BadParameter: there are some.
    """
    amplitudes, shift = read_range(given["amplitudes_mm"], "--amplitudes-mm"), given["shift_mm"]
    if min(amplitudes) <= 0 or max(amplitudes) > shift:
        allowed = f"amplitudes must lie above 0 and up to --shift-mm, {shift:g}"
        raise typer.BadParameter(f"'{given['amplitudes_mm']}': {allowed}", param_hint="--amplitudes-mm")


def check_compare(given: Given) -> None:
    """Refuse supports named twice.

    Raises:
        typer.BadParameter: one is, or has no name.
    """
    names = [name.strip() for name in given["on"].split(",")]
    if not all(names) or len({Path(name).name.removesuffix(".toml") for name in names}) < len(names):
        raise typer.BadParameter(f"'{given['on']}': name each support once, like rig,track", param_hint="--on")


def prepare_wsp(given: Given) -> None:
    """Read the second case behind the same gate of code as the first."""
    if given["against"] is not None:
        given["against"] = read_case(given["against"], allow_code=given["allow_code"])


def prepare_scale(given: Given) -> None:
    """Leave the error budget out where nothing is run."""
    given["error_budget"] = given["run"] and given["error_budget"]


def run_scale(given: Given) -> Runner:
    """Run the test at both scales, or write the scaled case alone."""

    def write_case(study: Any, out: Path, _processes: int) -> None:
        from rollerrig.config.write.toml import to_short_toml
        from rollerrig.results import ResultFolder, check_folder
        from rollerrig.similitude import requirements
        from rollerrig.study.scale import CASE_FILE, model_summary

        check_folder(out, study.command, (CASE_FILE,), force=given["force"])
        with ResultFolder(out, study.command, {study.model.name: study.model}, force=given["force"]) as folder:
            typer.echo(folder.add(CASE_FILE, to_short_toml(study.model).encode()))
            folder.commit()
        say("\n".join(model_summary(study.model, requirements(study.full, study.model))))
        raise typer.Exit

    return partial(carry_out, force=given["force"]) if given["run"] else write_case


RUN = Annotated[
    bool, typer.Option("--run", help="Also run the test at full scale and on the model, mapped back: report.html.")
]
SPECIAL: dict[str, dict[str, Any]] = {
    "conicity": {"prepare": check_conicity, "refused": (ValueError,)},
    "creep": {"refused": (ValueError, RuntimeError)},
    "compare": {"prepare": check_compare},
    "wsp": {"prepare": prepare_wsp},
    "fit": {"refused": (ValueError, RuntimeError)},
    "reconstruct": {"refused": (ValueError,)},
    "replay": {"refused": (ValueError,)},
    "scale": {
        "prepare": prepare_scale,
        "switches": {"run": (RUN, False, "error_budget")},
        "run": run_scale,
        "text": "A scaled rig by similitude: case.toml, to be run like any other, and what it violates.",
    },
}
"""Command -> arguments of `study_command`."""
