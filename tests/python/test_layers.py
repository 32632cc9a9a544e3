"""The arrow of the data is a test: a folder may use only what stands to its left.

core:    scalar -> math -> integrate -> track -> multibody -> geometry -> contact -> mechatronics -> system -> simulate
Python:  profiles, track, irregularity -> config -> catalog -> cases -> creep -> assembly -> results -> starting_state -> bench
         -> simulation -> similitude -> characteristics -> analysis -> plot -> report -> study -> studies -> cli
"""

from __future__ import annotations

import ast
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
CORE = ROOT / "core" / "include" / "rollerrig"
PACKAGE = ROOT / "python" / "rollerrig"

# A header directly in rollerrig/ is named with its ending; a folder without.
CORE_LAYERS = [
    {"scalar.hpp", "status.hpp"},
    {"math"},
    {"integrate"},
    {"track"},
    {"multibody"},
    {"geometry"},
    {"contact"},
    {"mechatronics"},
    {"system"},
    {"simulate"},
]
"""From left to right."""

CORE_MAY_NOT_SEE = {
    "contact": {"multibody"},  # a force law never sees a body
}
"""Pairs that the order alone would allow; only `system` knows both sides."""


def core_layer(path: str) -> int:
    first = path.split("/")[0]
    for number, names in enumerate(CORE_LAYERS):
        if first in names:
            return number
    pytest.fail(f"rollerrig/{path} has no place on the arrow: add it to CORE_LAYERS")


@pytest.mark.parametrize("header", sorted(CORE.rglob("*.hpp")), ids=lambda p: str(p.relative_to(CORE)))
def test_includes_point_left(header: Path) -> None:
    own = header.relative_to(CORE).as_posix()
    for target in re.findall(r'#include "rollerrig/([^"]+)"', header.read_text()):
        assert (CORE / target).is_file(), f"rollerrig/{own} includes rollerrig/{target}, which does not exist"
        assert core_layer(target) <= core_layer(own), f"rollerrig/{own} may not include rollerrig/{target}"
        forbidden = CORE_MAY_NOT_SEE.get(own.split("/")[0], set())
        assert target.split("/")[0] not in forbidden, f"rollerrig/{own} may not include rollerrig/{target}"


@pytest.mark.parametrize("source", sorted((ROOT / "core").rglob("*.[hc]pp")), ids=lambda p: str(p.relative_to(ROOT)))
def test_the_core_knows_no_python_no_files_no_clock(source: Path) -> None:
    includes = re.findall(r"#include [<\"]([^>\"]+)[>\"]", source.read_text())
    unwanted = {"fstream", "filesystem", "iostream", "chrono", "ctime", "cstdio", "random", "Python.h"}
    assert not unwanted & set(includes)
    assert not [name for name in includes if name.startswith(("nanobind", "pybind"))]


PYTHON_LAYERS = [
    {"_core", "_version"},
    {"profiles", "track", "irregularity"},
    {"config"},
    {"catalog"},
    {"cases"},
    {"creep"},
    {"assembly"},
    {"results"},
    {"starting_state"},
    {"bench"},
    {"simulation", "contact_table"},
    {"contact_comparison"},
    {"similitude"},
    {"characteristics"},
    {"analysis"},
    {"plot"},
    {"report"},
    {"study"},
    {"studies"},
    {"cli"},
]
"""From left to right; what `rollerrig/__init__.py` itself defines is open to all."""

PYTHON_MAY_NOT_SEE = {
    "profiles": {"_core"},  # curves are made in Python and handed to the core by model
    "track": {"_core", "profiles", "irregularity"},  # a line of numbers
    "irregularity": {"_core", "profiles", "track"},
    "config": {"_core"},  # a file is checked without the extension
    "plot": {"_core", "assembly", "simulation"},  # a figure takes results and computes no physics
    "cli": {"_core"},  # ten lines over the public interface
}
"""Pairs that the order alone would allow."""


def python_layer(name: str) -> int:
    for number, names in enumerate(PYTHON_LAYERS):
        if name in names:
            return number
    pytest.fail(f"rollerrig.{name} has no place on the arrow: add it to PYTHON_LAYERS")


def imported_parts(source: Path) -> set[str]:
    """First name below `rollerrig` of everything a file imports, also inside functions."""
    package = ("rollerrig", *source.relative_to(PACKAGE).parts[:-1])
    found: set[str] = set()
    for node in ast.walk(ast.parse(source.read_text(), str(source))):
        if isinstance(node, ast.Import):
            modules = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            base = ".".join(package[: len(package) - node.level + 1]) if node.level else ""
            module = ".".join(part for part in (base, node.module or "") if part)
            modules = [f"{module}.{alias.name}" for alias in node.names] if module == "rollerrig" else [module]
        else:
            continue
        found |= {m.split(".")[1] for m in modules if m.startswith("rollerrig.")}
    return {
        name for name in found if (PACKAGE / name).is_dir() or (PACKAGE / f"{name}.py").is_file() or name == "_core"
    }


@pytest.mark.parametrize("source", sorted(PACKAGE.rglob("*.py")), ids=lambda p: str(p.relative_to(PACKAGE)))
def test_imports_point_left(source: Path) -> None:
    own = source.relative_to(PACKAGE).parts[0].removesuffix(".py")
    if own in {"__init__", "__main__"}:
        return
    for target in imported_parts(source):
        assert python_layer(target) <= python_layer(own), f"{own} may not import rollerrig.{target}"
        assert target not in PYTHON_MAY_NOT_SEE.get(own, set()), f"{own} may not import rollerrig.{target}"
