#!/usr/bin/env python
"""Draw the pictures of the documentation: every docs/gallery/NAME.py becomes docs/images/NAME.svg.

    python scripts/draw_pictures.py [NAME ...]

What is in each picture (texts, ends and means of every line) stands in docs/pictures.toml; a test says when a picture is no
longer what its script draws. Pixels and fonts may differ from machine to machine, these may not.
"""

from __future__ import annotations

import json
import runpy
import sys
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from rollerrig.plot import figure_bytes

ROOT = Path(__file__).resolve().parents[1]
SCRIPTS = ROOT / "docs" / "gallery"
IMAGES = ROOT / "docs" / "images"
RECORD = ROOT / "docs" / "pictures.toml"


def drawn(name: str) -> Figure:
    """What a script of the gallery draws."""
    figure = runpy.run_path(str(SCRIPTS / f"{name}.py"))["figure"]
    assert isinstance(figure, Figure)
    return figure


def content(figure: Figure) -> dict[str, Any]:
    """Titles, labels and names, and of every line its ends, range and mean in parts of its axes."""
    texts = [text.get_text() for legend in figure.legends for text in legend.get_texts()]
    numbers: list[float] = []
    for axes in figure.axes:
        texts += [axes.get_title(loc="left"), axes.get_xlabel(), axes.get_ylabel(), *(t.get_text() for t in axes.texts)]
        numbers += [float(len(axes.patches)), float(len(axes.collections)), float(len(axes.lines))]
        for line in axes.lines:
            for values, (low, high) in zip(line.get_data(), (axes.get_xlim(), axes.get_ylim()), strict=True):
                part = (np.asarray(values, dtype=float) - low) / (high - low)
                part = part[np.isfinite(part)]
                if part.size:
                    numbers += [round(float(v), 3) for v in (part[0], part[-1], part.min(), part.max(), part.mean())]
    return {"texts": [text for text in texts if text], "numbers": numbers}


def write(names: list[str]) -> None:
    """Pictures and what is in them."""
    import tomllib

    record: dict[str, Any] = tomllib.loads(RECORD.read_text(encoding="utf-8")) if RECORD.exists() else {}
    for name in names or sorted(path.stem for path in SCRIPTS.glob("*.py")):
        figure = drawn(name)
        (IMAGES / f"{name}.svg").write_bytes(figure_bytes(figure))
        record[name] = content(figure)
    lines = ["# What is in the pictures of the documentation; written by scripts/draw_pictures.py."]
    for name in sorted(record):
        lines += ["", f"[{name}]"]
        lines += [f"{key} = {json.dumps(value, ensure_ascii=False)}" for key, value in record[name].items()]
    RECORD.write_text("\n".join(lines) + "\n", encoding="utf-8")


if __name__ == "__main__":
    write(sys.argv[1:])
