"""Requests to the server of `play`: none is answered with a traceback, and the page's own goes through behind it."""

from __future__ import annotations

import contextlib
import http.client
import json
import random
import socket
import threading

import rollerrig as rr
from hostile.bytes_of import spoiled
from rollerrig.viewer.live import FRAME
from rollerrig.viewer.play import Theatre, server

REFUSALS = ()
FOREIGN_SPEED = 123.456
WORDS = ("speed", "friction", "nonsense", "", "a\0b", "x" * 500, "__class__", "wheel_radius")
VALUES = ("1", "-1", "0", "1e400", "-1e308", "9" * 900, "NaN", "Infinity", "null", "true", "[]", "{}", '"x"', "[" * 999,
          '{"a":' * 160, "1e-400", '"1"', "[1]", "")  # fmt: skip


class Stage:
    """A theatre and its server, whose tracebacks are kept."""

    def __init__(self) -> None:
        self.theatre = Theatre(rr.load_case("wheelset_rollers"))
        self.server = server(self.theatre)
        self.tracebacks: list[str] = []
        self.server.handle_error = self.keep  # type: ignore[method-assign]
        threading.Thread(target=self.server.serve_forever, daemon=True).start()
        self.port = self.server.server_address[1]

    def keep(self, *_given: object) -> None:
        import traceback

        text = traceback.format_exc()
        if "ConnectionResetError" not in text and "BrokenPipeError" not in text:
            self.tracebacks.append(text)


def prepare() -> Stage:
    return Stage()


def attack(stage: Stage, choose: random.Random) -> str:
    asked = foreign(stage.port, choose) if choose.random() < 0.1 else request(stage.port, choose)
    with contextlib.suppress(OSError), socket.create_connection(("127.0.0.1", stage.port), 5.0) as line:
        line.sendall(asked)
        if choose.random() < 0.8:
            line.shutdown(socket.SHUT_WR)
            while line.recv(65536):
                pass
    with stage.theatre._news:
        stage.theatre.run.advance(FRAME / 4)
        json.dumps(stage.theatre.run.frame())
    status = pushed(stage.port) if choose.random() < 0.2 else 200
    if stage.tracebacks:
        raise AssertionError(stage.tracebacks.pop().splitlines()[-1])
    if stage.theatre.run.values["speed"] == FOREIGN_SPEED:
        return "nonsense another page has moved a slider"
    return "ran" if status == 200 else f"nonsense a push is answered with {status}"


def pushed(port: int) -> int:
    """Status of the answer to the page's own request: another model, which takes longer than most attacks."""
    line = http.client.HTTPConnection("127.0.0.1", port, timeout=10.0)
    line.request("POST", "/push", "{}")
    answer = line.getresponse()
    answer.read()
    line.close()
    return answer.status


def foreign(port: int, choose: random.Random) -> bytes:
    """A request of another page, or one that is refused, whose body is a request that names no page."""
    command = f'{{"name": "speed", "value": {FOREIGN_SPEED}}}'
    hidden = f"POST /set HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nContent-Length: {len(command)}\r\n\r\n{command}"
    origin = choose.choice(["Origin: http://example.org\r\n", "Origin: null\r\n", "Host: example.org\r\n", ""])
    path, size = choose.choice(["/set", "/", "/nowhere"]), choose.choice([str(len(hidden)), "9" * 50, "x"])
    head = f"POST {path} HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\n{origin}Content-Length: {size}\r\n\r\n"
    return (head + hidden).encode()


def request(port: int, choose: random.Random) -> bytes:
    """A request as a browser sends it, with strange values in it or its bytes spoiled."""
    body = f'{{"name": {json.dumps(choose.choice(WORDS))}, "value": {choose.choice(VALUES)}}}'
    if choose.random() < 0.2:
        body = choose.choice(VALUES)
    size = choose.choice([str(len(body))] * 6 + ["-1", "9" * 5000, "0", "x", "\u00b2"])
    path = choose.choice(["/set", "/set", "/set", "/again", "/push", "/nowhere", "/", "/scene"])
    head = f"{choose.choice(['POST', 'POST', 'POST', 'PUT'])} {path} HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\n"
    whole = f"{head}Connection: close\r\nContent-Length: {size}\r\n\r\n{body}".encode()
    return spoiled(whole, choose) if choose.random() < 0.4 else whole
