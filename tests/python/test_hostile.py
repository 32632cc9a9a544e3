"""A short attack of every kind: no crash, no hang, no traceback, nothing absurd accepted. Longer: --long, HOSTILE_INPUTS."""

from __future__ import annotations

import os

import pytest

from hostile.bytes_of import crc64
from hostile.runner import Counted, attack, table
from rollerrig.interfaces.fmu.export import shells

SHORT = {"border": 150, "config": 60, "fmu": 60, "model": 20, "packets": 60, "play": 80, "profile": 150, "run": 10,
         "state": 100, "absurd": 8, "log": 200, "shared": 40, "plan": 60, "sizes": 3}  # fmt: skip
LONG = 40
"""Times as many with --long."""


def end(kind: str, inputs: int) -> None:
    first = int(os.environ.get("HOSTILE_FIRST", "0"))
    counted: Counted = attack(kind, int(os.environ.get("HOSTILE_INPUTS", str(inputs))), first)
    print(table({kind: counted}))
    assert counted.faults == []
    assert counted.outcomes.total() >= min(inputs, 1)


@pytest.mark.parametrize("kind", [pytest.param(k, marks=pytest.mark.slow) if k == "sizes" else k for k in SHORT])
def test_no_input_is_more_than_refused(kind: str) -> None:
    if kind == "fmu" and not shells():
        pytest.skip("the library inside FMUs is built on Linux")
    end(kind, SHORT[kind])


@pytest.mark.long
@pytest.mark.parametrize("kind", SHORT)
def test_no_input_of_many_is_more_than_refused(kind: str) -> None:
    end(kind, LONG * SHORT[kind])


def test_the_checksum_is_that_of_the_standard() -> None:
    assert crc64(b"123456789") == 0x995DC9BBDF1939FA  # CRC-64/XZ, catalogue of parametrised CRC algorithms
