"""Rigs that are served for the tests: short, on the loopback, each in a thread of its own."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from typing import Any

import pytest

from python.realtime.running import Running, brake_case
from rollerrig.interfaces.realtime.server import Served, serve_case

if not sys.platform.startswith("linux"):  # there the frames alone are tested
    collect_ignore = ["test_serving.py", "test_loop.py", "test_brake_test.py"]


@pytest.fixture(scope="session")
def served_brake() -> Served:
    """The brake test of 1 s at 200 Hz, the sample time of its slide protection, with the train's motion."""
    return serve_case(brake_case(), "200 Hz", outputs=["slide_protection.*", "train.*"], lock_step=True)


@pytest.fixture
def serve() -> Iterator[Callable[..., Running]]:
    """Starts servers, and stops them whatever happens."""
    started: list[Running] = []

    def start(served: Served, address: str = "127.0.0.1", **settings: Any) -> Running:
        started.append(Running(served, address, **settings))
        return started[-1]

    yield start
    for running in started:
        running.stop()
