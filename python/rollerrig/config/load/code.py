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

from pydantic import BaseModel

from rollerrig.config.errors import ConfigProblem
from rollerrig.config.load.change import leaves, parts_of
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
    found = [_code(key, user) for key, table in tables.items() if isinstance(user := _user(table), str)]
    return (
        *found,
        *(Code(f"{key}.fmu", table.fmu.file, "") for key, table in tables.items() if getattr(table, "fmu", None)),
    )


def check_new_code(
    changes: Mapping[str, object], file: str, at: str, own_folder: Path | None, *, allow: bool
) -> tuple[tuple[Code, ...], list[ConfigProblem]]:
    """Code that changes of a case bring, whatever else they say, and a problem for each piece that may not run.

    Values are absolute paths; code may lie in the file's own folder, if it has one, and elsewhere where `allow` says so.
    """
    found = []
    for key, value in leaves(changes):
        table, *rest = parts_of(key)
        if isinstance(value, str) and ":" in value and _match(["user"], rest):
            found.append(_code(table, value))
        elif isinstance(value, str) and (_match(["fmu"], rest) or _match(["fmu", "file"], rest)):
            found.append(Code(f"{table}.fmu", value, ""))
    return tuple(found), [
        _elsewhere(file, f"{at}.{code.key}", repr(code.source), code, own_folder, "file")
        for code in found
        if not (allow or _is_below(own_folder, code))
    ]


def _match(names: list[str], patterns: list[str]) -> bool:
    return len(names) == len(patterns) and all(map(fnmatchcase, names, patterns))


def place_code(
    raw: dict[str, Any], file: str, folder: Path, own_folder: Path | None, *, allow: bool
) -> list[ConfigProblem]:
    """Make paths of code in the tables of a case absolute, in place; a problem for each piece of code that may not run.

    Relative paths start at `folder`; `own_folder` is that of the case, None: it has none.
    """
    found = _placed_fmus(raw, folder)
    for key, table in raw.items():
        if isinstance(user := _user(table), str) and "\0" not in user:
            code = _code(key, user)
            if code.is_file:
                table["user"] = f"{(folder / code.source).absolute()}:{code.name}"
                code = _code(key, table["user"])
            if ":" in user:
                found.append((code, table["user"]))
    return [
        _elsewhere(file, code.key, repr(written), code, own_folder)
        for code, written in found
        if not (allow or _is_below(own_folder, code))
    ]


def _placed_fmus(raw: dict[str, Any], folder: Path) -> list[tuple[Code, str]]:
    """FMUs in the tables of a case, a table `fmu` or the file alone: their paths made absolute."""
    found = []
    for key, table in raw.items():
        fmu = table.get("fmu") if isinstance(table, Mapping) else getattr(table, "fmu", None)
        if isinstance(fmu, BaseModel) or not isinstance(table, dict):  # of a checked case: placed before
            path = getattr(fmu, "file", None)
        else:
            path = fmu.get("file") if isinstance(fmu, Mapping) else fmu
            if isinstance(path, str) and path and "\0" not in path:
                path = str((folder / path).absolute())
                table["fmu"] = {**fmu, "file": path} if isinstance(fmu, Mapping) else path
        if isinstance(path, str) and path:
            found.append((Code(f"{key}.fmu", path, ""), path))
    return found


def _elsewhere(
    file: str, key: str, value: str, code: Code, own_folder: Path | None, whose: str = "case"
) -> ConfigProblem:
    what = "a file" if code.is_file else "a module of Python,"
    where = f"the {whose}'s own folder" + ("" if own_folder is None else f", {own_folder.absolute()}")
    allowed = f"code from elsewhere: {what} outside {where}; runs only with --allow-code, or allow_code=True"
    return ConfigProblem(file, key, value, allowed)


def _user(table: object) -> object:
    return table.get("user") if isinstance(table, Mapping) else getattr(table, "user", None)


def _code(key: str, user: str) -> Code:
    source, _, name = user.rpartition(":")
    return Code(f"{key}.user", source, name)


def _is_below(folder: Path | None, code: Code) -> bool:
    """Whether code is a file that really lies in a folder: links are followed."""
    try:
        return folder is not None and code.is_file and Path(code.source).resolve().is_relative_to(folder.resolve())
    except (OSError, RuntimeError):  # links in a circle
        return False
