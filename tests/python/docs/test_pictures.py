"""The pictures of the documentation are what their scripts draw now; if not: python scripts/draw_pictures.py."""

from __future__ import annotations

import importlib.util
import tomllib
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).resolve().parents[3]
RECORD: dict[str, Any] = tomllib.loads((ROOT / "docs" / "pictures.toml").read_text(encoding="utf-8"))
NAMES = sorted(path.stem for path in (ROOT / "docs" / "gallery").glob("*.py"))

spec = importlib.util.spec_from_file_location("draw_pictures", ROOT / "scripts" / "draw_pictures.py")
assert spec is not None
assert spec.loader is not None
draw_pictures = importlib.util.module_from_spec(spec)
spec.loader.exec_module(draw_pictures)


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_a_picture_is_what_its_script_draws(name: str) -> None:
    now = draw_pictures.content(draw_pictures.drawn(name))
    assert now["texts"] == RECORD[name]["texts"]
    assert len(now["numbers"]) == len(RECORD[name]["numbers"])
    # parts of an axis: 5 per mille is the width of a line, and more than processors differ
    assert now["numbers"] == pytest.approx(RECORD[name]["numbers"], abs=5e-3)


def test_every_picture_has_a_script_and_a_place_on_a_page() -> None:
    assert sorted(RECORD) == NAMES
    gallery = (ROOT / "docs" / "gallery.md").read_text(encoding="utf-8")
    for name in NAMES:
        assert (ROOT / "docs" / "images" / f"{name}.svg").is_file()
        assert f"images/{name}.svg" in gallery
        assert f"gallery/{name}.py" in gallery
