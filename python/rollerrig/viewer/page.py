"""The page: one HTML file that holds program, styles, scenes and numbers, and asks nothing of any network.

Scenes -> [page] -> HTML text
runs -> [view] -> one HTML file
"""

import html
import json
from collections.abc import Sequence
from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import Any

import xarray as xr

from rollerrig import __version__
from rollerrig.common.formatting import number
from rollerrig.results import ResultsError, RunInfo, load_run, output_file, write_text
from rollerrig.results.run_info import ATTRIBUTE
from rollerrig.viewer.scene import Scene, holds_modes, mode_scene, model_of, run_scene

MARK = '<!doctype html>\n<meta name="generator" content="rollerrig">'
"""How the page begins: what says that this program wrote it."""

ALLOWED = "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data:"
"""What a browser may load for it: nothing."""


@cache
def bundle(name: str) -> str:
    """A file of the pages' programs as it ships: viewer.js, viewer.css; report.js, report.css."""
    return files("rollerrig.viewer").joinpath("page", name).read_text(encoding="utf-8")


def live_page(head: dict[str, Any]) -> str:
    """The page of a simulation that runs now and is asked for frames; it may ask the server that it came from alone."""
    return _html(str(head["title"]), [head], "", ALLOWED + "; connect-src 'self'")


def page(title: str, scenes: Sequence[Scene]) -> str:
    """The whole page of one scene, or of two that are shown side by side in step."""
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


Run = xr.Dataset | str | Path


def view(run: Run, other: Run | None = None, *, path: str | Path = "view.html", force: bool = False) -> Path:
    """Write a run as a page that shows it in motion, in any browser, without a network.

    Args:
        run: results of `simulate` or of `stability`, or a file of them.
        other: another run to be shown beside it, in step: the same case on track, another controller.
        path: the page.
        force: whether a file that this program did not write may be replaced.

    Returns:
        The page's path.

    Raises:
        FileNotFoundError: no such run.
        ResultsError: a file is damaged or of another version, or holds no motion of bodies.
        OutputError: the page could not be written.

    Example:
        >>> import rollerrig as rr
        >>> run = rr.simulate(rr.load_case("wheelset_rollers").with_changes({"time.duration": "0.2 s"}))
        >>> rr.view(run, path="view.html").name
        'view.html'
    """
    target = output_file(path, force=force)
    chosen = [_loaded(one) for one in (run, other) if one is not None]
    return write_text(target, view_text(chosen), force=force)


def view_text(runs: Sequence[xr.Dataset], labels: Sequence[str] = ()) -> str:
    """The page as text.

    Args:
        runs: one or two runs, or the modes of `stability`.
        labels: how they are called; by default their cases, of one case with their speeds at the start.

    Raises:
        ResultsError: a run holds no motion of bodies.
    """
    names = list(labels) or _names(runs)
    if any(map(holds_modes, runs)):
        if len(runs) > 1:
            raise ResultsError("modes have no time in common with another run; view takes them alone")
        return page(names[0], [mode_scene(runs[0], label=names[0])])
    scenes = [run_scene(run, label=name) for run, name in zip(runs, names, strict=True)]
    return page(" | ".join(names), scenes)


def _names(runs: Sequence[xr.Dataset]) -> list[str]:
    """Names of the runs, each different."""
    names = [str(run.attrs.get("case", "")) for run in runs]
    if len(set(names)) == len(names):
        return names
    speeds = [f"{number(3.6 * RunInfo.of(run).speed)} km/h" if ATTRIBUTE in run.attrs else "" for run in runs]
    apart = speeds if len(set(speeds)) == len(names) else [f"run {k}" for k in range(1, len(names) + 1)]
    return [f"{name}, {what}" for name, what in zip(names, apart, strict=True)]


def _loaded(run: Run) -> xr.Dataset:
    """A run that is checked for motion, its file named in what is wrong with it."""
    if isinstance(run, xr.Dataset):
        return run
    found = load_run(run)
    if holds_modes(found):
        return found
    try:
        model_of(found)
    except ResultsError as error:
        raise ResultsError(f"{run}: {error}") from None
    return found
