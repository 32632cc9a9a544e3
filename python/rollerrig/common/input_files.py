"""The one reader of files of the user.

    path -> [read_input, open_input] -> its bytes, or InputError before anything was read

Only regular files of a size that makes sense pass: a device never ends, a pipe may never begin, and what is far too large is
not what was meant. Whoever asks turns the error into its own, which names the file and what is allowed.
"""

import errno
import mmap
import os
import stat
from io import BufferedReader
from pathlib import Path

MEGABYTE = 1_000_000
LARGEST_TEXT = 4 * MEGABYTE
"""Largest size of a TOML file or a program: a case with everything written out has some 10 kB [bytes]."""
LARGEST_TABLE = 64 * MEGABYTE
"""Largest size of a file of measured points: 200 km of track, sampled every 0.25 m, have some 50 MB [bytes]."""

_COLLECTION = b"GCOL\1\0\0\0"
"""Signature and version of a collection of texts in a file of HDF5."""
_KINDS = (
    (stat.S_ISDIR, "a folder"),
    (stat.S_ISFIFO, "a pipe"),
    (stat.S_ISCHR, "a device"),
    (stat.S_ISBLK, "a device"),
    (stat.S_ISSOCK, "a socket"),
)


class InputError(OSError):
    """A path that is not read; `strerror` says why."""


def check_input(path: str | Path, largest: int | None) -> Path:
    """The path, if it may be opened: a regular file, not larger than allowed.

    Args:
        path: the file.
        largest: allowed size [bytes]; None: any.

    Raises:
        InputError: it is something else, or larger.
        OSError: there is no such file, or it may not be looked at.
    """
    try:
        _check(Path(path).stat(), largest)
    except ValueError:  # of a null byte
        raise InputError(errno.EINVAL, "a null byte in its name") from None
    return Path(path)


def read_input(path: str | Path, largest: int) -> bytes:
    """The whole content of a file.

    Args:
        path: the file.
        largest: allowed size [bytes].

    Raises:
        InputError: not a regular file, or larger than allowed.
        OSError: there is no such file, or it cannot be read.
    """
    with open_input(path, largest) as file:
        content = file.read(largest + 1)  # files of the kernel do not tell their size, and some have nothing to give
    if content is None:
        raise InputError(errno.EAGAIN, "nothing can be read from it")
    if len(content) > largest:
        raise _too_large(len(content), largest)
    return content


def open_input(path: str | Path, largest: int | None = None) -> BufferedReader:
    """A file open for reading bytes.

    Args:
        path: the file.
        largest: allowed size [bytes]; None: any.

    Raises:
        InputError: not a regular file, or larger than allowed.
        OSError: there is no such file, or it cannot be read.
    """
    check_input(path, largest)  # also before it is opened: some devices act on that
    flags = os.O_RDONLY | getattr(os, "O_BINARY", 0) | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_NOCTTY", 0)
    file = os.fdopen(os.open(path, flags), "rb")
    try:
        _check(os.fstat(file.fileno()), largest)  # it may have been exchanged meanwhile
    except InputError:
        file.close()
        raise
    return file


def check_hdf5(path: str | Path, largest: int | None) -> Path:
    """The path of a file of HDF5, if it may be opened, and its collections of texts end and do not overlap.

    The library walks for ever through a collection that holds an object without index and size. Source: HDF5 File Format
    Specification 3.0, III.E "Global Heap": after a head of 16 bytes objects of index and references (2 bytes each), 4 unused
    ones, size (8), and what they hold, filled up to eights; index 0 is the room that is left.

    Raises:
        InputError: it is damaged so, something else, or larger than allowed.
        OSError: there is no such file, or it may not be looked at.
    """
    with open_input(path, largest) as file:
        if os.fstat(file.fileno()).st_size == 0:
            return Path(path)
        with mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as content:
            at, objects = content.find(_COLLECTION), 0
            while at >= 0:
                end = min(at + int.from_bytes(content[at + 8 : at + 16], "little"), len(content))
                place = at + 16
                while place + 16 <= end:
                    index = int.from_bytes(content[place : place + 2], "little")
                    size = int.from_bytes(content[place + 8 : place + 16], "little")
                    objects += 1
                    if index == size == 0 or objects > len(content) // 16:  # more than there is room for: they overlap
                        raise InputError(errno.EINVAL, "a damaged file of HDF5: its collection of texts has no end")
                    place += 16 + (size + 7) // 8 * 8 if index else size
                at = content.find(_COLLECTION, at + 8)
    return Path(path)


def _check(status: os.stat_result, largest: int | None) -> None:
    if not stat.S_ISREG(status.st_mode):
        kind = next((name for is_kind, name in _KINDS if is_kind(status.st_mode)), "something else")
        raise InputError(errno.EINVAL, f"{kind}, not a regular file")
    if largest is not None and status.st_size > largest:
        raise _too_large(status.st_size, largest)


def _too_large(size: int, largest: int) -> InputError:
    found = f"{size / MEGABYTE:.3g} MB" if size < 1000 * MEGABYTE else f"{size / (1000 * MEGABYTE):.3g} GB"
    return InputError(errno.EFBIG, f"too large: {found}, at most {largest / MEGABYTE:g} MB are read")
