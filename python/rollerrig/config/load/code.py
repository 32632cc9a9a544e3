"""Code that a case brings: controllers of the user's own and FMUs, named by the case and run with it.

raw tables + the folder of their file -> [place_code] -> absolute paths, and a problem per piece of code from elsewhere
changes of a case by another file -> [check_new_code] -> the code that they bring, and a problem per piece from elsewhere

A case may come from a stranger. What it brings in its own folder came with it and is named before it is run; a file elsewhere,
also one that a link leads to, or an installed module runs only where the user says so.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any

from rollerrig.config.errors import ConfigProblem
from rollerrig.config.load.change import leaves, parts_of, value_in
from rollerrig.config.load.resolve import relative_to
from rollerrig.config.schema.case import CaseTables


@dataclass(frozen=True)
class Code:
    """Code that a case names."""

    key: str  # where it names it
    source: str  # path of a Python file or of an FMU, or name of a module
    name: str  # of the class in it; empty: an FMU

    @property
    def is_file(self) -> bool:
        """Whether the source is a file rather than a module."""
        return self.is_fmu or self.source.endswith(".py")

    @property
    def is_fmu(self) -> bool:
        """Whether it is a Functional Mock-up Unit, not Python."""
        return self.key.endswith(".fmu")


def code_of(case: CaseTables) -> tuple[Code, ...]:
    """All code that runs with a case, in the order of its tables."""
    tables = {key: getattr(case, key) for key in type(case).model_fields}
    named = {f"{key}.user": getattr(table, "user", None) for key, table in tables.items()}
    named |= {f"{key}.fmu": getattr(getattr(table, "fmu", None), "file", None) for key, table in tables.items()}
    return _code_in(named)


def check_new_code(
    changes: Mapping[str, object], file: str, at: str, own_folder: Path | None, *, allow: bool
) -> tuple[tuple[Code, ...], list[ConfigProblem]]:
    """Code that changes of a case bring, whatever else they say, and a problem for each piece that may not run.

    Values are absolute paths; code may lie in the file's own folder, if it has one, and elsewhere where `allow` says so.
    """
    found = _code_in(dict(leaves(changes)))
    foreign = [] if allow else _foreign(found, own_folder)
    return found, [_elsewhere(file, f"{at}.", code, own_folder) for code in foreign]


def place_code(
    raw: dict[str, Any], file: str, folder: Path, own_folder: Path | None, *, allow: bool
) -> list[ConfigProblem]:
    """Make paths of code in the tables of a case absolute, in place; a problem for each piece of code that may not run.

    Relative paths start at `folder`; `own_folder` is that of the case, None: it has none.
    """
    tables = {key: table for key, table in raw.items() if isinstance(table, Mapping)}
    named = {key: {one: table[one] for one in ("user", "fmu") if one in table} for key, table in tables.items()}
    found = {key: relative_to(folder, key, value) for key, value in leaves(named) if _code_in({key: value})}
    for key, value in found.items():
        *path, last = key.split(".")
        if isinstance(holder := value_in(raw, path), dict) and last in holder:
            holder[last] = value
    return [] if allow else [_elsewhere(file, "", code, own_folder) for code in _foreign(_code_in(found), own_folder)]


def _code_in(values: Mapping[str, object]) -> tuple[Code, ...]:
    """Code that values name at dotted keys; a part of a key may have `*` in it."""
    found = []
    for key, value in values.items():
        if not isinstance(value, str) or not value:
            continue
        table, *rest = parts_of(key)
        if ":" in value and _match(["user"], rest):
            source, _, name = value.rpartition(":")
            found.append(Code(f"{table}.user", source, name))
        elif _match(["fmu"], rest) or _match(["fmu", "file"], rest):
            found.append(Code(f"{table}.fmu", value, ""))
    return tuple(found)


def _match(names: list[str], patterns: list[str]) -> bool:
    return len(names) == len(patterns) and all(map(fnmatchcase, names, patterns))


def _foreign(found: tuple[Code, ...], folder: Path | None) -> list[Code]:
    """What is no file that really lies in a folder: links are followed."""

    def is_below(code: Code) -> bool:
        try:
            return folder is not None and code.is_file and Path(code.source).resolve().is_relative_to(folder.resolve())
        except (OSError, RuntimeError, ValueError):  # links in a circle, a null byte
            return False

    return [code for code in found if not is_below(code)]


def _elsewhere(file: str, at: str, code: Code, own_folder: Path | None) -> ConfigProblem:
    what = "a file" if code.is_file else "a module of Python,"
    where = "the file's own folder" + ("" if own_folder is None else f", {own_folder.absolute()}")
    allowed = f"code from elsewhere: {what} outside {where}; runs only with --allow-code, or allow_code=True"
    return ConfigProblem(file, f"{at}{code.key}", repr(code.source), allowed)
