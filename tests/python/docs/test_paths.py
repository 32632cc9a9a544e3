"""Files that README, CONTRIBUTING and documentation name exist."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[3]
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").rglob("*.md"))]
OURS = re.compile(r"`((?:core|python|bindings|tests|benchmarks|scripts|docs)/[\w./*-]+)")
TO_BE_MADE = re.compile(r"my_\w+|mine")


@pytest.mark.parametrize(
    "page", [p for p in PAGES if "generated" not in p.parts], ids=lambda p: str(p.relative_to(ROOT))
)
def test_files_named_exist(page: Path) -> None:
    named = {name for name in OURS.findall(page.read_text(encoding="utf-8")) if not TO_BE_MADE.search(name)}
    assert sorted(name for name in named if not list(ROOT.glob(name.rstrip("/")))) == []
