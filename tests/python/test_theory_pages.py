"""The theory pages: equations in order and each letter on one page only, as the table of pages says; sources; references."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
THEORY = ROOT / "docs" / "theory"
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


@pytest.mark.parametrize("page", PAGES)
def test_equations_are_numbered_in_order(page: str) -> None:
    found = re.findall(r"\\tag\{([A-Z]?)(\d+)\}", (THEORY / f"{page}.md").read_text())
    own = {letter: [int(n) for which, n in found if which == letter] for letter, _ in found}
    of_the_paper = own.pop("", [])
    assert of_the_paper == sorted(set(of_the_paper))
    for letter, numbers in own.items():
        first = 0 if letter == "K" else 1
        assert numbers == list(range(first, first + len(numbers))), letter


@pytest.mark.parametrize("page", PAGES)
def test_every_page_names_its_sources(page: str) -> None:
    assert "\n## Sources\n" in (THEORY / f"{page}.md").read_text()


def test_every_equation_referred_to_exists() -> None:
    text = "".join((THEORY / f"{page}.md").read_text() for page in PAGES)
    known = set(re.findall(r"\\tag\{([A-Z]\d+)\}", text))
    letters = {name[0] for name in known}
    files = [path for folder in ("core", "python", "docs", "tests") for path in (ROOT / folder).rglob("*.[hcmp]*")]
    for path in files:
        if path.suffix in (".hpp", ".cpp", ".py", ".md") and "generated" not in path.parts:
            for name in re.findall(r"\(([A-Z]\d{1,2})\)", path.read_text(encoding="utf-8")):
                assert name in known or name[0] not in letters, f"{path.relative_to(ROOT)}: ({name})"
