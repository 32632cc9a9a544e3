"""The table of the theory pages: each page with the equations it has, each equation's letter on one page only."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

THEORY = Path(__file__).parents[2] / "docs" / "theory"
PAGES = sorted(page.stem for page in THEORY.glob("*.md") if page.stem != "index")


def tags(page: str) -> dict[str, int]:
    """Letter -> highest number of the page's own equations."""
    found: dict[str, int] = {}
    for letter, number in re.findall(r"\\tag\{([A-Z])(\d+)\}", (THEORY / f"{page}.md").read_text()):
        found[letter] = max(found.get(letter, 0), int(number))
    return found


@pytest.mark.parametrize("page", PAGES)
def test_the_table_has_the_equations_of_each_page(page: str) -> None:
    row = next(line for line in (THEORY / "index.md").read_text().splitlines() if line.startswith(f"| {{doc}}`{page}`"))
    listed = {letter: int(number) for letter, number in re.findall(r"–\(([A-Z])(\d+)\)", row)}
    assert listed == tags(page)


def test_a_letter_belongs_to_one_page() -> None:
    owners: dict[str, str] = {}
    for page in PAGES:
        for letter in tags(page):
            assert owners.setdefault(letter, page) == page
