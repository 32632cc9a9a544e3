"""Which single files this program wrote: those it may write anew.

    path -> [is_ours] -> whether the file carries our mark

A figure and a file of results say it in their metadata, a table and a model file by their first line,
a page and an FMU in the head of the page. Files of a study need no
marks: the manifest of their folder knows them by their checksums (results/folder.py).
"""

import os
from collections.abc import Sequence
from pathlib import Path

from rollerrig.common.input_files import check_hdf5, open_input

PROGRAM = "rollerrig"
"""Mark in the metadata of every figure and file of results."""

MODEL = f"{PROGRAM} model\n".encode()
"""First bytes of a model file."""
PAGE = f'<meta name="generator" content="{PROGRAM}">'.encode()
"""On a page of HTML; an FMU begins with one, which is not compressed."""
_HEAD = 4096
"""Metadata and first lines stand within so many bytes."""
_MARKS = {
    b"\x89PNG": f"Software\0{PROGRAM}".encode(),
    b"<?xml": f"<dc:title>{PROGRAM}</dc:title>".encode(),
    MODEL: MODEL,
    b"PK\x03\x04": PAGE,
    b"<!doctype html>": PAGE,
    b"MATLAB 5.0 MAT-file": f"written by {PROGRAM}".encode(),
}
"""How a figure, a model file or one of MATLAB begins -> what says that it is ours."""


def is_ours(path: Path, tables: Sequence[str] = ()) -> bool:
    """Whether this program wrote an existing file, or the first line is that of one of the tables."""
    try:
        with open_input(path) as file:
            head = file.read(_HEAD)
            if head.startswith(b"%PDF"):  # which says it at its end
                file.seek(max(0, path.stat().st_size - _HEAD))
                return f"/Creator ({PROGRAM})".encode() in file.read(_HEAD)
    except OSError:
        return False
    if head.startswith(b"\x89HDF"):
        return _is_our_dataset(path)
    if any(head.startswith(f"{line}\n".encode()) for line in tables):
        return True
    return any(head.startswith(begin) and mark in head for begin, mark in _MARKS.items())


def _is_our_dataset(path: Path) -> bool:
    import h5py

    try:
        with h5py.File(check_hdf5(path, None), "r") as file:
            return bool(file.attrs.get("program") == PROGRAM)
    except OSError:  # damaged
        return False


def exists(path: Path) -> bool:
    """Whether something has that name, be it a link to nothing."""
    return os.path.lexists(path)
