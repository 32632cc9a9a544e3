"""Sphinx extension: the page of the public Python names, from `rollerrig.__all__` and `rollerrig.plot.__all__`.

public names -> docstrings -> [this file] -> reference/generated/python.md, rendered by autodoc
"""

from __future__ import annotations

import inspect
from pathlib import Path
from types import ModuleType

from sphinx.application import Sphinx


def write_reference(app: Sphinx) -> None:
    """Write the directives that reference/python.md includes."""
    import rollerrig
    import rollerrig.plot

    target = Path(app.srcdir) / "reference" / "generated" / "python.md"
    text = "\n".join([*section(rollerrig), *section(rollerrig.plot)])
    target.parent.mkdir(exist_ok=True)
    if not target.is_file() or target.read_text() != text:  # an unchanged file keeps its date: no rebuild
        target.write_text(text)


def section(module: ModuleType) -> list[str]:
    """Heading and one directive per public name: functions, then classes."""
    name = module.__name__
    found = {public: getattr(module, public) for public in sorted(module.__all__)}
    lines = [f"## `{name}`", "", "```{eval-rst}", f".. currentmodule:: {name}", ""]
    for public in (n for n, value in found.items() if inspect.isfunction(value)):
        lines += [f".. autofunction:: {public}", ""]
    for public, value in found.items():
        if inspect.isclass(value):
            methods = [n for n, member in vars(value).items() if inspect.isfunction(member) and not n.startswith("_")]
            lines += [f".. autoclass:: {public}()", *([f"   :members: {', '.join(methods)}"] if methods else []), ""]
    return [*lines, "```", ""]


def setup(app: Sphinx) -> dict[str, bool]:
    """Register with Sphinx."""
    app.connect("builder-inited", write_reference)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
