"""Files that README, CONTRIBUTING and documentation name exist."""

from __future__ import annotations

import re
import subprocess
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


def test_the_top_folder_holds_what_belongs_there() -> None:
    """Of the files that git knows: a page that a test once wrote there was committed twice."""
    done = subprocess.run(["git", "-C", str(ROOT), "ls-files", ":(glob)*"], capture_output=True, text=True, check=False)
    if done.returncode:
        pytest.skip("not a checkout")
    own = {
        "CHANGELOG.md",
        "CITATION.cff",
        "CMakeLists.txt",
        "CONTRIBUTING.md",
        "LICENSE",
        "README.md",
        "pyproject.toml",
    }
    found = {name for name in done.stdout.split() if not name.startswith(".")}
    assert found == own | {"requirements-dev.lock"}
