"""The table that the creep law `table` reads.

    creep_table.npz -> [table_file] -> CreepTable of the core

The table is computed and written by `scripts/build_creep_table.py`; docs/theory/creep_laws.md says how and how accurate it is.
"""

import hashlib
import io
import zipfile
from functools import cache
from importlib.resources import files

import numpy as np
import numpy.typing as npt

from rollerrig import _core

TABLE_FILE = "tables/creep_table.npz"
"""Below the catalogue."""


class CreepTableError(ValueError):
    """The table file cannot be used."""


@cache
def shipped_table() -> _core.CreepTable:
    """The table of the catalogue, read once.

    Raises:
        CreepTableError: it is missing, truncated or changed.
    """
    source = files("rollerrig.catalog").joinpath(TABLE_FILE)
    try:
        data = source.read_bytes()
    except OSError as error:
        raise CreepTableError(f"{TABLE_FILE}: cannot be read ({error}); install rollerrig again") from None
    return read_table(data, TABLE_FILE)


def read_table(data: bytes, name: str) -> _core.CreepTable:
    """A table from the bytes of its file.

    Args:
        data: the whole file; its coefficients have the shape (aspects + 3, cells[0] + 3, 2 cells[1] + 3, cells[2] + 3, 3).
        name: of the file, for messages.

    Raises:
        CreepTableError: truncated or changed.
    """
    try:
        with np.load(io.BytesIO(data), allow_pickle=False) as file:
            names = ("log_aspect_end", "rho_0", "aspects", "cells", "coefficients", "sha256")
            content = {key: file[key] for key in names}
    except (ValueError, OSError, EOFError, zipfile.BadZipFile, KeyError):
        raise CreepTableError(f"{name}: not a creep table, or truncated; install rollerrig again") from None
    coefficients = np.ascontiguousarray(content["coefficients"], dtype=np.float32)
    if checksum(coefficients) != str(content["sha256"]):
        raise CreepTableError(f"{name}: the checksum of its numbers does not match; install rollerrig again")
    shape = (*coefficients.shape[:-1], 4)
    padded = np.zeros(shape, dtype=np.float32)
    padded[..., :3] = coefficients
    try:
        return _core.CreepTable.of(
            float(content["log_aspect_end"]),
            float(content["rho_0"]),
            int(content["aspects"]),
            [int(n) for n in content["cells"]],
            padded.ravel(),
        )
    except ValueError as error:
        raise CreepTableError(f"{name}: {error}") from None


def checksum(coefficients: npt.NDArray[np.float32]) -> str:
    """SHA-256 of the coefficients as little-endian floats."""
    return hashlib.sha256(np.ascontiguousarray(coefficients, dtype="<f4").tobytes()).hexdigest()
