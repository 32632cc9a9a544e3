"""The page: one HTML file that holds program, styles, scenes and numbers, and asks nothing of any network.

Scenes -> [page] -> HTML text
"""

from __future__ import annotations

import html
import json
from collections.abc import Sequence
from functools import cache
from importlib.resources import files
from typing import Any

from rollerrig import __version__
from rollerrig.viewer.scene import Scene

MARK = '<!doctype html>\n<meta name="generator" content="rollerrig">'
"""How the page begins: what says that this program wrote it."""

ALLOWED = "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data:"
"""What a browser may load for it: nothing."""


@cache
def bundle(name: str) -> str:
    """A file of the pages' programs as it ships: viewer.js, viewer.css; report.js, report.css."""
    return files("rollerrig.viewer").joinpath("page", name).read_text(encoding="utf-8")


def live_page(head: dict[str, Any]) -> str:
    """The page of a simulation that runs now and is asked for frames; it may ask the server that it came from alone.

    Args:
        head: of its scene.
    """
    return _html(str(head["title"]), [head], "", ALLOWED + "; connect-src 'self'")


def page(title: str, scenes: Sequence[Scene]) -> str:
    """The whole page.

    Args:
        title: of the page.
        scenes: one, or two that are shown side by side in step.
    """
    numbers = "\n".join(
        f'<script type="text/plain" id="numbers{k}">{scene.columns.text()}</script>' for k, scene in enumerate(scenes)
    )
    return _html(title, [scene.head for scene in scenes], numbers, ALLOWED)


def _html(title: str, heads: Sequence[dict[str, Any]], numbers: str, allowed: str) -> str:
    content = {"version": __version__, "title": title, "scenes": heads}
    data = json.dumps(content, ensure_ascii=False, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")
    return f"""{MARK}
<html lang="en"><head><meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta http-equiv="Content-Security-Policy" content="{allowed}">
<link rel="icon" href="data:,">
<title>{html.escape(title)}</title>
<style>{bundle("viewer.css")}</style></head>
<body><div id="view"></div><noscript>This page draws with JavaScript, which is switched off here.</noscript>
<script type="application/json" id="scene">{data}</script>
{numbers}
<script>{bundle("viewer.js")}</script>
</body></html>
"""
