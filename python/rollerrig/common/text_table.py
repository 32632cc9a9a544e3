"""The one reader of tables as text: a heading, rows of cells.

    path -> [read_table] -> heading and cells of each column -> [name_and_unit, numbers]

Cells are separated by commas, semicolons, tabs or blanks; a comma that separates no cells may be the decimal mark. Empty lines
and those that begin with '#' are left out; rows count from the first one below the heading.
"""

import csv
import math
import re
from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np

from rollerrig.common.arrays import Array
from rollerrig.common.input_files import LARGEST_TABLE, read_input


def read_table(path: str | Path, largest: int = LARGEST_TABLE) -> list[tuple[str, list[str]]]:
    """Heading and cells of each column, with points as decimal marks.

    Args:
        path: the file.
        largest: its allowed size [bytes].

    Raises:
        OSError: the file cannot be read.
        ValueError: it is empty, a row has more or fewer cells than the heading, or decimal marks differ.
    """
    text = read_input(path, largest).decode("utf-8-sig", errors="replace")
    lines = [line for line in map(str.strip, text.splitlines()) if line and not line.startswith("#")]
    if not lines:
        raise ValueError("an empty file; needed: a heading and rows of numbers")
    separator = max(",;\t", key=lines[0].count)
    blanks = separator not in lines[0]
    try:
        head, *rows = csv.reader(lines, delimiter=separator)
        if blanks:
            head, rows = re.findall(r"\S+(?:\s*\[[^\]]*\])?", lines[0]), [line.split() for line in lines[1:]]
    except csv.Error as error:
        raise ValueError(f"no table: {error}") from None
    for number, row in enumerate(rows, 1):
        if len(row) < len(head) or any(cell.strip() for cell in row[len(head) :]):  # each row may end in a separator
            hint = "; decimal commas need ; or tabs between the cells" if separator == "," else ""
            raise ValueError(f"row {number} has {len(row)} cells, the heading {len(head)}{hint}")
    decimal = "." if separator == "," and not blanks else _decimal_mark(rows)
    return [(name.strip(), [row[k].strip().replace(decimal, ".") for row in rows]) for k, name in enumerate(head)]


def _decimal_mark(rows: Iterable[Sequence[str]]) -> str:
    """That of the cells; a comma beside points may part thousands."""
    found = {}
    for mark in ".,":
        number = re.compile(rf"\s*[+-]?(\d+[{mark}]\d*|[{mark}]\d+)([eE][+-]?\d+)?\s*")
        found[mark] = next((cell for row in rows for cell in row if mark in cell and number.fullmatch(cell)), "")
    if all(found.values()):
        shown = f"a point in '{found['.']}', a comma in '{found[',']}'"
        raise ValueError(f"{shown}; allowed: one of them, as the decimal mark of all cells")
    return "," if found[","] else "."


def name_and_unit(heading: str) -> tuple[str, str]:
    """'speed [km/h]' -> 'speed', 'km/h'; no unit: ''."""
    found = re.fullmatch(r"(.*?)\s*\[([^\[\]]*)\]", heading.strip())
    return (found[1], found[2]) if found else (heading.strip(), "")


def numbers(name: str, cells: Iterable[str]) -> Array:
    """Finite numbers of the cells of a column; ValueError: a cell has none, by row and name."""
    found = []
    for row, cell in enumerate(cells, 1):
        try:
            found.append(float(cell))
        except ValueError:
            found.append(math.nan)
        if not math.isfinite(found[-1]):
            raise ValueError(f"row {row}, column '{name}': '{cell}' is no number")
    return np.array(found)
