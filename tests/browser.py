"""A headless Chromium for the tests of pages; without one they are skipped, in continuous integration they fail."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NoReturn

import pytest

FLAGS = [
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--ignore-gpu-blocklist",
]


@contextmanager
def chromium() -> Iterator[Any]:
    """A browser: the system's, or playwright's own."""
    names = ("chromium", "chromium-browser", "google-chrome")
    program = next((path for name in names if (path := shutil.which(name))), None)
    try:
        from playwright.sync_api import sync_playwright
    except ImportError:
        _without_browser()
    with sync_playwright() as started:
        if program is None and not Path(started.chromium.executable_path).exists():
            _without_browser()
        browser = started.chromium.launch(executable_path=program, args=FLAGS)
        yield browser
        browser.close()


def _without_browser() -> NoReturn:
    message = "no chromium, or no playwright, to look at pages with: apt-get install chromium, pip install playwright"
    if os.environ.get("CI"):
        pytest.fail(message)
    pytest.skip(message)


class Opened:
    """A page in a browser, and what it asked for and complained about.

    Attributes:
        page: of playwright.
        requests: addresses of all that it asked for, itself first.
        complaints: errors and warnings of its program; of the graphics driver only errors.
    """

    def __init__(self, browser: Any, address: Path | str, width: int = 960, height: int = 600, **options: Any) -> None:
        context = browser.new_context(
            viewport={"width": width, "height": height}, **({"reduced_motion": "reduce"} | options)
        )
        self.page = context.new_page()
        self.requests: list[str] = []
        self.complaints: list[str] = []
        self.page.on("request", lambda request: self.requests.append(request.url))
        self.page.on("console", lambda message: self._heard(message.type, message.text))
        self.page.on("pageerror", lambda error: self.complaints.append(str(error)))
        self.page.goto(address.as_uri() if isinstance(address, Path) else address)
        self.page.wait_for_selector('html[data-drawn="1"]', state="attached")

    def _heard(self, kind: str, text: str) -> None:
        if kind == "error" or (kind == "warning" and "GL Driver Message" not in text):
            self.complaints.append(text)

    def ask(self, expression: str) -> Any:
        """Value of an expression of JavaScript; what is to be drawn has been drawn."""
        return self.page.evaluate(
            f"(() => {{ const r = rollerrig; const v = ({expression}); r.tick(performance.now()); return v; }})()"
        )

    def close(self) -> None:
        self.page.context.close()
