"""Words of pages, docstrings, messages and descriptions: a noun or a verb first, and the terms of the field."""

from __future__ import annotations

import ast
import re
from functools import cache
from pathlib import Path

from rollerrig import _core

ROOT = Path(__file__).resolve().parents[2]
PACKAGE = ROOT / "python" / "rollerrig"
PAGES = [ROOT / "README.md", *(p for p in (ROOT / "docs").rglob("*.md") if "generated" not in p.parts)]
FILES = [*(PACKAGE / "catalog").rglob("*.json"), *PACKAGE.rglob("*.toml")]
ENTRY = re.compile(r'(?:"description":|^\S+ =|\b(?:is|label) =) "([^"]+)"', re.MULTILINE)
NO_BEGINNING = re.compile(r"\s*(?:of|and|or|but|with|by|for|from)\b", re.IGNORECASE)
NO_TERM = re.compile(
    r"\b(crews?|told(?!: )|loses? patience|barren|doors?|wordings?|verdicts?|judge\w*|ventings|regrip\w*|askew|calm\w*|"
    r"ringing|rings?(?! buffers?)|stand(?:s|ing)? in)\b(?!_)",
    re.IGNORECASE,
)
"""Better: assessment, dump cycle, readhesion, yaw misalignment, decay, oscillate, replace, is in."""
CODE = re.compile(r"^```.*?^```|`[^`]*`|\{[^{}]*\}", re.MULTILINE | re.DOTALL)


@cache
def nodes() -> list[ast.AST]:
    return [node for path in PACKAGE.rglob("*.py") for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))]


def descriptions() -> list[str]:
    return [text for path in FILES for text in ENTRY.findall(path.read_text(encoding="utf-8"))]


def test_docstrings_and_descriptions_begin_with_a_noun_or_a_verb() -> None:
    docstrings = [str(n.value.value) for n in nodes() if isinstance(n, ast.Expr) and isinstance(n.value, ast.Constant)]
    assert min(len(docstrings), len(descriptions())) > 2000
    assert [text for text in docstrings + descriptions() if NO_BEGINNING.match(text)] == []


def test_pages_docstrings_and_messages_use_the_terms_of_the_field() -> None:
    strings = [node.value for node in nodes() if isinstance(node, ast.Constant) and isinstance(node.value, str)]
    messages = [text for text in strings if " " in text.strip()]  # a single word is a key
    texts = messages + descriptions() + [path.read_text(encoding="utf-8") for path in PAGES]
    assert [(word, text[:80]) for text in texts for word in NO_TERM.findall(CODE.sub("", text))] == []
    assert NO_TERM.findall("Ventings; a loop rings: `verdict`, ring buffer") == ["Ventings", "rings", "verdict"]


def test_descriptions_of_keys_begin_with_a_noun_or_a_verb() -> None:
    tables = [
        node
        for node in nodes()
        if isinstance(node, ast.Call) and getattr(node.func, "id", "") in ("needed", "optional")
    ]
    texts = [str(one.value) for node in tables for one in node.args[-1:] if isinstance(one, ast.Constant)]
    assert len(texts) > 350
    no_noun = re.compile(
        r"(?:what|how|on|at|in|below|above|after|when|where|who|which|that|times|its|as|over|without)\b"
    )
    assert [text for text in texts if no_noun.match(text)] == []


def test_meanings_of_recorded_quantities_begin_with_a_noun_or_a_verb() -> None:
    """Also those of the variables of an FMU."""
    tables = [getattr(_core, name) for name in dir(_core) if name.endswith("_fields") and name != "reading_fields"]
    meanings = [field[2] for table in tables for field in table]
    assert len(meanings) > 120
    no_noun = re.compile(r"\s*(?:of|and|or|but|with|by|for|from|that|since|in|on|what|how)\b")
    assert [text for text in meanings if no_noun.match(text)] == []


def test_keys_of_summaries_use_the_terms_of_the_field() -> None:
    keys = re.findall(
        r'^"?([\w.*]+)"? =', (PACKAGE / "results" / "quantities.toml").read_text(encoding="utf-8"), re.MULTILINE
    )
    assert len(keys) > 400
    words = re.compile(r"verdict|venting|regrip|asked|wanted|ringing|askew|judged")
    assert [key for key in keys if words.search(key)] == []
