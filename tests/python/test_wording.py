"""Numbers as people write them: no exponents of computers, no negative zero, no round-off for a result."""

from __future__ import annotations

import math
import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rollerrig.common.formatting import number, percent

THIN = "\u202f"


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0.0, "0"),
        (1.23456, "1.235"),
        (12345.6, "12\u202f346"),
        (2, "2"),
        (1e-7, "10⁻⁷"),
        (-1.438e-5, "-1.438·10⁻⁵"),
        (-0.0, "0"),
        (math.nan, "–"),
        ("x", "x"),
    ],
)
def test_numbers_are_written_as_people_do(value: object, text: str) -> None:
    assert number(value) == text


@pytest.mark.parametrize(
    ("value", "digits", "text"),
    [
        (3141.6, 2, "3142"),
        (3100.0, 2, "3100"),
        (9999.96, 4, f"10{THIN}000"),
        (999_999.9, 4, f"1{THIN}000{THIN}000"),
        (0.0123, 4, "0.0123"),
        (-0.00004, 1, "-4·10⁻⁵"),
        (99.96, 3, "100"),
    ],
)
def test_no_exponent_where_digits_are_few(value: float, digits: int, text: str) -> None:
    assert number(value, digits) == text


def test_round_off_is_no_result() -> None:
    assert percent(-0.0) == "0 %"
    assert percent(0.0123, signed=True) == "+1.2 %"
    assert percent(None) == "–"


@given(st.floats(-1e300, 1e300), st.integers(1, 9))
def test_a_number_reads_back_to_its_digits(value: float, digits: int) -> None:
    text = number(value, digits)
    assert "e" not in text
    assert not text.startswith("-0") or text.startswith("-0.")
    found = re.fullmatch(r"(?:(-?[\d.]+)·)?10([⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+)", text)
    mantissa, power = (found[1] or "1", found[2]) if found else (text.replace(THIN, ""), "⁰")
    read = float(mantissa) * 10.0 ** int(power.translate(str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789")))
    assert read == pytest.approx(value, rel=0.51 * 10.0 ** (1 - digits), abs=1e-300)
