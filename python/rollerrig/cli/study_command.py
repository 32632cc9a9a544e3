"""The command of a public function: `rollerrig adhesion CASE --out DIR` and its like.

head of a function of a study -> [study_command] -> typer command with the options that all share -> files, summary
"""

from __future__ import annotations

import inspect
import json
from collections.abc import Callable, Iterator
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from rollerrig.cli.command import AllowCode, Changes, Force, Out, carry_out, changes_of, code_lines, read_case
from rollerrig.cli.ranges import check_finite, read_range, read_speeds
from rollerrig.cli.termination import say
from rollerrig.study import heads
from rollerrig.study.options import RUNNER, UNITS, Option, Parameter, errors, head, parameters, summary

if TYPE_CHECKING:
    from rollerrig.study.frame import Study

Given = dict[str, Any]


def study_command(name: str) -> Callable[..., None]:
    """The command of a function of `rollerrig.study.heads`, which is loaded when the command runs."""
    declared = head(name)
    arguments = parameters(declared)
    first, others = ([one for one in arguments if bool(one.options) == named] for named in (False, True))
    of_case = bool(first) and first[0].kind == "Case | str"
    found = [*map(_argument, first), _parameter("out", Out), *(option for one in others for option in _options(one))]
    shared = [("change", Changes, None), ("allow_code", AllowCode, False)] if of_case else []
    own = {parameter.name for parameter in found}
    found += [_parameter(*one) for one in (*shared, ("force", Force, False)) if one[0] not in own]

    def command(**given: Any) -> None:
        values = {one.name: given[one.name] for one in first} | {one.name: _value(one, given) for one in others}
        label = given[first[0].name] if first else name
        for one in arguments:
            if one.kind.startswith("Case | str") and values[one.name] is not None:
                changes = given["change"] if one is first[0] and "changes" not in values else None
                values[one.name] = read_case(values[one.name], allow_code=given["allow_code"], changes=changes)

        def runner(study: Study[Any], processes: int) -> None:
            from rollerrig.config import code_of

            lines = (line for case in study.cases().values() for line in code_lines(code_of(case)))
            for line in () if of_case else dict.fromkeys(lines):
                say(f"rollerrig: {label}: {line}")
            carry_out(study, given["out"], processes, force=given["force"])

        token = RUNNER.set(runner)
        try:
            getattr(import_module(f"rollerrig.{heads()[name][0]}"), name)(**values)
        finally:
            RUNNER.reset(token)

    command.mistakes = errors(declared)  # type: ignore[attr-defined]
    command.__name__, command.__doc__ = name, summary(declared) + cost(name)
    command.__annotations__ = {one.name: one.annotation for one in found}
    command.__signature__ = inspect.Signature(found)  # type: ignore[attr-defined]
    return command


@cache
def costs() -> dict[str, dict[str, Any]]:
    """What commands cost, as benchmarks/commands.py measured it: name -> example, processor_s."""
    found: dict[str, dict[str, Any]] = json.loads(Path(__file__).with_name("costs.json").read_text(encoding="utf-8"))
    return found


def cost(name: str) -> str:
    """A paragraph for the help of a command: what its example took, "" where it was not measured."""
    if name not in costs():
        return ""
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


def _argument(one: Parameter) -> inspect.Parameter:
    """An argument that stands without a name, as typer takes it."""
    info = typer.Argument(metavar=one.name.upper(), help=_text(one.meaning))
    return _parameter(one.name, Annotated[ARGUMENTS.get(one.kind, str), info])


def _options(one: Parameter) -> Iterator[inspect.Parameter]:
    """The options of an argument, as typer takes them."""
    for place, option in enumerate(one.options):
        default = one.default
        kind: Any = str if option.commas else FORMS.get(one.kind, str)
        if len(one.options) > 1 and default is not None:
            default = default[place]
        default = _shown(default if option.default is None else option.default, option)
        if default is None or default == []:
            kind, default = kind | None, None
        meaning = option.meaning or one.meaning + _form(one.kind, option)
        meaning = meaning.replace(f"[{UNITS[option.unit][0]}]", f"[{option.unit}]").replace("None: ", "absent: ")
        spelt = () if default is True else (option.flag,)  # what is off by default has no `--no-` beside it
        info = typer.Option(*spelt, help=_text(meaning), min=option.least, max=option.most)
        yield _parameter(option.name, Annotated[kind, info], default)


def _form(kind: str, option: Option) -> str:
    """How an option with several values is written, as the end of its meaning."""
    if option.commas:
        return " Several with commas."
    forms = {"Sequence[float]": "As start:stop:step, or as a list with commas.", "Sequence[str]": "Again for more.",
             "Mapping": "As KEY=VALUE like in a TOML file; again for more."}  # fmt: skip
    return next((f" {form}" for start, form in forms.items() if kind.startswith(start)), "")


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
    values = {option.name: _read(one, option, given[option.name]) for option in one.options}
    if len(values) > 1:
        return tuple(values.values())
    (value,) = values.values()
    default = one.options[0].default if one.default is inspect.Parameter.empty else one.default
    return default if value is None else value


def _read(one: Parameter, option: Option, value: Any) -> Any:
    """What an option says, in SI; None where it is absent."""
    flag, factor = option.flag, UNITS[option.unit][1]
    if value is None or isinstance(value, bool | int):
        return value
    if isinstance(value, float):
        check_finite(value, flag)
        return factor * value
    if isinstance(value, list):
        return changes_of(value, flag) if one.kind.startswith("Mapping") else tuple(value)
    if option.commas:
        return tuple(text.strip() for text in value.split(","))
    if not one.kind.startswith("Sequence[float]"):
        return value
    numbers = read_speeds(value) if option.name == "speeds_kmh" else read_range(value, flag)
    least, most = option.least, option.most
    if least is not None and most is not None and not least <= min(numbers) <= max(numbers) <= most:
        allowed = f"numbers must lie between {least:g} and {most:g}"
        raise typer.BadParameter(f"'{value}': {allowed}", param_hint=flag)
    return tuple(factor * number for number in (sorted(numbers) if option.ordered else numbers))
