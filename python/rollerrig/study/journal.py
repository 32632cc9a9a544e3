"""Finished jobs on disk, a line each, so that an interrupted study can continue.

    folder/jobs.jsonl: a line that says what is studied, then a line per finished job; jobs/*.nc: their Datasets

A line is whole once it ends; what a killed program left of one is cut off. A Dataset is written before the line that names it.
"""

from __future__ import annotations

import hashlib
import itertools
import json
import os
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import fields, is_dataclass
from importlib import import_module
from pathlib import Path
from types import TracebackType
from typing import IO, Any

import numpy as np
import xarray as xr

from rollerrig import __version__
from rollerrig.common.input_files import MEGABYTE, read_input
from rollerrig.config import ConfigError, ConfigProblem
from rollerrig.config.errors import show_value
from rollerrig.results import OutputError, load_run, output_folder, save_run, write_bytes

NAME, DATA = "jobs.jsonl", "jobs"
_CURE = "allowed: what the finished jobs were made with; undo the change, choose another --out, or delete the file to begin anew"
_MOST_DIFFERENCES = 5
LARGEST_JOURNAL = 1000 * MEGABYTE
"""Largest size of the lines; a thousand runs of an envelope have some 2 MB [bytes]."""


_BEGIN = b'{"study": '
_DATASET = re.compile(rb'"\$dataset": "jobs/([a-z0-9_]+\.nc)"')


def check_jobs(folder: Path, study: str) -> None:
    """Refuse a folder with unfinished jobs of another study.

    Raises:
        OutputError: it has such.
    """
    path = folder / NAME
    try:
        line, whole, _ = read_input(path, LARGEST_JOURNAL).partition(b"\n")
    except FileNotFoundError:
        return
    except OSError as cause:
        raise OutputError(path, cause) from None
    found = (_parsed(line) or {}).get("study")
    if found != study and (whole or not line.startswith(_BEGIN)):  # of a torn line nothing is kept
        what = "its first line is not ours" if found is None else f"finished jobs of `rollerrig {found}`"
        raise OutputError(path, f"{what}; choose another --out, or delete the file")


class Journal:
    """The finished jobs of one folder; to be used as a context, which keeps the file open."""

    def __init__(self, folder: Path, study: str, plan: Mapping[str, Any], irrelevant: Sequence[str] = ()) -> None:
        """Read what is there.

        Args:
            folder: an existing folder.
            study: its name.
            plan: all that decides the jobs' results, as JSON takes it.
            irrelevant: dotted keys of the plan that may change.

        Raises:
            ConfigError: the jobs there are those of another study or plan.
            OutputError: the file cannot be read or written.
        """
        self.path, self.folder = folder / NAME, folder
        self.done: dict[str, Any] = {}
        self._file: IO[bytes] | None = None
        self._header = {"study": study, "version": __version__, "plan": json.loads(json.dumps(plan))}
        try:
            self._read(irrelevant)
        except OSError as cause:
            raise OutputError(self.path, cause) from None

    def _read(self, irrelevant: Sequence[str]) -> None:
        content = read_input(self.path, LARGEST_JOURNAL) if self.path.exists() else b""
        whole = content[: content.rfind(b"\n") + 1]
        lines = [_parsed(line) for line in whole.splitlines()]
        if not any(line is not None for line in lines) and (not content or content.startswith(_BEGIN)):
            self.path.unlink(missing_ok=True)
            return
        lines = lines or [None]
        _refuse_another(self.path, lines[0], self._header, irrelevant)
        for line in lines[1:]:
            if line is not None and line.keys() == {"job", "result"}:
                try:
                    self.done[line["job"]] = _decoded(line["result"], self.folder)
                except (FileNotFoundError, ImportError, KeyError, TypeError, ValueError):
                    continue  # its Dataset is missing, or an older version wrote it: the job is done again
        if len(whole) < len(content):
            os.truncate(self.path, len(whole))

    def __enter__(self) -> Journal:
        """Ready for adding."""
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        """Close."""
        if self._file is not None:
            self._file.close()
            self._file = None

    def add(self, name: str, result: Any) -> None:
        """Keep the result of a job.

        Raises:
            OutputError: it could not be written.
        """
        try:
            if self._file is None:
                begun = self.path.exists()
                self._file = self.path.open("ab", buffering=0)
                if not begun:
                    self._file.write(_line(self._header))
            files = (f"{DATA}/{_stem(name)}_{number}.nc" for number in itertools.count())
            self._file.write(_line({"job": name, "result": _encoded(result, self.folder, files)}))
            os.fsync(self._file.fileno())
        except OSError as cause:
            raise OutputError(self.path, cause) from None
        self.done[name] = result

    def settle(self, names: Iterable[str]) -> None:
        """Write it anew with its jobs in this order: the same bytes, whichever of them ended first.

        Raises:
            OutputError: it could not be written.
        """
        self.__exit__(None, None, None)
        if not self.path.exists():
            return
        self._remove_torn(self._datasets())
        lines = [line for line in map(_parsed, read_input(self.path, LARGEST_JOURNAL).splitlines()) if line is not None]
        jobs = {line["job"]: line for line in lines if "job" in line}
        ordered = [jobs.pop(name) for name in names if name in jobs]
        write_bytes(self.path, b"".join(map(_line, (self._header, *ordered, *jobs.values()))), force=True)

    def discard(self) -> None:
        """Remove it: the study is finished."""
        self.__exit__(None, None, None)
        data = self.folder / DATA
        if self.path.exists():
            names = self._datasets()
            self._remove_torn(names)
            for name in names:
                (data / name).unlink(missing_ok=True)
            self.path.unlink()
        if data.is_dir() and not any(data.iterdir()):  # what else lies there is not ours
            data.rmdir()

    def _datasets(self) -> list[str]:
        """Names of the files in the folder of Datasets that the lines name."""
        return sorted({name.decode() for name in _DATASET.findall(read_input(self.path, LARGEST_JOURNAL))})

    def _remove_torn(self, names: Iterable[str]) -> None:
        """Remove what a killed program left of files under their temporary names."""
        for name in names:
            for left in (self.folder / DATA).glob(f".{name}.*"):
                left.unlink(missing_ok=True)


def _line(value: Mapping[str, Any]) -> bytes:
    return json.dumps(value, ensure_ascii=False).encode() + b"\n"


def _parsed(line: bytes) -> dict[str, Any] | None:
    """None: not one of ours; a disk that was full may have cut a line in the middle of the file."""
    try:
        value = json.loads(line)
    except ValueError:
        return None
    return value if isinstance(value, dict) else None


# -------------------------------------------------------------------------------------------------------- results


def _stem(job: str) -> str:
    """Stem of the files of a job: the same whenever and wherever it is done; two jobs that are nearly named alike differ."""
    return f"{re.sub(r'[^a-z0-9]+', '_', job.lower())[:40]}_{hashlib.sha256(job.encode()).hexdigest()[:8]}"


def _encoded(value: Any, folder: Path, files: Iterator[str]) -> Any:
    """A result as JSON; Datasets go to files of their own, dataclasses and arrays to tables that say what they are."""
    if isinstance(value, xr.Dataset):
        output_folder(folder / DATA)
        name = next(files)
        save_run(value, folder / name)
        return {"$dataset": name}
    if is_dataclass(value) and not isinstance(value, type):
        kind = f"{type(value).__module__}:{type(value).__qualname__}"
        return {
            "$class": kind,
            "fields": {f.name: _encoded(getattr(value, f.name), folder, files) for f in fields(value)},
        }
    if isinstance(value, np.ndarray | np.generic):
        return {"$array": value.tolist(), "dtype": str(value.dtype)}
    if isinstance(value, tuple):
        return {"$tuple": [_encoded(item, folder, files) for item in value]}
    if isinstance(value, list):
        return [_encoded(item, folder, files) for item in value]
    if isinstance(value, Mapping):
        return {str(key): _encoded(inner, folder, files) for key, inner in value.items()}
    return value


def _decoded(value: Any, folder: Path) -> Any:
    """The result of `_encoded`.

    Raises:
        FileNotFoundError, ImportError, KeyError, TypeError, ValueError: it is not what `_encoded` wrote.
    """
    if isinstance(value, list):
        return [_decoded(item, folder) for item in value]
    if not isinstance(value, dict):
        return value
    if "$dataset" in value:
        return load_run(folder / value["$dataset"])
    if "$array" in value:
        found = np.asarray(value["$array"], value["dtype"])
        return found if found.ndim else found[()]
    if "$tuple" in value:
        return tuple(_decoded(item, folder) for item in value["$tuple"])
    if "$class" in value:
        module, _, name = str(value["$class"]).partition(":")
        if not module.startswith("rollerrig."):
            raise ValueError(f"{module} is none of our modules")
        kind = getattr(import_module(module), name, None)
        if not (isinstance(kind, type) and is_dataclass(kind)):
            raise ValueError(f"{value['$class']} is no result")
        return kind(**{key: _decoded(inner, folder) for key, inner in value["fields"].items()})
    return {key: _decoded(inner, folder) for key, inner in value.items()}


# ----------------------------------------------------------------------------------------------------------- plans


def _refuse_another(
    path: Path, found: dict[str, Any] | None, wanted: Mapping[str, Any], irrelevant: Sequence[str]
) -> None:
    if found is None or not {"study", "version", "plan"} <= found.keys() or not isinstance(found["plan"], dict):
        needed = "needed: the finished jobs of a study; choose another --out or delete the file"
        raise ConfigError([ConfigProblem(str(path), "", "its first line is not ours", needed)])
    before, after = ({**{k: v for k, v in one.items() if k != "plan"}, **one["plan"]} for one in (found, wanted))
    differences = [one for one in _differences(before, after, "") if not _is_one_of(one[0], irrelevant)]
    problems = [
        ConfigProblem(str(path), key, f"{show_value(b)} there, {show_value(a)} now", _CURE)
        for key, b, a in differences[:_MOST_DIFFERENCES]
    ]
    if problems:
        raise ConfigError(problems)


def _is_one_of(key: str, names: Sequence[str]) -> bool:
    """Whether a dotted key is, or ends in, one of the names."""
    return any(key == name or key.endswith(f".{name}") for name in names)


def _differences(before: Any, after: Any, key: str) -> Iterator[tuple[str, Any, Any]]:
    """Key, old and new value of what differs; lists are reported as a whole unless their lengths agree."""
    if isinstance(before, dict) and isinstance(after, dict):
        for name in [*before, *(name for name in after if name not in before)]:
            yield from _differences(before.get(name), after.get(name), f"{key}.{name}" if key else name)
    elif isinstance(before, list) and isinstance(after, list) and len(before) == len(after):
        for number, (b, a) in enumerate(zip(before, after, strict=True)):
            name = b.get("name") if isinstance(b, dict) else None
            yield from _differences(b, a, f"{key}.{name}" if name else f"{key}[{number}]")
    elif before != after:
        yield key, "missing" if before is None else before, "missing" if after is None else after
