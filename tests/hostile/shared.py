"""Shared memory of a server, spoiled by a controller: no crash, and the server can still be stopped."""

from __future__ import annotations

import mmap
import os
import random
import struct
from typing import Any

from hostile.bytes_of import WHOLE, spoiled
from hostile.packets import datagram
from python.realtime.running import Running, brake_case
from rollerrig.interfaces.realtime.client import Client
from rollerrig.interfaces.realtime.links import SHARED_MEMORY, ClientError
from rollerrig.interfaces.realtime.server import serve_case

REFUSALS = ()
HEAD, SLOTS, SLOT = 64, 8, 16 + 4176
RING = HEAD + SLOTS * SLOT
"""Sizes of rollerrig_shm.h: the memory is a head and two rings, each a head and its slots; the second is the controller's."""


class Stage:
    """A server with a controller; made anew at the end of its run, and where what was spoiled leaves them apart."""

    def __init__(self) -> None:
        self.served = serve_case(brake_case(), "200 Hz", outputs=["train.*"], lock_step=True)
        self.running: Any = None
        self.begin()

    def begin(self) -> None:
        if self.running is not None:
            self.running.stop()
            self.running.join()  # it ended, and by itself
            self.running = None  # and its memory with it
        self.running = Running(self.served, f"/rollerrig_hostile_{os.getpid()}", lock_step=True)
        self.rig = Client(self.running.address, timeout=30.0)  # of a busy machine
        self.rig.receive()
        self.rig._timeout = 0.3
        with (SHARED_MEMORY / self.running.address[1:]).open("r+b") as file:
            self.memory = mmap.mmap(file.fileno(), 0)


def prepare() -> Stage:
    return Stage()


def attack(stage: Stage, choose: random.Random) -> str:
    begin = HEAD + RING if choose.random() < 0.8 else HEAD
    for _ in range(choose.choice([1, 1, 3])):
        slot = begin + HEAD + choose.randrange(SLOTS) * SLOT
        match choose.choice(["frame", "frame", "size", "stamp", "written", "anything"]):
            case "frame":
                frame = datagram(choose)[: SLOT - 16]
                stage.memory[slot + 16 : slot + 16 + len(frame)] = frame
            case "size":
                stage.memory[slot + 8 : slot + 12] = struct.pack("<I", choose.choice(WHOLE) % 2**32)
            case "stamp":
                stage.memory[slot : slot + 8] = struct.pack("<Q", choose.choice(WHOLE))
            case "written":
                stage.memory[begin : begin + 8] = struct.pack("<Q", choose.choice(WHOLE))
            case "anything":
                whole = spoiled(bytes(stage.memory[begin : begin + RING]), choose)[:RING]
                stage.memory[begin : begin + len(whole)] = whole
    try:
        stage.rig.command([0.0] * 4)
        ended = stage.rig.receive().state == "ended"
    except ClientError:  # as where the count of frames was changed
        ended = True
    if ended:
        stage.begin()
    return "ran"
