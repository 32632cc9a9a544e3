"""The page's program: made of its sources, small, with licences, naming no host."""

from __future__ import annotations

import importlib.util
import json
import re
from pathlib import Path

from rollerrig.viewer.page import bundle

ROOT = Path(__file__).resolve().parents[3]


def checksum() -> str:
    spec = importlib.util.spec_from_file_location("viewer_checksum", ROOT / "scripts" / "viewer_checksum.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return str(module.viewer_checksum())


def test_it_was_made_of_these_sources() -> None:
    for name in ("viewer.js", "viewer.css", "report.js", "report.css"):
        assert f"sources {checksum()};" in bundle(name)[:200], f"{name} is stale: run scripts/bundle_viewer"


def test_it_is_below_a_megabyte() -> None:
    assert len(bundle("viewer.js").encode()) + len(bundle("viewer.css").encode()) < 1_000_000
    assert len(bundle("report.js").encode()) + len(bundle("report.css").encode()) < 70_000  # of every report


def test_it_ends_no_script_element() -> None:
    for page in ("viewer", "report"):
        assert "</script" not in bundle(f"{page}.js")
        assert "</style" not in bundle(f"{page}.css")


def test_the_licences_are_there() -> None:
    for name in ("three", "uplot"):
        assert "MIT License" in (ROOT / "third_party" / name / "LICENSE").read_text()
        assert f"third_party/{name}" in bundle("viewer.js")[:300]


def test_the_lock_names_no_host_and_has_a_hash_of_everything() -> None:
    lock = json.loads((ROOT / "viewer" / "package-lock.json").read_text())
    assert "://" not in json.dumps(lock)
    assert all("integrity" in package for name, package in lock["packages"].items() if name)


def test_sources_are_small() -> None:
    for source in (ROOT / "viewer" / "src").glob("*.js"):
        assert len(source.read_text().splitlines()) < 250, source.name


def test_sources_begin_with_what_they_are() -> None:
    for source in (ROOT / "viewer" / "src").glob("*.js"):
        assert re.match(r"// [A-Z]", source.read_text()), source.name
