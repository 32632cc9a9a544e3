"""Words of pages, docstrings, messages and descriptions: a noun or a verb first, and the terms of the field."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PACKAGE = ROOT / "python" / "rollerrig"
PAGES = [ROOT / "README.md", *(p for p in (ROOT / "docs").rglob("*.md") if "generated" not in p.parts)]
NO_BEGINNING = re.compile(r"(?:of|and|or|but|with|by|for|from)\b", re.IGNORECASE)
ENTRY = re.compile(r'"description": "([^"]+)"|(?:^\S+ =|\b(?:is|label) =) "([^"]+)"', re.MULTILINE)
NO_TERM = re.compile(
    r"\b(crews?|told(?!: )|loses? patience|barren|doors?|wordings?|verdicts?|ventings|regrip\w*|askew|calm\w*|ringing|"
    r"rings?(?! buffers?)|stand(?:s|ing)? in)\b(?!_)",
    re.IGNORECASE,
)
"""Not terms of the field; better: assessment, dump cycle, readhesion, yaw misalignment, decay, oscillate, replace, is in."""
CODE = re.compile(r"^```.*?^```|`[^`]*`|\{[^{}]*\}", re.MULTILINE | re.DOTALL)


def strings(path: Path) -> Iterator[str]:
    """Docstrings and messages: strings of more than one word."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        match node:
            case ast.Constant(value=str(text)) if " " in text.strip():
                yield text


def docstrings(path: Path) -> Iterator[str]:
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        match node:
            case ast.Expr(value=ast.Constant(value=str(text))):
                yield text.strip()


def descriptions() -> Iterator[str]:
    """Descriptions of keys, quantities and shipped cases."""
    files = [*(PACKAGE / "catalog").rglob("*.json"), PACKAGE / "results" / "quantities.toml"]
    for path in [*files, *(PACKAGE / "catalog").rglob("*.toml")]:
        yield from (a or b for a, b in ENTRY.findall(path.read_text(encoding="utf-8")))


def test_docstrings_and_descriptions_begin_with_a_noun_or_a_verb() -> None:
    texts = [text for path in PACKAGE.rglob("*.py") for text in docstrings(path)] + list(descriptions())
    assert len(texts) > 5000
    assert [text.splitlines()[0] for text in texts if NO_BEGINNING.match(text)] == []


def test_pages_docstrings_and_messages_use_the_terms_of_the_field() -> None:
    texts = [(path.name, text) for path in PACKAGE.rglob("*.py") for text in strings(path)]
    texts += [(path.name, path.read_text(encoding="utf-8")) for path in PAGES]
    texts += [("descriptions", text) for text in descriptions()]
    found = [(name, word, text[:80]) for name, text in texts for word in NO_TERM.findall(CODE.sub("", text))]
    assert found == []


def test_a_word_that_is_no_term_is_found() -> None:
    assert NO_TERM.findall("Ventings, and a loop that rings; it stands in for the track, unless told otherwise.") == [
        "Ventings", "rings", "stands in", "told",
    ]  # fmt: skip
    assert (
        NO_TERM.findall(CODE.sub("", "venting; ring buffers; `verdict`, brake.motors_stand_in, regular, tolderance"))
        == []
    )
