"""The examples in the docstrings of the public names run and say what they say."""

from __future__ import annotations

import doctest
import inspect
import sys
from pathlib import Path

import pytest

import rollerrig as rr

LONG = {
    "adhesion", "compare", "control", "lateral", "paper", "response", "scale", "wsp", "limit_cycle", "serve", "export",
    "export_fmu", "read_model", "reconstruct", "replay", "tune",
}  # fmt: skip
"""Studies of minutes, and what needs files or a partner: examples/, docs/how_to and their own tests run them."""

ERRORS = {
    name for name in rr.__all__ if inspect.isclass(getattr(rr, name)) and issubclass(getattr(rr, name), Exception)
}
NAMES = [name for name in rr.__all__ if name not in ("__version__", "plot")]


@pytest.mark.parametrize("name", [name for name in NAMES if ">>>" in (inspect.getdoc(getattr(rr, name)) or "")])
def test_the_example_of_a_public_name_runs(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)  # one writes a page
    value = getattr(rr, name)
    module = sys.modules[value.__module__]
    (example,) = doctest.DocTestFinder(recurse=False).find(value, name, module=False, globs=dict(vars(module)))
    out: list[str] = []
    result = doctest.DocTestRunner(optionflags=doctest.IGNORE_EXCEPTION_DETAIL).run(example, out=out.append)
    assert result.failed == 0, "".join(out)
    assert result.attempted > 0


def test_every_public_name_that_is_quick_has_an_example() -> None:
    without = {name for name in NAMES if ">>>" not in (inspect.getdoc(getattr(rr, name)) or "")}
    assert without - LONG - ERRORS == set()
