"""What stands on the terminal: whole sentences, whole words, no negative zeros, nothing of the libraries beneath."""

from __future__ import annotations

import logging

import pytest

from called import called
from rollerrig.cli.termination import folded
from rollerrig.config.schema import units


def test_the_list_of_commands_cuts_nothing_off() -> None:
    text = called("--help").stdout.partition("Commands:")[2]
    assert "..." not in text
    assert "…" not in text
    assert "checks against theory, one report." in " ".join(text.split())


def test_long_lines_are_folded_between_words() -> None:
    text = "Hunting, amplitude of the leading-wheelset before the slide\nand 12345678901234567890123456789012345 later"
    lines = folded(text, 30).split("\n")
    assert " ".join(" ".join(lines).split()) == text.replace("\n", " ")
    assert all(len(line) <= 30 or " " not in line.strip() for line in lines)
    assert "leading-wheelset" in " ".join(lines).split()
    assert folded("short", 80) == "short"


@pytest.mark.parametrize("case", ["bogie_rollers_constant", "vehicle_curve"])
def test_a_check_prints_no_negative_zero(case: str) -> None:
    """Lateral forces of symmetric wheels are round-off of either sign."""
    found = called("check", case)
    assert found.exit_code == 0
    words = found.stdout.replace(",", " ").split()
    assert [word for word in words if word.startswith("-0") and not any(digit in "123456789" for digit in word)] == []


def test_the_library_of_units_says_nothing(caplog: pytest.LogCaptureFixture) -> None:
    """It has a yarn count of its own by the name of our Nm."""
    units._registry.cache_clear()
    with caplog.at_level(logging.WARNING):
        assert units.unit_factor("kNm", "N m") == 1000
    assert caplog.messages == []
