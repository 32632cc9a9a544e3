"""Words of descriptions and docstrings: each begins with a noun or a verb."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PACKAGE = ROOT / "python" / "rollerrig"
NO_BEGINNING = re.compile(r"(?:of|and|or|but|with|by|for|from)\b", re.IGNORECASE)
ENTRY = re.compile(r'"description": "([^"]+)"|(?:^\S+ =|\bis =) "([^"]+)"', re.MULTILINE)


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
