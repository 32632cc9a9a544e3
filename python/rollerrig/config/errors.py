"""What a mistake in a configuration file looks like to its author.

    TOML text -> [checks] -> ConfigProblem, one per mistake -> ConfigError with all of them

Every problem prints as one line: ``file: key: value written; what is allowed; did you mean ...?``
"""

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from difflib import get_close_matches
from typing import TypeVar

T = TypeVar("T")

_LONGEST_VALUE = 80
MANY = 1000
"""Mistakes of one file that are listed, items of a list that are called by their names, choices that are named."""


@dataclass(frozen=True)
class ConfigProblem:
    """One mistake."""

    file: str  # file (or catalogue entry) as the user named it
    key: str  # dotted key; a list item is addressed by its name (``body.car_body.mass``) or ``[index]``
    value: str  # what was written there, as text; "missing" if nothing was
    allowed: str  # what may stand there
    hint: str = ""  # the nearest allowed value, or "" if none is near

    def __str__(self) -> str:
        """The line shown to the user."""
        place = f"{self.file}: {self.key}" if self.key else self.file
        guess = f"; did you mean '{self.hint}'?" if self.hint else ""
        line = f"{place}: {self.value}; {self.allowed}{guess}"
        return "".join(c if c.isprintable() else repr(c)[1:-1] for c in line)  # one line, no terminal codes

    def shortened(self) -> "ConfigProblem":
        """The same problem with the key as changes name it: without the `data` of vehicle and support."""
        return replace(self, key=re.sub(r"^(vehicle|support)\.data\b\.?", r"\1.", self.key).rstrip("."))

    def within(self, key: str) -> "ConfigProblem":
        """The same problem seen from an enclosing table ``key``."""
        return replace(self, key=join_key(key, self.key))


class ConfigError(Exception):
    """All the mistakes of one configuration.

    Attributes:
        problems: the mistakes in the order of the file.
    """

    def __init__(self, problems: Iterable[ConfigProblem]) -> None:
        self.problems: tuple[ConfigProblem, ...] = tuple(problems)
        super().__init__("\n".join(str(problem) for problem in self.problems))

    @classmethod
    def of(cls, file: str, key: str, value: str, allowed: str, hint: str = "") -> "ConfigError":
        """A single mistake."""
        return cls([ConfigProblem(file, key, value, allowed, hint)])

    def __reduce__(self) -> "tuple[type[ConfigError], tuple[tuple[ConfigProblem, ...]]]":
        """Copy from its problems, on its way back from another process."""
        return type(self), (self.problems,)


def whole(part: T | None, problems: Iterable[ConfigProblem]) -> T:
    """What was read; a ConfigError where there are problems, or nothing was."""
    problems = tuple(problems)
    if problems or part is None:
        raise ConfigError(problems)
    return part


Mistake = tuple[str, str, str] | tuple[str, str, str, str]
"""Key, value, what is allowed, and a hint if there is one, of a ConfigProblem in a file that the check need not know."""


def problems_of(file: str, mistakes: Iterable[Mistake]) -> list[ConfigProblem]:
    """Mistakes of a file, each once."""
    return [ConfigProblem(file, *one) for one in dict.fromkeys(mistakes)]


def join_key(parent: str, key: str) -> str:
    """Dotted key; ``[2]`` follows its list without a dot."""
    if not parent or not key or key.startswith("["):
        return parent + key
    return f"{parent}.{key}"


def show_value(value: object) -> str:
    """The value as a user would recognise it, short enough for one line."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, dict):
        return f"a table with {len(value)} key{'s' if len(value) != 1 else ''}"
    try:
        text = repr(list(value) if isinstance(value, tuple) else value)
    except (ValueError, RecursionError):  # an integer of thousands of digits; lists nested beyond reason
        text = f"a very long {type(value).__name__}"
    if len(text) <= _LONGEST_VALUE:
        return text
    end = _LONGEST_VALUE // 2 if isinstance(value, str) else 0  # where a path has its file
    return f"{text[: _LONGEST_VALUE - 3 - end]}...{text[len(text) - end :]}"


def nearest(word: object, choices: Sequence[str]) -> str:
    """The choice that ``word`` was probably meant to be, in capitals or not, or ""; of very many it is not sought."""
    if not isinstance(word, str) or len(choices) > MANY:
        return ""
    lower = {choice.lower(): choice for choice in reversed(choices)}
    matches = get_close_matches(word.lower(), lower, n=1, cutoff=0.6)
    return lower[matches[0]] if matches else ""


def one_of(choices: Iterable[str]) -> str:
    """'allowed: a, b, c' in the order given; of very many the first."""
    named = list(choices)
    more = [f"... ({len(named) - MANY} more)"] if len(named) > MANY else []
    return "allowed: " + (", ".join(named[:MANY] + more) or "nothing here")
