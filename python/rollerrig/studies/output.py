"""Files that studies write beside their reports."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Sequence
from pathlib import Path

from rollerrig.results import write_text


def write_rows(path: Path, rows: Sequence[Sequence[object]]) -> Path:
    """Write a table of numbers and words as CSV, header first; nine digits, nothing for what does not exist.

    Raises:
        OutputError: it could not be written.
    """
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows([_cell(cell) for cell in row] for row in rows)
    return write_text(path, text.getvalue())


def _cell(value: object) -> object:
    if not isinstance(value, float):
        return value
    return f"{value:.9g}" if math.isfinite(value) else ""


def finite(value: float) -> float | None:
    """The number, or None where JSON has no word for it."""
    return float(value) if math.isfinite(value) else None
