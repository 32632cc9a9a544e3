"""Reading profile points from text files: two columns, or Simpack's .prw/.prr.

    file -> [RawProfile] -> orientation, checks and smoothing (measured.py)

Only the syntax is checked here; what the numbers mean is decided where the profile is built.
"""

import math
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from rollerrig.common.arrays import Array
from rollerrig.common.input_files import LARGEST_TABLE, read_input
from rollerrig.profiles.course import Course, check_order, check_stray, spaced
from rollerrig.profiles.table import ProfileError, ProfileKind

FileFormat = Literal["auto", "two_column", "simpack"]
LengthUnit = Literal["auto", "mm", "m"]

COMMENT = re.compile(r"(#|!|%|;|//).*")
#: "-62,5 22,1", "-62,5;22,1": every number with a comma inside and none with a point, columns separated by something else.
DECIMAL_COMMAS = re.compile(r"\s*[+-]?\d+,\d+([eE][+-]?\d+)?([\s;]+[+-]?\d+(,\d+)?([eE][+-]?\d+)?)+\s*$")
FEWEST_POINTS = 20
LARGEST_NUMBER = 1e7
#: A profile is between 20 mm (the top of a rail head) and 300 mm (a full-width roller) wide.
WIDTH_RANGE = (20e-3, 300e-3)
MOST_LINES = 100_000


@dataclass(frozen=True, eq=False)
class RawProfile:
    """Points as a file gives them [m]; whether it declares a "wheel" or "rail", and its comment, may be empty."""

    course: Course
    declared: ProfileKind | None
    comment: str


def read_point_file(path: Path, file_format: FileFormat = "auto", units: LengthUnit = "auto") -> RawProfile:
    """Read a profile file.

    Args:
        path: the file.
        file_format: "two_column", "simpack", or "auto": Simpack if there is a `point.begin`.
        units: of a two-column file; "auto" takes numbers that span more than 1 for millimetres. A Simpack file
            states its own.

    Returns:
        The points in metres.

    Raises:
        ProfileError: for a missing, empty or malformed file, and for numbers that cannot be a profile.
    """
    try:
        lines = read_input(path, LARGEST_TABLE).decode("utf-8-sig", errors="replace").splitlines()
    except OSError as error:
        raise ProfileError(f"{path}: cannot be read: {error.strerror or error}") from error
    if not any(line.strip() for line in lines):
        raise ProfileError(f"{path}: the file is empty; a profile has at least {FEWEST_POINTS} points")
    if file_format == "auto":
        simpack = any(COMMENT.sub("", line).strip() == "point.begin" for line in lines)
        file_format = "simpack" if simpack else "two_column"
    if len(lines) > MOST_LINES:
        allowed = f"allowed: {MOST_LINES}; points every 0.1 to 0.5 mm are usual, keep every {len(lines) // 1000 + 1}th"
        raise ProfileError(f"{path}: {len(lines)} lines; {allowed}")
    raw = _read_simpack(path, lines) if file_format == "simpack" else _read_two_columns(path, lines, units)
    check_stray(raw.course)
    low, high = WIDTH_RANGE
    width = float(np.ptp(raw.course.points[:, 0]))
    if not low <= width <= high:
        raise ProfileError(
            f"{path}: wrong units suspected: the abscissa spans {width * 1e3:.6g} mm; "
            f"allowed {low * 1e3:g} to {high * 1e3:g} mm; set units to 'mm' or 'm'"
        )
    check_order(raw.course)
    return raw


def _read_two_columns(path: Path, lines: list[str], units: LengthUnit) -> RawProfile:
    points, numbers = _numbers(path, list(enumerate(lines, 1)), columns=(2,), header_allowed=True)
    if units == "auto":
        units = "mm" if np.ptp(points[:, 0]) > 1.0 else "m"
    scale = {"mm": 1e-3, "m": 1.0}[units]
    return RawProfile(Course(path, points * scale, np.ones(len(points)), numbers), None, "")


def _read_simpack(path: Path, lines: list[str]) -> RawProfile:
    """Apply the header's processing in the order Simpack numbers it (1 spacing ... 7 units).

    After it the abscissa grows outward and the ordinate downward, for wheels and rails alike. The smoothing
    that the header may name is not applied: ours follows (measured.py).
    """
    header, point_lines = _simpack_sections(path, lines)

    def number(key: str, default: float, positive: bool = False) -> float:
        text = header.get(key, "")
        try:
            value = float(text) if text else default
        except ValueError:
            value = math.nan
        if not math.isfinite(value) or (positive and value <= 0):
            raise ProfileError(f"{path}: {key}: {text!r}; it must be a {'positive' if positive else 'finite'} number")
        return value

    rows, numbers = _numbers(path, point_lines, columns=(2, 3))
    y, z = rows[:, 0], rows[:, 1]
    weights = rows[:, 2] if rows.shape[1] == 3 else np.ones(len(rows))
    kept = np.arange(len(rows))

    nearest = number("point.dist.min", 0.0)  # 1
    if nearest > 0:
        kept = np.array(spaced(rows[:, :2], nearest))
        _enough_left(path, len(kept), len(rows), f"point.dist.min = {nearest:g}, in the unit of the points,")
        y, z, weights = y[kept], z[kept], weights[kept]
    y, z = y + number("shift.y", 0.0), z + number("shift.z", 0.0)  # 2
    angle = number("rotate", 0.0) / number("units.ang.f", 1.0, positive=True)  # 3
    y, z = y * math.cos(angle) - z * math.sin(angle), y * math.sin(angle) + z * math.cos(angle)
    inside = np.ones(len(y), dtype=bool)  # 4, a bound counts where its minimum is below its maximum
    for axis, values in (("y", y), ("z", z)):
        low, high = number(f"bound.{axis}.min", 1.0), number(f"bound.{axis}.max", 0.0)
        if low < high:
            inside &= (values >= low) & (values <= high)
            span = f"of points from {values.min():g} to {values.max():g}"
            _enough_left(
                path, int(inside.sum()), len(rows), f"bound.{axis}.min = {low:g} and bound.{axis}.max = {high:g}", span
            )
    y, z, weights, kept = y[inside], z[inside], weights[inside], kept[inside]
    y = -y if number("mirror.y", 0) == 1 else y  # 5
    z = -z if number("mirror.z", 0) == 1 else z
    if number("inversion", 0) == 1:  # 6
        y, z, weights, kept = y[::-1], z[::-1], weights[::-1], kept[::-1]
    points = np.column_stack([y, z]) / number("units.len.f", 1.0, positive=True)  # 7
    kinds: dict[str, ProfileKind] = {"0": "rail", "1": "wheel"}
    course = Course(path, points, weights, numbers[kept])
    return RawProfile(course, kinds.get(header.get("type", "")), header.get("comment", ""))


def _simpack_sections(path: Path, lines: list[str]) -> tuple[dict[str, str], list[tuple[int, str]]]:
    """Keys and values of the header, and the numbered lines between point.begin and point.end."""
    header: dict[str, str] = {}
    begin = end = 0
    for number, line in enumerate(lines, 1):
        text = line.split("!", 1)[0].strip()
        if text == "point.begin":
            begin = number
        elif text == "point.end":
            end = number
        elif "=" in text and not begin:
            key, value = text.split("=", 1)
            # `type` stands in the header (kind of profile) and in the spline section (kind of file): first wins.
            header.setdefault(key.strip(), value.strip().strip("'"))
    if not begin or end < begin:
        missing = "point.end" if begin else "point.begin"
        raise ProfileError(f"{path}: no line {missing!r}; a Simpack profile has its points between begin and end")
    return header, list(enumerate(lines[begin : end - 1], begin + 1))


def _numbers(
    path: Path, lines: list[tuple[int, str]], columns: tuple[int, ...], header_allowed: bool = False
) -> tuple[Array, NDArray[np.intp]]:
    """Rows of numbers out of numbered lines, comments and blank lines left out, and the number of each row's line."""
    rows: list[list[float]] = []
    numbers: list[int] = []
    for number, line in lines:
        words = COMMENT.sub("", line).replace(",", " ").split()
        if not words:
            continue
        try:
            row = [float(re.sub("[dD]", "e", word)) for word in words]
        except ValueError:
            row = []
            if header_allowed and not rows and not DECIMAL_COMMAS.match(line):
                header_allowed = False  # one line of column names
                continue
        if problem := _problem(line, row, columns if not rows else (len(rows[0]),)):
            raise ProfileError(f"{path}: line {number}: {line.strip()[:60]!r}{problem}")
        rows.append(row)
        numbers.append(number)
    if len(rows) < FEWEST_POINTS:
        raise ProfileError(f"{path}: {len(rows)} points; a profile has at least {FEWEST_POINTS}")
    return np.array(rows), np.array(numbers)


def _problem(line: str, row: list[float], columns: tuple[int, ...]) -> str:
    """What is wrong with a line and its numbers, none where it has words; "" if nothing is."""
    if DECIMAL_COMMAS.match(line):
        return " has decimal commas; allowed: decimal points, columns separated by blanks, tabs or commas"
    if not row:
        return " is not a row of numbers"
    if len(row) not in columns:
        decimal = "; decimal commas are not understood" if "," in line and "." not in line else ""
        hint = "; a semicolon begins a comment" if ";" in line else decimal
        return f": {len(row)} numbers; allowed {' or '.join(map(str, columns))}{hint}"
    if not all(map(math.isfinite, row)):
        return " is not finite; remove or repair the point"
    if max(map(abs, row)) > LARGEST_NUMBER:
        return ": no length of a profile in any unit; remove or repair the point"
    return f": weight {row[2]:g}; it must not be negative" if len(row) == 3 and row[2] < 0 else ""


def _enough_left(path: Path, kept: int, count: int, key: str, of: str = "") -> None:
    """Refuse a header that leaves too few points: most often it is in another unit than they are."""
    if kept < FEWEST_POINTS:
        raise ProfileError(
            f"{path}: {key} leaves {kept} of {count} points{' ' + of if of else ''}; a profile has at least {FEWEST_POINTS}; are "
            "header and points in the same unit?"
        )
