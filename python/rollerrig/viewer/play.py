"""`rr.play`: a live simulation behind a small server of this machine: the page, its frames, and what visitors move.

    case -> [play] -> LiveRun -> [Theatre: clock] -> [server: page, frames as server-sent events, POST] -> browsers

The server listens on the loopback alone, answers only requests that name it (so that no page of the web can reach it through a
name of its own), and takes commands only from its own page. All browsers see one and the same simulation.
"""

import contextlib
import json
import threading
import time
import webbrowser
from collections import deque
from collections.abc import Callable
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any

from rollerrig.cases import as_case
from rollerrig.config import Case, ConfigError
from rollerrig.simulation.starting_state import StartError
from rollerrig.viewer.exhibition import Exhibition
from rollerrig.viewer.live import FRAME, LiveRun
from rollerrig.viewer.page import live_page

_KEPT = 60
"""Frames for a browser that comes back late."""

_PATIENCE = 10.0
"""A connection that is silent for so long is closed [s]; each holds a thread."""

_LARGEST_BODY = 1000
_HOSTS = ("127.0.0.1", "localhost")


def play(
    case: Case | str,
    *,
    port: int = 0,
    browser: bool = True,
    exhibition: bool = False,
    tell: Callable[[str], object] = print,
) -> None:
    """Run a case in real time behind a page whose sliders move it, until Ctrl-C (in a notebook: until it is interrupted).

    Args:
        case: what is run, or its name in the catalogue.
        port: where the page is found on the loopback; 0: any free one.
        browser: whether a browser is opened there.
        exhibition: whether the page says what one sees, enlarges it, and moves itself after a minute without visitors.
        tell: given the page's address.

    Raises:
        ConfigError: a controller of the case is written in Python, or nothing holds the vehicle on its rollers.
        StartError: no equilibrium was found.
        OSError: the port is taken.

    Example:
        >>> import rollerrig as rr
        >>> rr.play("bogie_rollers_constant")  # doctest: +SKIP
        http://127.0.0.1:41233/
    """
    theatre = Theatre(as_case(case), exhibition)
    listening = server(theatre, port)
    address = f"http://127.0.0.1:{listening.server_address[1]}/"
    threading.Thread(target=listening.serve_forever, daemon=True).start()
    try:
        tell(address)
        if browser:
            webbrowser.open(address)
        theatre.play()
    except KeyboardInterrupt:
        pass
    finally:
        theatre.ended = True
        listening.shutdown()
        listening.server_close()


class Theatre:
    """A simulation on its clock, and those who look on; `exhibition`: an audience."""

    def __init__(self, case: Case, exhibition: bool = False) -> None:
        self.run = LiveRun(case)
        self.exhibition = Exhibition(self.run) if exhibition else None
        self._news = threading.Condition()
        self._frames = deque([self._frame()], _KEPT)
        self._number, self.ended = 0, False

    def play(self) -> None:
        """Until `ended`: a frame after the other, as time goes."""
        due = time.monotonic()
        while not self.ended:
            due = max(due + FRAME, time.monotonic() - 10 * FRAME)  # what a machine cannot keep up with is left out
            time.sleep(max(0.0, due - time.monotonic()))
            with self._news:
                (self.exhibition or self.run).advance(FRAME)
                self._frames.append(self._frame())
                self._number += 1
                self._news.notify_all()

    def _frame(self) -> str:
        return json.dumps(self.run.frame() | (self.exhibition.frame() if self.exhibition else {}))

    def frames_after(self, number: int) -> tuple[int, int, list[str]]:
        """The frames after that number as far as they are kept: number of the last, version of the scene, their texts.

        Waits for one at most a second.
        """
        with self._news:
            self._news.wait_for(lambda: self._number > number or self.ended, 1.0)
            count = min(self._number - number, len(self._frames))
            return self._number, self.run.version, list(self._frames)[len(self._frames) - count :]

    def command(self, name: str, given: dict[str, Any]) -> str:
        """What a visitor does; the answer is what is wrong with it, or ""."""
        with self._news:
            if self.exhibition:
                self.exhibition.touched()
            try:
                if name == "set":
                    self.run.set(str(given["name"]), float(given["value"]))
                elif name == "push":
                    self.run.push()
                else:
                    self.run.again()
            except (ConfigError, StartError, ValueError, KeyError, TypeError, OverflowError) as error:
                return str(error).splitlines()[0] or "not understood"
        return ""

    def scene(self) -> dict[str, Any]:
        """What the page draws."""
        with self._news:
            return self.run.scene


def server(theatre: Theatre, port: int = 0) -> ThreadingHTTPServer:
    """The server on the loopback, at a port; 0: any free one.

    Raises:
        OSError: the port is taken.
    """
    listening = ThreadingHTTPServer(("127.0.0.1", port), _handler(theatre))
    listening.daemon_threads = True
    return listening


def _handler(theatre: Theatre) -> type[BaseHTTPRequestHandler]:
    class Handler(BaseHTTPRequestHandler):
        # a request a connection: what is left of a refused one is never taken for the next
        protocol_version = "HTTP/1.0"
        timeout = _PATIENCE

        def do_GET(self) -> None:
            if not self._is_for_us():
                return
            if self.path == "/":
                self._answer(200, "text/html; charset=utf-8", live_page(theatre.scene()))
            elif self.path == "/scene":
                self._answer(200, "application/json", json.dumps(theatre.scene()))
            elif self.path == "/frames":
                self._frames()
            else:
                self._answer(404, "text/plain", "no such page")

        def do_POST(self) -> None:
            size = self.headers.get("Content-Length", "")
            if not self._is_for_us():
                return
            origin = self.headers.get("Origin", f"http://{self.headers['Host']}")
            if origin != f"http://{self.headers['Host']}" or self.path not in ("/set", "/push", "/again"):
                self._answer(403, "text/plain", "only the page of this server may do that")
                return
            try:
                body = self.rfile.read(int(size)) if size.isdigit() and int(size) <= _LARGEST_BODY else b"not one"
                given = json.loads(body)
            except (ValueError, RecursionError):
                given = None
            wrong = theatre.command(self.path[1:], given) if isinstance(given, dict) else "not understood"
            self._answer(400 if wrong else 200, "text/plain; charset=utf-8", wrong)

        def _is_for_us(self) -> bool:
            """A request that names another host came through a name that leads here: of a page that wants to reach in."""
            name, _, port = (self.headers.get("Host") or "").partition(":")
            if name in _HOSTS and port == str(self.connection.getsockname()[1]):
                return True
            self._answer(403, "text/plain", "not the name of this server")
            return False

        def _frames(self) -> None:
            self.send_response(200)
            self.send_header("Content-Type", "text/event-stream")
            self.send_header("Cache-Control", "no-store")
            self.end_headers()
            number, scene, _ = theatre.frames_after(-1)
            with contextlib.suppress(OSError):  # the browser has gone
                while not theatre.ended:
                    number, version, texts = theatre.frames_after(number)
                    if version != scene:
                        scene = version
                        self.wfile.write(b"event: scene\ndata: {}\n\n")
                    self.wfile.write("".join(f"data: {text}\n\n" for text in texts).encode())
                    self.wfile.flush()

        def _answer(self, code: int, kind: str, text: str) -> None:
            content = text.encode()
            self.send_response(code)
            self.send_header("Content-Type", kind)
            self.send_header("Content-Length", str(len(content)))
            self.send_header("Cache-Control", "no-store")
            self.end_headers()
            with contextlib.suppress(OSError):
                self.wfile.write(content)

        def log_message(self, format: str, *args: Any) -> None:  # noqa: A002
            """Nothing: a terminal is not for requests."""

    return Handler
