"""Ranges on the command line: `-8:8:0.5` counts from -8 to 8, both included."""

import math
import re
from fractions import Fraction

import typer

MOST_VALUES = 100_000
HIGHEST_KMH = 720.0
"""200 m/s, the end of the range of motion.speed."""
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d{1,2})?")
_DASHED = re.compile(r"(\d+\.?\d*)(?: ?- ?|\.\.\.?| ?to )(\d+\.?\d*)")
_FORMS = "write one number, a list like 1,2,5, or start:stop:step like -8:8:0.5"


def read_range(text: str, option: str) -> list[float]:
    """The numbers of a range, a list or a single number.

    Decimal steps are counted exactly: -8:8:0.1 meets 0 and 0.3, not their neighbours.

    Args:
        text: what the user wrote.
        option: the option it stands for, as written on the command line.

    Raises:
        typer.BadParameter: not a range; the message says what is allowed.
    """
    parts = text.split(":")
    if len(parts) == 1:
        return [float(_number(part, option)) for part in text.split(",")]
    if len(parts) != 3:
        raise _bad(option, f"'{text}' has {len(parts)} parts; {_FORMS}")
    start, stop, step = (_number(part, option) for part in parts)
    if step == 0:
        raise _bad(option, f"'{text}': the step is zero; {_FORMS}")
    if (stop - start) / step < 0:
        raise _bad(option, f"'{text}' never gets from {parts[0]} to {parts[1]}; change the sign of the step {parts[2]}")
    count = (stop - start) // step + 1
    if count > MOST_VALUES:
        raise _bad(option, f"'{text}' has {count} values; at most {MOST_VALUES} are allowed, take a larger step")
    return [float(start + i * step) for i in range(count)]


def read_speeds(text: str) -> tuple[float, ...]:
    """The speeds of `--speeds-kmh` [km/h]; a typer.BadParameter where they are not positive and rising."""
    speeds = read_range(text, "--speeds-kmh")
    if speeds[0] <= 0 or any(b <= a for a, b in zip(speeds, speeds[1:], strict=False)):
        raise _bad("--speeds-kmh", f"'{text}': speeds must be positive and rise")
    if speeds[-1] > HIGHEST_KMH:
        raise _bad("--speeds-kmh", f"'{text}' goes to {speeds[-1]:g} km/h; allowed: up to {HIGHEST_KMH:g} km/h")
    return tuple(speeds)


def check_finite(value: float | None, option: str) -> None:
    """Refuse `nan` and `inf`, which the parser of the command line takes for numbers, with a typer.BadParameter."""
    if value is not None and not math.isfinite(value):
        raise _bad(option, f"'{value}' is not a finite number")


def _number(text: str, option: str) -> Fraction:
    if not _NUMBER.fullmatch(text.strip()):
        raise _bad(option, f"'{text}' is not a number; {_FORMS}{_meant(text)}")
    return Fraction(text.strip())


def _meant(text: str) -> str:
    """The range that was probably meant by '60-100' or '60..100', "" where it was something else."""
    ends = _DASHED.fullmatch(text.strip())
    if ends is None or not float(ends[1]) < float(ends[2]):
        return ""
    return f"; did you mean {ends[1]}:{ends[2]}:{(float(ends[2]) - float(ends[1])) / 10:g}?"


def _bad(option: str, message: str) -> typer.BadParameter:
    return typer.BadParameter(message, param_hint=option)
