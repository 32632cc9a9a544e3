"""docs/validation.md says what the comparisons give today."""

from __future__ import annotations

import re
from collections.abc import Callable

import pytest

from validation import test_creep_laws, write_tables

NUMBER = re.compile(r"[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?")


def close(one: str, other: str) -> bool:
    """To the last digit printed; an energy residual, one digit of round-off, within a factor of four."""
    a, b = float(one), float(other)
    mantissa, _, exponent = one.partition("e")
    decimals = len(mantissa.partition(".")[2])
    if exponent and not decimals:
        return 0.25 <= a / b <= 4.0
    return abs(a - b) <= 1.01 * 10.0 ** (int(exponent or 0) - decimals)


def differences(written: str, today: str) -> list[tuple[str, str]]:
    """Lines that differ in words or in numbers."""
    pairs = list(zip(written.strip().splitlines(), today.strip().splitlines(), strict=True))
    return [
        (a, b)
        for a, b in pairs
        if NUMBER.sub("#", a) != NUMBER.sub("#", b)
        or not all(close(*numbers) for numbers in zip(NUMBER.findall(a), NUMBER.findall(b), strict=True))
    ]


@pytest.mark.slow
@pytest.mark.parametrize("section", write_tables.SECTIONS, ids=lambda section: section.__name__)
def test_the_page_is_what_the_comparisons_give(section: Callable[[], str]) -> None:
    # All cases of the exact solver take a minute: its rows are left out.
    some_laws = section is write_tables.creep_laws
    today = write_tables.creep_laws(test_creep_laws.LAWS) if some_laws else section()
    title = today.splitlines()[0]
    _, found, rest = write_tables.PAGE.read_text(encoding="utf-8").partition(f"{title}\n")
    assert found
    written = f"{title}\n" + re.split(r"^## ", rest, flags=re.MULTILINE)[0]
    if some_laws:
        written = "".join(line for line in written.splitlines(keepends=True) if not line.startswith("| exact solver"))
    assert differences(written, today) == []
