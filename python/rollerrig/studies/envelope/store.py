"""Finished runs on disk, one line each, so that a map that was stopped goes on.

    folder/runs.jsonl: a line that says what was run, then a line per run

A line is whole once it ends; what a killed program left of one is cut off. Runs are found by their torque, adhesion and load, so
that another or a finer grid takes over those that it shares.
"""

from __future__ import annotations

import json
import os
import tomllib
from collections.abc import Iterator, Mapping
from pathlib import Path
from types import TracebackType
from typing import IO, Any

from rollerrig import __version__
from rollerrig.config import ConfigError, ConfigProblem
from rollerrig.config.errors import show_value
from rollerrig.results import OutputError
from rollerrig.studies.envelope.judge import Record
from rollerrig.studies.envelope.plan import Plan, Point

NAME = "runs.jsonl"
_CURE = "allowed: what the finished runs were made with; undo the change, choose another --out, or delete the file to begin anew"
_MOST_DIFFERENCES = 5
_NO_MATTER = ("description", "time.duration", "time.output_step")
"""Keys of a case that change no run of a map."""


class Store:
    """The finished runs of one folder; to be used as a context, which keeps the file open."""

    def __init__(self, folder: Path, plan: Plan) -> None:
        """Read what is there.

        Raises:
            ConfigError: the runs there are those of another case or test.
            OutputError: the file cannot be read or written.
        """
        self.path = folder / NAME
        self.done: dict[Point, Record] = {}
        self._header = {"envelope": {"version": __version__, "test": plan.test(), "case": plan.case.to_toml()}}
        self._file: IO[bytes] | None = None
        try:
            self._read()
        except OSError as cause:
            raise OutputError(self.path, cause) from None

    def _read(self) -> None:
        content = self.path.read_bytes() if self.path.exists() else b""
        whole = content[: content.rfind(b"\n") + 1]
        lines = [_parsed(line) for line in whole.splitlines()]
        if not any(line is not None for line in lines):
            self.path.write_bytes(_line(self._header))
            return
        _refuse_another(self.path, lines[0], self._header)
        for line in lines[1:]:
            if line is not None and line.keys() >= {"load", "torque_nm", "adhesion", "region"}:
                self.done[Point(line.pop("load"), line.pop("torque_nm"), line.pop("adhesion"))] = line
        if len(whole) < len(content):
            os.truncate(self.path, len(whole))

    def __enter__(self) -> Store:
        """Open for adding."""
        try:
            self._file = self.path.open("ab", buffering=0)
        except OSError as cause:
            raise OutputError(self.path, cause) from None
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        """Close."""
        if self._file is not None:
            self._file.close()

    def add(self, point: Point, record: Record) -> None:
        """Keep a run; one that Ctrl-C brings here again is kept already.

        Raises:
            OutputError: it could not be written.
        """
        assert self._file is not None
        if point in self.done:
            return
        whole = {"load": point.load, "torque_nm": point.torque, "adhesion": point.adhesion, **record}
        try:
            self._file.write(_line(whole))
            os.fsync(self._file.fileno())
        except OSError as cause:
            raise OutputError(self.path, cause) from None
        self.done[point] = record


def _line(value: Mapping[str, Any]) -> bytes:
    return json.dumps(value, ensure_ascii=False).encode() + b"\n"


def _parsed(line: bytes) -> dict[str, Any] | None:
    """None: not one of ours; a disk that was full may have cut a line in the middle of the file."""
    try:
        value = json.loads(line)
    except ValueError:
        return None
    return value if isinstance(value, dict) else None


def _refuse_another(path: Path, found: dict[str, Any] | None, wanted: dict[str, Any]) -> None:
    there = (found or {}).get("envelope")
    if not isinstance(there, dict) or not {"version", "test", "case"} <= there.keys():
        needed = "needed: the runs of an envelope map; choose another --out or delete the file"
        raise ConfigError([ConfigProblem(str(path), "", "its first line is not ours", needed)])
    now = wanted["envelope"]
    before = {"version": there["version"], "test": there["test"], **tomllib.loads(there["case"])}
    after = {"version": now["version"], "test": now["test"], **tomllib.loads(now["case"])}
    differences = [found for found in _differences(before, after, "") if found[0] not in _NO_MATTER]
    problems = [
        ConfigProblem(str(path), key, f"{show_value(b)} there, {show_value(a)} now", _CURE)
        for key, b, a in differences[:_MOST_DIFFERENCES]
    ]
    if problems:
        raise ConfigError(problems)


def _differences(before: Any, after: Any, key: str) -> Iterator[tuple[str, Any, Any]]:
    """Key, old and new value of what differs; lists are told as a whole unless their lengths agree."""
    if isinstance(before, dict) and isinstance(after, dict):
        for name in [*before, *(name for name in after if name not in before)]:
            yield from _differences(before.get(name), after.get(name), f"{key}.{name}" if key else name)
    elif isinstance(before, list) and isinstance(after, list) and len(before) == len(after):
        for number, (b, a) in enumerate(zip(before, after, strict=True)):
            name = b.get("name") if isinstance(b, dict) else None
            yield from _differences(b, a, f"{key}.{name}" if name else f"{key}[{number}]")
    elif before != after:
        yield key, "missing" if before is None else before, "missing" if after is None else after
