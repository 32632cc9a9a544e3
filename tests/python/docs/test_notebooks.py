"""Notebooks of the tutorial: what their pages say, valid, and run from their top to their end with what they print."""

from __future__ import annotations

import contextlib
import importlib.util
import io
import json
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).resolve().parents[3]
spec = importlib.util.spec_from_file_location("write_notebooks", ROOT / "scripts" / "write_notebooks.py")
assert spec is not None
assert spec.loader is not None
write_notebooks = importlib.util.module_from_spec(spec)
spec.loader.exec_module(write_notebooks)
NAMES = [page.stem for page in write_notebooks.PAGES]


def read(name: str) -> str:
    return (write_notebooks.NOTEBOOKS / f"{name}.ipynb").read_text(encoding="utf-8")


@pytest.mark.parametrize("name", NAMES)
def test_a_notebook_is_its_page(name: str) -> None:
    assert read(name) == write_notebooks.text_of(write_notebooks.TUTORIAL / f"{name}.md"), (
        "python scripts/write_notebooks.py"
    )


def test_there_is_one_for_each_step_and_they_are_valid() -> None:
    nbformat = pytest.importorskip("nbformat")
    assert len(NAMES) == 5
    assert sorted(NAMES) == sorted(path.stem for path in write_notebooks.NOTEBOOKS.glob("*.ipynb"))
    for name in NAMES:
        nbformat.validate(nbformat.reads(read(name), 4))


@pytest.mark.parametrize(
    "name", [name if name == "own_vehicle" else pytest.param(name, marks=pytest.mark.long) for name in NAMES]
)
def test_a_notebook_runs_and_prints_what_it_shows(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    session: dict[str, Any] = {"__name__": "__main__"}
    for cell in json.loads(read(name))["cells"]:
        source = "".join(cell["source"])
        if cell["cell_type"] != "code":
            continue
        if source.startswith("%%writefile "):
            first, _, text = source.partition("\n")
            Path(first.removeprefix("%%writefile ")).write_text(text)
            continue
        with contextlib.redirect_stdout(io.StringIO()) as out:
            exec(compile(source, name, "exec"), session)
        for shown in cell["outputs"]:
            assert out.getvalue().rstrip() == "".join(shown["text"]).rstrip()
