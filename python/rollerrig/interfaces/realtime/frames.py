"""Frames between server and controller, version 1: the same as in rollerrig_wire.h, tested against it.

header of 32 bytes, `count` float64, CRC-32; all little-endian -> [unpack] -> Frame
"""

import struct
import zlib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

VERSION = 1
COMMAND, SENSORS, ASK, DESCRIPTION = 1, 2, 3, 4
"""Kinds of frames."""
REARM = 1
"""Flag of a command: take the rig up again after a safe state."""
STATES = ("waiting", "running", "ramping", "safe", "ended")
"""States of the server, by number."""
LARGEST_FRAME = 32 + 8 * 512 + 4

_HEADER = struct.Struct("<4sBBHIIqIHH")
_CRC = struct.Struct("<I")


@dataclass(frozen=True)
class Frame:
    """A frame; the header's fields as rollerrig_wire.h explains them."""

    kind: int
    flags: int = 0
    session: int = 0
    sequence: int = 0
    time_ns: int = 0
    answers: int = 0
    state: int = 0
    values: tuple[float, ...] = ()  # of a command or of sensors
    text: bytes = b""  # of a part of the description


def pack(frame: Frame) -> bytes:
    """The bytes of a frame."""
    payload = frame.text if frame.kind == DESCRIPTION else struct.pack(f"<{len(frame.values)}d", *frame.values)
    count = len(frame.text) if frame.kind == DESCRIPTION else len(frame.values)
    header = _HEADER.pack(
        b"RRIG", VERSION, frame.kind, frame.flags, frame.session, frame.sequence & 0xFFFFFFFF, frame.time_ns,
        frame.answers, count, frame.state,
    )  # fmt: skip
    return header + payload + _CRC.pack(zlib.crc32(header + payload))


def unpack(data: bytes) -> Frame | None:
    """The frame of a datagram; None where it is not a whole, sound frame of this version."""
    if len(data) < _HEADER.size + _CRC.size:
        return None
    magic, version, kind, flags, session, sequence, time_ns, answers, count, state = _HEADER.unpack_from(data)
    if magic != b"RRIG" or version != VERSION or _CRC.unpack(data[-4:])[0] != zlib.crc32(data[:-4]):
        return None
    body = data[_HEADER.size : -_CRC.size]
    if len(body) != (count if kind == DESCRIPTION else 8 * count):
        return None
    values: Sequence[float] = () if kind == DESCRIPTION else struct.unpack(f"<{count}d", body)
    text = body if kind == DESCRIPTION else b""
    return Frame(kind, flags, session, sequence, time_ns, answers, state, tuple(values), text)


def c_header() -> Path:
    """The C header with the same frames, for controllers in C and C++: rollerrig_wire.h."""
    return Path(__file__).resolve().parents[2] / "include" / "rollerrig_wire.h"
