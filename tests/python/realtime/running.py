"""A server at work in a thread of its own, and the case that the tests serve."""

from __future__ import annotations

import threading
from typing import Any

import rollerrig as rr
from rollerrig.interfaces.realtime.server import Ended, Served, open_server, run_server


class Running:
    """A server at work; `join` waits for its end."""

    def __init__(self, served: Served, address: str = "127.0.0.1", **settings: Any) -> None:
        self.served = served
        self.server = open_server(served, address, 0, **settings)
        self.address = address if address.startswith("/") else f"{address}:{self.server.port}"
        self._ended: list[Ended] = []
        self._thread = threading.Thread(target=lambda: self._ended.append(run_server(self.server)))
        self._thread.start()

    def join(self) -> Ended:
        self._thread.join(30.0)
        assert self._ended, "the server did not end"
        return self._ended[0]

    def stop(self) -> None:
        self.server.stop()
        self._thread.join(30.0)


def brake_case(**changes: Any) -> rr.Case:
    return rr.load_case("adhesion_brake").with_changes({"time.duration": 1.0, "time.output_step": 0.005} | changes)
