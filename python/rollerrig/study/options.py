"""A public function as a command: how its arguments are written on the command line, with the meanings of its docstring.

function under @command -> [its head] -> parameters -> rollerrig.cli.study_command -> `rollerrig NAME`
"""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable, Mapping, Sequence
from contextvars import ContextVar
from dataclasses import dataclass, replace
from typing import Annotated, Any, TypeVar, get_args, get_origin, get_type_hints

from rollerrig.analysis import SPEEDS_KMH
from rollerrig.study import heads

F = TypeVar("F", bound=Callable[..., Any])

RUNNER: ContextVar[Callable[..., Any] | None] = ContextVar("RUNNER", default=None)
"""What the command line does with a study: it writes the outcome into a folder."""

UNITS = {"": ("", 1.0), "mm": ("m", 1e-3), "bar": ("Pa", 1e5), "kN m": ("N m", 1e3)}
"""Unit of an option -> that of the argument, and the first in terms of the second."""


@dataclass(frozen=True)
class Option:
    """How an option differs from the argument.

    Attributes:
        name: of the parameter; that of the argument if none is given.
        unit: of UNITS.
        least, most: range.
        default: its default.
        commas: whether one text holds its values; else it is repeated.
        ordered: whether its numbers are put in ascending order.
        meaning: its own, where that of the argument does not fit.
    """

    name: str = ""
    unit: str = ""
    least: float | None = None
    most: float | None = None
    default: Any = None
    commas: bool = False
    ordered: bool = False
    meaning: str = ""

    @property
    def flag(self) -> str:
        """As it is written on the command line."""
        return "--set" if self.name == "change" else f"--{self.name.replace('_', '-').lower()}"


HIDDEN = ("progress", "folder", "parameters")
"""Arguments that the command line has otherwise."""

Processes = Annotated[int, Option(least=1, most=64, default=2, meaning="runs at a time.")]
OneProcess = Annotated[int, Option(least=1, most=64, meaning="runs at a time.")]

NAMES = {"Annotated": Annotated, "Mapping": Mapping, "Sequence": Sequence, "Option": Option, "Processes": Processes,
         "OneProcess": OneProcess, "SPEEDS_KMH": SPEEDS_KMH}  # fmt: skip
"""What defaults, and types in Annotated, of a command's function may name: its head is read without the imports of its module."""


@dataclass(frozen=True)
class Parameter:
    """An argument of a function.

    Attributes:
        name: of the argument.
        kind: its type as written.
        default: of the argument; `inspect.Parameter.empty`: none.
        options: one, or several whose values it has as a tuple; none: it stands without a name.
        meaning: in the docstring.
    """

    name: str
    kind: str
    default: Any
    options: tuple[Option, ...]
    meaning: str


def command(function: F) -> F:
    """Make a function a command, which bears its name; its annotations are plain types from here on.

    Errors under `Raises` of its docstring are mistakes of the user: the command ends with their message.
    """
    function.__annotations__ = get_type_hints(function)
    return function


def head(name: str) -> Callable[..., Any]:
    """The function of a command without its body."""
    module, text = heads()[name]
    names: dict[str, Any] = dict(NAMES)
    # an error in it names the module; python -OO, too, keeps its docstring
    exec(compile(f"from __future__ import annotations\n{text}", module, "exec", optimize=0), names)
    found: Callable[..., Any] = names[name]
    return found


def parameters(function: Callable[..., Any]) -> list[Parameter]:
    """The arguments of a function that the command line has."""
    names, found = function.__globals__, []
    meanings = dict(re.findall(r"^ {4}(\w+): ((?:.|\n {5,})+)$", inspect.getdoc(function) or "", re.MULTILINE))
    for name, one in inspect.signature(function).parameters.items():
        if name in HIDDEN or one.kind is inspect.Parameter.VAR_KEYWORD:
            continue
        kind = str(one.annotation)
        declared = eval(kind, names) if kind.startswith("Annotated[") else names.get(kind)
        options = [] if one.default is inspect.Parameter.empty else [Option()]
        if get_origin(declared) is Annotated:
            plain, *options = get_args(declared)
            kind = plain.__name__ if isinstance(plain, type) else str(plain).replace("collections.abc.", "")
        own = tuple(replace(option, name=option.name or name) for option in options)
        found.append(Parameter(name, kind, one.default, own, " ".join(meanings[name].split())))
    return found


def summary(function: Callable[..., Any]) -> str:
    """The docstring before its sections."""
    return re.split(r"\n\n(?=\w+:\n)", inspect.getdoc(function) or "")[0]


def errors(function: Callable[..., Any]) -> set[str]:
    """Names of the errors in the docstring."""
    section = (inspect.getdoc(function) or "").partition("Raises:\n")[2].partition("\n\n")[0]
    return {name for names in re.findall(r"^ {4}([\w, ]+):", section, re.MULTILINE) for name in names.split(", ")}
