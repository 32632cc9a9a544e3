"""Files that README, CONTRIBUTING, documentation, comments and docstrings name exist."""

from __future__ import annotations

import re
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[3]
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").rglob("*.md"))]
OURS = re.compile(r"`((?:core|python|bindings|tests|benchmarks|scripts|docs)/[\w./*-]+)")
TO_BE_MADE = re.compile(r"my_\w+|mine")
FOLDERS = ("core", "bindings", "python", "tests", "scripts", "benchmarks", "realtime", "fmu", "docs", "examples")
COMMENTS = {
    ".py": re.compile(r"#.*|\"{3}[\s\S]*?\"{3}"),
    **dict.fromkeys((".hpp", ".cpp", ".h"), re.compile(r"//.*|/\*[\s\S]*?\*/")),
}
IN_COMMENT = re.compile(
    r"(?<![\w./<*~-])((?:[\w-]+/)+[\w-]+\.(?:py|hpp|cpp|h|md|toml|json|js|css|npz)\b|"
    rf"(?:{'|'.join(FOLDERS)})/[\w/-]*\w(?![\w*.]))"
)
NOT_IN_THE_CHECKOUT = re.compile(r"/generated/|\b[A-Z]{4}\b")
"""Pages that the documentation's build writes; NAME and KIND in a pattern."""


@pytest.mark.parametrize(
    "page", [p for p in PAGES if "generated" not in p.parts], ids=lambda p: str(p.relative_to(ROOT))
)
def test_files_named_exist(page: Path) -> None:
    named = {name for name in OURS.findall(page.read_text(encoding="utf-8")) if not TO_BE_MADE.search(name)}
    assert sorted(name for name in named if not list(ROOT.glob(name.rstrip("/")))) == []


def missing(text: str, suffix: str, known: set[str]) -> list[str]:
    named = [path for comment in COMMENTS[suffix].findall(text) for path in IN_COMMENT.findall(comment)]
    return sorted(path for path in named if path not in known and not NOT_IN_THE_CHECKOUT.search(path))


def test_paths_in_comments_exist() -> None:
    """They may leave out leading folders."""
    paths = [p for folder in FOLDERS for p in (ROOT / folder).rglob("*")]
    known = {"/".join(p.parts[i:]) for p in paths for i in range(len(ROOT.parts), len(p.parts))}
    files = [p for p in paths if p.suffix in COMMENTS]
    found = {str(p.relative_to(ROOT)): missing(p.read_text(encoding="utf-8"), p.suffix, known) for p in files}
    assert {path: lost for path, lost in found.items() if lost} == {}
    assert missing("/// config/none.py, docs/conf.py", ".hpp", known) == ["config/none.py"]


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
