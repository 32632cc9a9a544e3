"""The arrow of the data is a test: a folder may use only what stands to its left.

core:    scalar -> math -> integrate -> track -> multibody -> geometry -> contact -> mechatronics -> system -> simulate -> plant
Python:  common, profiles, track, irregularity, config, catalog, cases -> assembly, results -> simulation, interfaces
         -> similitude, contact_analysis, analysis -> plot, viewer, study -> cli
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterable, Mapping
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
CORE = ROOT / "core" / "include" / "rollerrig"
CORE_SOURCES = ROOT / "core" / "src"
PACKAGE = ROOT / "python" / "rollerrig"

CORE_LAYERS = [
    {"scalar.hpp", "status.hpp"},
    {"math"},
    {"range.hpp"},
    {"fields.hpp"},
    {"integrate"},
    {"track"},
    {"multibody"},
    {"geometry"},
    {"contact/material.hpp", "contact/regularisation.hpp", "contact/patch_strips.hpp"},
    {"contact/normal", "contact/adhesion"},
    {"contact/creep"},
    {"contact"},
    {"mechatronics"},
    {"system"},
    {"simulate"},
    {"plant"},
]
"""From left to right: folders, or single headers with their ending. What stands together does not see each other."""

CORE_MAY_NOT_SEE = {
    "contact": {"multibody"},  # a force law never sees a body
    "contact/creep": {"contact/normal", "geometry"},  # a creep law gets the ellipse as numbers
    "mechatronics": {"multibody", "geometry", "track"},  # blocks with inputs and outputs
}
"""Pairs that the order alone would allow; only `system` knows both sides. A folder stands for those in it, too."""


def core_layer(path: str) -> tuple[int, str]:
    """Number and name of the layer of a file, given below rollerrig/."""
    names = {name: number for number, layer in enumerate(CORE_LAYERS) for name in layer}
    parts = path.split("/")
    for count in range(len(parts), 0, -1):
        if (name := "/".join(parts[:count])) in names:
            return names[name], name
    pytest.fail(f"rollerrig/{path} has no place on the arrow: add it to CORE_LAYERS")


def core_includes(file: Path) -> list[str]:
    return re.findall(r'#include "rollerrig/([^"]+)"', file.read_text())


def test_includes_point_left() -> None:
    for file in sorted([*CORE.rglob("*.hpp"), *CORE_SOURCES.rglob("*.[hc]pp")]):
        own = file.relative_to(CORE_SOURCES if file.is_relative_to(CORE_SOURCES) else CORE).as_posix()
        number, name = core_layer(own)
        forbidden = {
            other for folder, others in CORE_MAY_NOT_SEE.items() for other in others if own.startswith(f"{folder}/")
        }
        for target in core_includes(file):
            assert (CORE / target).is_file(), f"{own} includes rollerrig/{target}, which does not exist"
            target_number, target_name = core_layer(target)
            assert target_number < number or target_name == name, f"{own} may not include rollerrig/{target}"
            assert not any(target.startswith(f"{folder}/") for folder in forbidden), (
                f"{own} may not include rollerrig/{target}"
            )


def circle(graph: Mapping[str, Iterable[str]]) -> list[str]:
    """A closed chain of dependencies, its first member repeated at the end; empty if there is none."""
    done: set[str] = set()

    def visit(node: str, path: list[str]) -> list[str]:
        if node in path:
            return [*path[path.index(node) :], node]
        if node in done:
            return []
        done.add(node)
        return next((found for other in graph.get(node, ()) if (found := visit(other, [*path, node]))), [])

    return next((found for node in graph if (found := visit(node, []))), [])


def test_a_circle_is_found() -> None:
    assert circle({"a": ["b"], "b": ["c", "d"], "d": ["b"], "c": []}) == ["b", "d", "b"]
    assert circle({"a": ["b", "c"], "b": ["c"], "c": []}) == []


def test_no_circle_of_includes() -> None:
    headers = {path.relative_to(CORE).as_posix(): core_includes(path) for path in sorted(CORE.rglob("*.hpp"))}
    assert circle(headers) == []


def test_the_core_knows_no_python_no_files_no_clock() -> None:
    for source in sorted((ROOT / "core").rglob("*.[hc]pp")):
        includes = re.findall(r"#include [<\"]([^>\"]+)[>\"]", source.read_text())
        unwanted = {"fstream", "filesystem", "iostream", "chrono", "ctime", "cstdio", "random", "Python.h"}
        assert not unwanted & set(includes), source
        assert not [name for name in includes if name.startswith(("nanobind", "pybind"))], source


PYTHON_LAYERS = [
    {"common", "profiles", "track", "irregularity", "config", "catalog", "cases"},
    {"assembly", "results"},
    {"simulation", "interfaces"},
    {"similitude", "contact_analysis", "analysis"},
    {"plot", "viewer", "study"},
    {"cli"},
]
"""From left to right. Within a layer, too, no two folders see each other; what `rollerrig/__init__.py` defines is open to all."""

PYTHON_MAY_NOT_SEE = {
    "common": {"config"},  # no key of a case
    "profiles": {"_core", "config"},  # curves are made in Python and handed to the core by assembly
    "track": {"_core", "config", "profiles", "irregularity"},  # a line of numbers
    "irregularity": {"_core", "config", "profiles", "track"},
    "assembly": {"results"},
    "plot": {"_core", "assembly", "simulation"},  # a figure takes results and computes no physics
    "cli": {"_core"},  # ten lines over the public interface
}
"""Pairs that the order alone would allow."""


def python_layer(name: str) -> int:
    for number, names in enumerate(PYTHON_LAYERS):
        if name in names:
            return number
    pytest.fail(f"rollerrig.{name} has no place on the arrow: add it to PYTHON_LAYERS")


CONFIG_LAYERS = ["errors", "schema", "read", "validate", "write", "load", "__init__"]
"""The same inside `config`."""


def module_name(source: Path) -> str:
    parts = source.relative_to(PACKAGE).with_suffix("").parts
    return ".".join(("rollerrig", *(parts[:-1] if parts[-1] == "__init__" else parts)))


SOURCES = {module_name(path): path for path in sorted(PACKAGE.rglob("*.py"))}


@cache
def imported_modules(source: Path) -> frozenset[str]:
    """Modules of the package that a file imports, also inside functions and for type checks only."""
    package = ("rollerrig", *source.relative_to(PACKAGE).parts[:-1])
    found: set[str] = set()
    for node in ast.walk(ast.parse(source.read_text(), str(source))):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            base = ".".join(package[: len(package) - node.level + 1]) if node.level else ""
            module = ".".join(part for part in (base, node.module or "") if part)
            inner = {f"{module}.{alias.name}" for alias in node.names}
            found |= {name if name in SOURCES or name == "rollerrig._core" else module for name in inner}
    return frozenset(name for name in found if name.startswith("rollerrig.")) - {module_name(source)}


def test_imports_point_left() -> None:
    for name, source in SOURCES.items():
        own = source.relative_to(PACKAGE).parts[0].removesuffix(".py")
        if own in {"__init__", "__main__"}:
            continue
        for target in {module.split(".")[1] for module in imported_modules(source)}:
            assert target == "_core" or python_layer(target) <= python_layer(own), (
                f"{name} may not import rollerrig.{target}"
            )
            assert target not in PYTHON_MAY_NOT_SEE.get(own, set()), f"{name} may not import rollerrig.{target}"


def test_configuration_flows_in_a_line() -> None:
    for source in sorted((PACKAGE / "config").rglob("*.py")):
        own = CONFIG_LAYERS.index(source.relative_to(PACKAGE / "config").parts[0].removesuffix(".py"))
        for target in imported_modules(source):
            if target.startswith("rollerrig.config."):
                part = target.split(".")[2]
                assert CONFIG_LAYERS.index(part) <= own, f"{module_name(source)} may not import {target}"
            assert target != "rollerrig._core" or CONFIG_LAYERS[own] == "validate", (
                f"{module_name(source)}: tables are read without the extension"
            )


def test_no_circle_of_folders() -> None:
    """Those of a layer, too, use each other in one direction."""
    folders: dict[str, set[str]] = {}
    for name, path in SOURCES.items():
        if name not in {"rollerrig", "rollerrig.__main__"}:
            own = name.split(".")[1]
            folders.setdefault(own, set()).update({t.split(".")[1] for t in imported_modules(path)} - {own})
    assert circle(folders) == []


def test_no_circle_of_imports() -> None:
    """Of modules, not only of folders; `rollerrig` itself loads names when they are used."""
    assert circle({name: imported_modules(path) for name, path in SOURCES.items() if name != "rollerrig"}) == []
