"""Ranges as they are written on the command line."""

from __future__ import annotations

import pytest
import typer

from rollerrig.cli.ranges import read_range, read_speeds


@pytest.mark.parametrize(
    ("text", "values"),
    [
        ("3", [3.0]),
        ("-0.5", [-0.5]),
        ("1,2, 5", [1.0, 2.0, 5.0]),
        ("0:3:1", [0.0, 1.0, 2.0, 3.0]),
        ("3:0:-1.5", [3.0, 1.5, 0.0]),
        ("0:1:0.4", [0.0, 0.4, 0.8]),
        ("2:2:1", [2.0]),
        ("0:2e-1:1e-1", [0.0, 0.1, 0.2]),
    ],
)
def test_ranges(text: str, values: list[float]) -> None:
    assert read_range(text, "--x") == values


def test_decimal_steps_are_exact() -> None:
    values = read_range("-8:8:0.1", "--x")
    assert len(values) == 161
    assert {0.0, 0.3, 8.0, -7.9} <= set(values)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "is not a number"),
        ("nan", "'nan' is not a number"),
        ("inf", "is not a number"),
        ("1:2", "has 2 parts"),
        ("1:2:3:4", "has 4 parts"),
        ("1:2:0", "the step is zero"),
        ("1:2:-1", "change the sign of the step"),
        ("0:1:1e-9", "at most 100000"),
        ("0:x:1", "'x' is not a number"),
        ("1e999", "is not a number"),
    ],
)
def test_mistakes(text: str, message: str) -> None:
    with pytest.raises(typer.BadParameter, match=message):
        read_range(text, "--x")


@pytest.mark.parametrize(
    ("text", "meant"),
    [("60-100", "60:100:4"), ("60..100", "60:100:4"), ("0.5 - 1", "0.5:1:0.05"), ("60 to 100", "60:100:4")],
)
def test_a_range_with_a_dash_is_told_how_it_is_written(text: str, meant: str) -> None:
    with pytest.raises(typer.BadParameter, match=f"did you mean {meant}"):
        read_range(text, "--speeds-kmh")


def test_a_speed_beyond_all_trains_is_refused() -> None:
    with pytest.raises(typer.BadParameter, match="goes to 6000 km/h; allowed: up to 720 km/h"):
        read_speeds("60,6000")
