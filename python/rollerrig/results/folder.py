"""The folder of one command's results: what belongs together, and who wrote it.

    files of a study -> [ResultFolder: staged, then renamed] -> folder, and its manifest `rollerrig.json`

The manifest names the command, its cases and every file with its checksum. A file that it knows by name and checksum is this
program's and may be replaced or removed; any other, also one that was edited since, is the user's. New files are written beside
the old ones first. Then the manifest says that they replace them, they are renamed, and what the same command left earlier and
did not write again goes: a program that is killed at any moment leaves whole files, each known to the manifest.
"""

import hashlib
import json
import os
import shutil
import tempfile
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path, PurePosixPath, PureWindowsPath
from types import TracebackType

from rollerrig import __version__
from rollerrig.common.input_files import MEGABYTE, open_input, read_input
from rollerrig.config import Case
from rollerrig.results.files import OutputError, output_folder, write_new
from rollerrig.results.marks import PROGRAM, exists

NAME = "rollerrig.json"
_STAGE = ".rollerrig-"
_LARGEST = 16 * MEGABYTE
_CURE = "choose another --out, or replace them with --force (force=True)"

Files = Mapping[str, str | None]
"""Name below the folder, with slashes -> checksum; None: known by its name alone, its bytes differ from run to run."""


@dataclass(frozen=True)
class Manifest:
    """What a folder holds."""

    command: str  # that wrote it
    cases: Mapping[str, str] = field(default_factory=dict)  # label -> checksum of its whole configuration
    files: Files = field(default_factory=dict)  # what belongs to it
    # files of before that may still stand there: writing has begun and not ended
    replaced: Files = field(default_factory=dict)
    interrupted: bool = False  # whether Ctrl-C ended the command early

    def names(self) -> set[str]:
        """All files that it knows."""
        return {*self.files, *self.replaced}

    def owns(self, folder: Path, name: str) -> bool:
        """Whether the file of that name is still the one that was written."""
        path = folder / name
        if name not in self.names() or path.is_symlink() or not path.parent.resolve().is_relative_to(folder.resolve()):
            return False
        known = {files[name] for files in (self.files, self.replaced) if name in files}
        try:
            return None in known or checksum(path) in known
        except OSError:
            return False

    def text(self) -> str:
        """As JSON."""
        content: dict[str, object] = {"program": PROGRAM, "version": __version__, "command": self.command}
        content["cases"] = self.cases
        content |= {"interrupted": self.interrupted, "files": self.files}
        content |= {"replaced": self.replaced} if self.replaced else {}
        return json.dumps(content, indent=2, ensure_ascii=False) + "\n"


def read_manifest(folder: Path) -> Manifest | None:
    """The manifest of a folder; None where there is none.

    Raises:
        OutputError: there is a file of that name that is none.
    """
    path = folder / NAME
    if not exists(path):
        return None
    try:
        raw = json.loads(read_input(path, _LARGEST))
        found = Manifest(raw["command"], raw["cases"], raw["files"], raw.get("replaced", {}), bool(raw["interrupted"]))
        if raw["program"] != PROGRAM or not isinstance(raw["command"], str) or not all(map(_is_below, found.names())):
            raise ValueError
    except (OSError, ValueError, KeyError, TypeError, AttributeError, RecursionError):
        raise OutputError(path, "no manifest of this program; choose another --out, or delete the file") from None
    return found


def _is_below(name: object) -> bool:
    """A name that leads nowhere else, on any system."""
    if not isinstance(name, str) or "\0" in name:
        return False
    return all(p.parts and not p.anchor and ".." not in p.parts for p in (PurePosixPath(name), PureWindowsPath(name)))


def checksum(path: Path) -> str:
    """SHA-256 of a file.

    Raises:
        OSError: it is no regular file, or cannot be read.
    """
    with open_input(path) as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def check_folder(path: str | Path, command: str, patterns: Iterable[str], *, force: bool = False) -> Path:
    """The folder, made if need be and known to take the results of a command: better before a long run than after it.

    Args:
        path: the folder.
        command: that is about to be run.
        patterns: of the names that it will write there, as for `Path.glob`.
        force: whether results of other commands and files of the user may be replaced.

    Raises:
        OutputError: the folder takes no files, or holds what must not be replaced.
    """
    folder = output_folder(path)
    manifest = read_manifest(folder)
    if force:
        return folder
    if manifest is not None and manifest.command != command:
        raise OutputError(folder, f"holds results of `{PROGRAM} {manifest.command}`; {_CURE}")
    there = {found.relative_to(folder).as_posix() for pattern in patterns for found in folder.glob(pattern)}
    _refuse_foreign(folder, manifest, sorted(name for name in there if not (folder / name).is_dir()))
    return folder


def _refuse_foreign(folder: Path, manifest: Manifest | None, names: Sequence[str]) -> None:
    foreign = [name for name in names if manifest is None or not manifest.owns(folder, name)]
    if foreign:
        shown = ", ".join(foreign[:5]) + (f" and {len(foreign) - 5} more" if len(foreign) > 5 else "")
        raise OutputError(folder, f"{shown}: not written by this program, or changed since; {_CURE}")


_LOCKED: set[Path] = set()
"""Folders that this process has locked."""


@contextmanager
def locked(path: str | Path) -> Iterator[bool]:
    """Within it no other process writes results into a folder; True: that is certain, False: there are no locks here.

    The system's lock of the folder itself: it ends with the process, however that ends, and leaves no file as filelock does.

    Raises:
        OutputError: another process has it, or the folder cannot be made.
    """
    folder = output_folder(path).resolve()
    if folder in _LOCKED:
        yield True
        return
    try:
        import fcntl
    except ImportError:  # Windows
        yield False
        return
    handle = os.open(folder, os.O_RDONLY)
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        _LOCKED.add(folder)
    except BlockingIOError:
        os.close(handle)
        raise OutputError(folder, "another command is writing there; wait, or choose another --out") from None
    except OSError:  # a file system without locks
        pass
    try:
        yield folder in _LOCKED
    finally:
        _LOCKED.discard(folder)
        os.close(handle)


class ResultFolder:
    """The results of one command on their way into a folder; a context that leaves nothing behind unless `commit` was called."""

    def __init__(
        self,
        path: str | Path,
        command: str,
        cases: Mapping[str, Case],
        *,
        interrupted: bool = False,
        force: bool = False,
    ) -> None:
        """Look at what is there.

        Args:
            path: the folder, made if need be.
            command: that writes.
            cases: label -> case.
            interrupted: whether Ctrl-C ended it early.
            force: whether results of other commands and files of the user may be replaced.

        Raises:
            OutputError: the folder takes no files, or holds results of another command.
        """
        self.path = check_folder(path, command, (), force=force)
        self._before, self._force = read_manifest(self.path), force
        self._sums = {label: hashlib.sha256(case.to_toml().encode()).hexdigest() for label, case in cases.items()}
        self._command, self._interrupted = command, interrupted
        self._files: dict[str, str | None] = {}
        self._stage: Path | None = None
        self._lock = locked(self.path)

    def __enter__(self) -> "ResultFolder":
        """Ready for files, once what a killed program left of its own is removed.

        Raises:
            OutputError: another process is writing there, or the folder takes no files.
        """
        certain = self._lock.__enter__()
        try:
            for left in self.path.glob(f"{_STAGE}*") if certain else ():
                shutil.rmtree(left, ignore_errors=True)
            self._stage = Path(tempfile.mkdtemp(prefix=_STAGE, dir=self.path))
        except OSError as cause:
            self._lock.__exit__(None, None, None)
            raise OutputError(self.path, cause) from None
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        """Remove what was not committed."""
        if self._stage is not None:
            shutil.rmtree(self._stage, ignore_errors=True)
        self._lock.__exit__(kind, error, at)

    def add(self, name: str, content: bytes | memoryview, *, varies: bool = False) -> Path:
        """Write a file beside the old ones.

        Args:
            name: below the folder, with slashes.
            content: all of it.
            varies: whether its bytes differ between identical runs.

        Returns:
            Where it will be.

        Raises:
            OutputError: it could not be written.
        """
        assert self._stage is not None, "to be used as a context"
        target, staged = self.path / name, self._stage / name
        try:
            staged.parent.mkdir(parents=True, exist_ok=True)
            write_new(staged, content)
        except OSError as cause:
            raise OutputError(target, cause) from None
        self._files[name] = None if varies else hashlib.sha256(content).hexdigest()
        return target

    def commit(self) -> None:
        """Put all files in their places and remove those that the manifest of before knows and nobody wrote again.

        Raises:
            OutputError: a file of the user is in the way, or one could not be renamed.
        """
        assert self._stage is not None, "to be used as a context"
        before = self._before or Manifest(self._command)
        if not self._force:
            _refuse_foreign(self.path, before, [name for name in self._files if exists(self.path / name)])
        owned = [name for name in sorted(before.names()) if before.owns(self.path, name)]
        stale = [name for name in owned if name not in self._files]
        varying = {name for files in (before.files, before.replaced) for name, known in files.items() if known is None}
        target = self.path / NAME
        try:
            self._write_manifest({name: None if name in varying else checksum(self.path / name) for name in owned})
            for name in self._files:
                target = self.path / name
                target.parent.mkdir(parents=True, exist_ok=True)
                (self._stage / name).replace(target)
            for name in stale:
                target = self.path / name
                target.unlink(missing_ok=True)
            for folder in {(self.path / name).parent for name in stale} - {self.path}:
                if not any(folder.iterdir()):
                    folder.rmdir()
            target = self.path / NAME
            self._write_manifest({})
        except OSError as cause:
            raise OutputError(target, cause) from None

    def _write_manifest(self, replaced: Files) -> None:
        manifest = Manifest(self._command, self._sums, dict(sorted(self._files.items())), replaced, self._interrupted)
        assert self._stage is not None
        staged = self._stage / NAME
        write_new(staged, manifest.text().encode())
        staged.replace(self.path / NAME)
