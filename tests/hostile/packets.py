"""Datagrams to a server in lock-step: after each handful it still answers its own controller."""

from __future__ import annotations

import random
import socket
import struct
import zlib
from typing import Any

from hostile.bytes_of import NUMBERS, WHOLE, spoiled
from python.realtime.running import Running, brake_case
from rollerrig.interfaces.realtime.client import Client
from rollerrig.interfaces.realtime.frames import Frame, pack
from rollerrig.interfaces.realtime.server import serve_case

REFUSALS = ()


class Stage:
    """A server, its controller and a stranger; made anew when the run is at its end."""

    def __init__(self) -> None:
        self.served = serve_case(brake_case(), "200 Hz", outputs=["train.*"], lock_step=True)
        self.stranger = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.running: Any = None
        self.left = 0

    def controller(self) -> Client:
        """With at least one period to go."""
        if self.left == 0:
            if self.running is not None:
                self.rig.close()
                self.running.stop()
            self.running, self.left = Running(self.served, lock_step=True), 150
            self.rig = Client(self.running.address, timeout=10.0)
            self.rig.receive()
        self.left -= 1
        return self.rig


def prepare() -> Stage:
    return Stage()


def attack(stage: Stage, choose: random.Random) -> str:
    rig = stage.controller()
    host, port = stage.running.address.split(":")
    for _ in range(10):
        sender = stage.stranger if choose.random() < 0.7 else rig._link._socket
        sender.sendto(datagram(choose), (host, int(port)))
    rig.command([0.0] * 4)
    if rig.receive().state == "ended":
        stage.left = 0
    return "ran"


def datagram(choose: random.Random) -> bytes:
    """Noise, a frame with a changed byte, or a frame whose checksum is right whatever is in it."""
    values = tuple(choose.choice((*NUMBERS, 1.0, 1e5)) for _ in range(choose.choice([0, 1, 4, 4, 4, 512])))
    whole = pack(
        Frame(
            choose.randrange(256), choose.randrange(2**16), choose.choice(WHOLE) % 2**32, choose.choice(WHOLE) % 2**32,
            choose.choice(WHOLE) % 2**63, choose.choice(WHOLE) % 2**32, choose.randrange(8), values,
        )
    )  # fmt: skip
    match choose.choice(["noise", "spoiled", "right", "right"]):
        case "noise":
            return choose.randbytes(choose.randrange(200))
        case "spoiled":
            return spoiled(whole, choose)[:60000]
    body = spoiled(whole[:-4], choose)[:60000]
    return body + struct.pack("<I", zlib.crc32(body))
