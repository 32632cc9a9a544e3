"""Studies: what is run, what is reported, what the models leave out.

analysis, plot -> [study] -> summary.json, data, figures, report.html

A study is one file of this folder: a class, a `Study` of frame.py, and under `@command` the function that the package and the
command line have by its name. Both find it here, in the text of the file: no module is loaded before it is used.
"""

import re
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any

_HEAD = re.compile(r'^@command\n(def (\w+)\(.*?""".*?"""\n)', re.MULTILINE | re.DOTALL)


def _files() -> list[Path]:
    return [path for folder in __path__ for path in Path(folder).glob("[!_]*.py")]


@cache
def heads() -> dict[str, tuple[str, str]]:
    """Functions under `@command` in alphabetical order: name -> its module, and its text down to the end of the docstring."""
    texts = {path.stem: path.read_text(encoding="utf-8") for path in _files()}
    found = {name: (f"study.{stem}", head) for stem, text in texts.items() for head, name in _HEAD.findall(text)}
    return dict(sorted(found.items()))


def studies() -> list[Any]:
    """The classes of studies, in the order of their commands."""
    for path in _files():
        import_module(f"{__name__}.{path.stem}")
    found = import_module(f"{__name__}.frame").Study.__subclasses__()
    return sorted((one for one in found if one.__module__.startswith(__name__)), key=lambda one: str(one.command))
