#!/usr/bin/env python
"""Compute the figures that README and documentation quote, and write them into docs/figures.toml and the pages.

    python scripts/write_figures.py             all commands of docs/figures.toml (half an hour on two cores)
    python scripts/write_figures.py NAME ...    some of them
    python scripts/write_figures.py --from DIR  from the folders DIR/NAME of earlier runs

A [[figure]] names the page, the command, the places of its values in summary.json (`100 * a.b` is scaled; a/b where names have
dots; of a list the item k, or the one of `family=delay&curve=PI`) and the text of the page with a format for each value.
`tests/python/docs/test_figures.py` says when page and file, or file and program, disagree.
"""

from __future__ import annotations

import argparse
import json
import re
import shlex
import subprocess
import sys
import tempfile
import tomllib
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
FILE = ROOT / "docs" / "figures.toml"


def main() -> None:
    """Run the commands and rewrite what they changed."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*", help="commands; all if absent")
    parser.add_argument("--from", type=Path, dest="folder", help="folder of earlier runs")
    asked = parser.parse_args()
    data = tomllib.loads(FILE.read_text(encoding="utf-8"))
    commit = subprocess.run(
        ["git", "rev-parse", "--short", "HEAD"], cwd=ROOT, capture_output=True, text=True, check=True
    )
    for name in asked.names or data["command"]:
        if asked.folder and not (asked.folder / name / "summary.json").exists():
            continue
        numbers = summary(data["command"][name]["command"], asked.folder and asked.folder / name)
        data["command"][name]["commit"] = commit.stdout.strip()
        for figure in (one for one in data["figure"] if one["of"] == name):
            update(figure, numbers)
        FILE.write_text(written(data), encoding="utf-8")


def summary(command: str, folder: Path | None = None) -> dict[str, Any]:
    """summary.json of a command, or of the folder of an earlier run."""
    if folder:
        return dict(json.loads((folder / "summary.json").read_text(encoding="utf-8")))
    with tempfile.TemporaryDirectory() as out:
        words = [*shlex.split(command)[1:], "--out", f"{out}/result"]
        subprocess.run([sys.executable, "-c", "from rollerrig.cli import main; main()", *words], check=True)
        return dict(json.loads(Path(out, "result", "summary.json").read_text(encoding="utf-8")))


def update(figure: dict[str, Any], numbers: dict[str, Any]) -> None:
    """New values of a figure; its text on the page follows."""
    page, before = ROOT / figure["page"], quoted(figure) if figure.get("values") else None
    figure["values"] = [value(numbers, key) for key in figure["keys"]]
    after = quoted(figure)
    if before is not None and before != after:
        print(f"{figure['page']}: {before}  ->  {after}")
        page.write_text(page.read_text(encoding="utf-8").replace(before, after), encoding="utf-8")
    if after not in page.read_text(encoding="utf-8"):
        print(f"{figure['page']} does not have: {after}")


def value(numbers: Any, key: str) -> float | str:
    """A value of summary.json, times a factor."""
    factor, path = place(key)
    for part in path:
        numbers = item(numbers, part) if isinstance(numbers, list) else numbers[part]
    return numbers if factor == 1.0 else factor * numbers


def item(rows: list[Any], part: str) -> Any:
    """Of a list the item at a place, or the only one with these fields."""
    if "=" not in part:
        return rows[int(part)]
    fields = dict(field.split("=") for field in part.split("&"))
    (found,) = (row for row in rows if all(str(row[name]) == text for name, text in fields.items()))
    return found


def place(key: str) -> tuple[float, list[str]]:
    """Factor and names of a key."""
    factor, _, path = key.rpartition(" * ")
    return float(factor or 1.0), path.split("/" if "/" in path else ".")


def quoted(figure: dict[str, Any]) -> str:
    """The text as the page has it."""
    return re.sub(r"-(?=[\d.])", "−", str(figure["text"]).format(*figure["values"]))


def written(data: dict[str, Any]) -> str:
    """The file."""
    lines = ["# Figures quoted on the pages; values written by scripts/write_figures.py."]
    for name, command in data["command"].items():
        lines += ["", f"[command.{name}]", *(f"{key} = {json.dumps(entry)}" for key, entry in command.items())]
    for figure in data["figure"]:
        lines += [
            "",
            "[[figure]]",
            *(f"{key} = {json.dumps(entry, ensure_ascii=False)}" for key, entry in figure.items()),
        ]
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    main()
