"""Finished jobs on disk, a line each, so that an interrupted study can continue.

    folder/jobs.jsonl: a line that says what is studied, then a line per finished job; jobs/*.nc: their Datasets

A line is whole once it ends; what a killed program left of one is cut off. A Dataset is written before the line that names it.
A file per job in place of a line takes three times the processor time of a job's line, and a sweep of 10^6 cases as many files;
SQLite needs the locks that network file systems of clusters often lack.
"""

import hashlib
import json
import os
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import fields, is_dataclass
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import IO, Any

import numpy as np
import xarray as xr

from rollerrig import __version__
from rollerrig.common.input_files import MEGABYTE, read_input
from rollerrig.config import ConfigError, ConfigProblem
from rollerrig.config.errors import show_value
from rollerrig.results import OutputError, load_run, netcdf_bytes, output_folder, write_bytes

NAME, DATA = "jobs.jsonl", "jobs"
LARGEST = 1000 * MEGABYTE
"""Largest size of the lines; a thousand runs of an envelope have some 2 MB [bytes]."""

_CURE = "allowed: what the finished jobs were made with; undo the change, choose another --out, or delete the file to begin anew"
_FOREIGN = "not a checkpoint file of this program"
_MOST_DIFFERENCES = 5


def check_jobs(folder: Path, study: str) -> None:
    """Refuse with an OutputError a folder with unfinished jobs of another study."""
    path = folder / NAME
    try:
        first = next(_lines(path), {"study": study})
    except OSError as cause:
        raise OutputError(path, cause) from None
    found = (first or {}).get("study")
    if found != study:
        what = _FOREIGN if found is None else f"finished jobs of `rollerrig {found}`"
        raise OutputError(path, f"{what}; choose another --out, or delete the file")


class Checkpoint:
    """The finished jobs of one folder; to be used as a context, which keeps the file open.

    Attributes:
        done: result of each job by its name.
    """

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
        lines = _lines(self.path, self.folder)
        try:
            first = next(lines, self._header)
        except OSError as cause:
            raise OutputError(self.path, cause) from None
        _refuse_another(self.path, first, self._header, irrelevant)  # before any result is read
        self.done = {
            line["job"]: line["result"] for line in lines if line is not None and line.keys() == {"job", "result"}
        }

    def __enter__(self) -> "Checkpoint":
        """Ready for adding."""
        return self

    def __exit__(self, *_error: object) -> None:
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
                if not self.path.exists():
                    write_bytes(self.path, _line(self._header))
                content = read_input(self.path, LARGEST)
                os.truncate(self.path, content.rfind(b"\n") + 1)
                self._file = self.path.open("ab", buffering=0)
            self._file.write(_line({"job": name, "result": _encoded(result, self.folder, _stem(name), [])}))
            os.fsync(self._file.fileno())
        except OSError as cause:
            raise OutputError(self.path, cause) from None
        self.done[name] = result

    def write_in_order(self, names: Iterable[str]) -> None:
        """Write it anew with its jobs in this order: the same bytes, whichever of them ended first.

        Raises:
            OutputError: it could not be written.
        """
        self.__exit__()
        jobs = {line["job"]: line for line in _lines(self.path) if line is not None and "job" in line}
        ordered = [jobs.pop(name) for name in names if name in jobs]
        if ordered:
            write_bytes(self.path, b"".join(map(_line, (self._header, *ordered, *jobs.values()))), force=True)

    def discard(self) -> None:
        """Remove it: the study is finished."""
        self.__exit__()
        data = self.folder / DATA
        for path in (path for name in self.done for path in data.glob(f"{_stem(name)}_*")):
            path.unlink()
        self.path.unlink(missing_ok=True)
        if data.is_dir() and not any(data.iterdir()):  # what else is there is the user's
            data.rmdir()


def _line(value: Mapping[str, Any]) -> bytes:
    return json.dumps(value, ensure_ascii=False).encode() + b"\n"


def _lines(path: Path, folder: Path | None = None) -> Iterator[dict[str, Any] | None]:
    """The whole lines of a file, with results where the folder is given; None: damaged, or not of this version.

    Raises:
        OSError: it cannot be read.
    """
    if not path.exists():
        return
    content = read_input(path, LARGEST)
    for line in content[: content.rfind(b"\n") + 1].splitlines() or [b""]:
        try:
            value = json.loads(line, object_hook=None if folder is None else partial(_decoded, folder))
        except (FileNotFoundError, ImportError, KeyError, TypeError, ValueError):
            value = None  # of a result: its job is done again
        yield value if isinstance(value, dict) else None


def _stem(job: str) -> str:
    """Stem of the files of a job: the same whenever and wherever it is done; two jobs that are nearly named alike differ."""
    return f"{re.sub(r'[^a-z0-9]+', '_', job.lower())[:40]}_{hashlib.sha256(job.encode()).hexdigest()[:8]}"


def _encoded(value: Any, folder: Path, stem: str, files: list[str]) -> Any:
    """A result as JSON; Datasets go to files of their own, dataclasses and arrays to tables that say what they are."""
    inner = partial(_encoded, folder=folder, stem=stem, files=files)
    if isinstance(value, xr.Dataset):
        files.append(f"{DATA}/{stem}_{len(files)}.nc")
        path = output_folder(folder / DATA) / Path(files[-1]).name
        part = path.with_suffix(".part")  # what a killed program leaves of it has a name that the job writes again
        with part.open("wb") as file:
            file.write(netcdf_bytes(value))
            os.fsync(file.fileno())
        part.replace(path)
        return {"$dataset": files[-1]}
    if is_dataclass(value) and not isinstance(value, type):
        kind = f"{type(value).__module__}:{type(value).__qualname__}"
        return {"$class": kind, "fields": {field.name: inner(getattr(value, field.name)) for field in fields(value)}}
    if isinstance(value, np.ndarray | np.generic):
        return {"$array": value.tolist(), "dtype": str(value.dtype)}
    if isinstance(value, tuple):
        return {"$tuple": list(map(inner, value))}
    if isinstance(value, list):
        return list(map(inner, value))
    return {str(key): inner(one) for key, one in value.items()} if isinstance(value, Mapping) else value


def _decoded(folder: Path, value: dict[str, Any]) -> Any:
    """A table of `_encoded` as what it was; those in it are so already.

    Raises:
        FileNotFoundError, ImportError, KeyError, TypeError, ValueError: it is not what `_encoded` wrote.
    """
    if "$dataset" in value:
        return load_run(folder / value["$dataset"])
    if "$array" in value:
        found = np.asarray(value["$array"], value["dtype"])
        return found if found.ndim else found[()]
    if "$tuple" in value:
        return tuple(value["$tuple"])
    if "$class" in value:
        module, _, name = str(value["$class"]).partition(":")
        kind = getattr(import_module(module), name, None) if module.startswith("rollerrig.") else None
        if not (isinstance(kind, type) and is_dataclass(kind)):
            raise ValueError(f"{value['$class']} is no result")
        return kind(**value["fields"])
    return value


def _refuse_another(
    path: Path, found: dict[str, Any] | None, wanted: Mapping[str, Any], irrelevant: Sequence[str]
) -> None:
    if found is None or not {"study", "version", "plan"} <= found.keys() or not isinstance(found["plan"], dict):
        needed = "needed: the finished jobs of a study; choose another --out or delete the file"
        raise ConfigError.of(str(path), "", _FOREIGN, needed)
    before, after = ({"study": one["study"], "version": one["version"], **one["plan"]} for one in (found, wanted))
    problems = [
        ConfigProblem(str(path), key, f"{show_value(b)} there, {show_value(a)} now", _CURE)
        for key, b, a in _differences(before, after, "")
        if not any(key == name or key.endswith(f".{name}") for name in irrelevant)
    ]
    if problems:
        raise ConfigError(problems[:_MOST_DIFFERENCES])


def _differences(before: Any, after: Any, key: str) -> Iterator[tuple[str, Any, Any]]:
    """Key, old and new value of what differs; lists are reported as a whole unless their lengths agree."""
    if isinstance(before, dict) and isinstance(after, dict):
        for name in {**before, **after}:
            yield from _differences(before.get(name), after.get(name), f"{key}.{name}" if key else name)
    elif isinstance(before, list) and isinstance(after, list) and len(before) == len(after):
        for number, (b, a) in enumerate(zip(before, after, strict=True)):
            name = b.get("name") if isinstance(b, dict) else None
            yield from _differences(b, a, f"{key}.{name}" if name else f"{key}[{number}]")
    elif before != after:
        yield key, "missing" if before is None else before, "missing" if after is None else after
