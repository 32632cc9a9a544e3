"""The pages of the tutorial as Jupyter notebooks: docs/tutorial/notebooks/*.ipynb.

    python scripts/write_notebooks.py

Text between blocks becomes cells of text, Python cells of code with what they print, and a block that is a file (`# wagon.toml`)
a cell that writes it. The pages are the source; a test compares the notebooks with them.
"""

from __future__ import annotations

import json
import re
import textwrap
from pathlib import Path
from typing import Any

TUTORIAL = Path(__file__).resolve().parent.parent / "docs" / "tutorial"
NOTEBOOKS = TUTORIAL / "notebooks"
PAGES = tuple(page for page in sorted(TUTORIAL.glob("*.md")) if page.name != "index.md")
_BLOCK = re.compile(r"^```([a-z]*)\n(.*?)^```\n?", re.MULTILINE | re.DOTALL)
_REFERENCE = re.compile(r"\{doc\}`(?:([^`<]*) <)?([^`>]*)>?`")


def notebook(page: Path) -> dict[str, Any]:
    """A page as a notebook, in the form that nbformat 4.5 gives it."""
    text, cells, at = page.read_text(encoding="utf-8"), [], 0
    for found in _BLOCK.finditer(text):
        language, code = found[1], textwrap.dedent(found[2]).rstrip("\n")
        name = re.match(r"# (\w+\.toml)\n", code) if language == "toml" else None
        last = cells[-1] if cells and not text[at : found.start()].strip() else None
        if language not in ("python", "text") and not name:
            continue
        if language == "text" and (last is None or last["cell_type"] != "code"):
            continue
        _add_text(cells, text[at : found.start()])
        at = found.end()
        if language == "text" and last is not None:
            last["outputs"] = [{"name": "stdout", "output_type": "stream", "text": _lines(f"{code}\n")}]
            continue
        source = f"%%writefile {name[1]}\n{code}" if name else code
        cells.append(
            {"cell_type": "code", "execution_count": None, "metadata": {}, "outputs": [], "source": _lines(source)}
        )
    _add_text(cells, text[at:])
    for number, cell in enumerate(cells):
        cell["id"] = f"{page.stem.replace('_', '-')}-{number}"
    kernel = {"display_name": "Python 3", "language": "python", "name": "python3"}
    metadata = {"kernelspec": kernel, "language_info": {"name": "python"}}
    return {"cells": cells, "metadata": metadata, "nbformat": 4, "nbformat_minor": 5}


def text_of(page: Path) -> str:
    """The file of a page's notebook."""
    return json.dumps(notebook(page), indent=1, ensure_ascii=False, sort_keys=True) + "\n"


def _add_text(cells: list[dict[str, Any]], text: str) -> None:
    """A cell of text; references within the documentation become the names of their pages."""
    plain = _REFERENCE.sub(lambda found: f"*{found[1] or found[2].strip('/').replace('_', ' ')}*", text).strip()
    if plain:
        cells.append({"cell_type": "markdown", "metadata": {}, "source": _lines(plain)})


def _lines(text: str) -> list[str]:
    return text.splitlines(keepends=True)


def main() -> None:
    """Write all."""
    NOTEBOOKS.mkdir(exist_ok=True)
    for page in PAGES:
        (NOTEBOOKS / f"{page.stem}.ipynb").write_text(text_of(page), encoding="utf-8")


if __name__ == "__main__":
    main()
