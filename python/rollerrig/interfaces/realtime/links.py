"""How frames travel: datagrams, or ring buffers in shared memory (rollerrig_shm.h).

address -> [open_link] -> send, receive
"""

import mmap
import socket
import struct
import time
from contextlib import suppress
from pathlib import Path

from rollerrig.interfaces.realtime import frames

SHARED_MEMORY = Path("/dev/shm")


class ClientError(Exception):
    """The server does not answer, or another controller has the rig; one line."""


class Datagrams:
    """Over UDP."""

    def __init__(self, address: str) -> None:
        host, _, port = address.rpartition(":")
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        try:
            self._socket.connect((host or "127.0.0.1", int(port)))
        except (OSError, ValueError, OverflowError) as error:
            self._socket.close()
            raise ClientError(f"{address}: {error}; needed: an address like 127.0.0.1:5005") from None

    def send(self, data: bytes) -> None:
        """One frame to the server."""
        with suppress(ConnectionRefusedError):  # of an earlier datagram: nobody was there
            self._socket.send(data)

    def receive(self, wait: float) -> bytes | None:
        """The next frame; None where there is none within so long [s]."""
        self._socket.settimeout(wait)
        try:
            return self._socket.recv(frames.LARGEST_FRAME + 1)
        except (TimeoutError, BlockingIOError):
            return None
        except ConnectionRefusedError:
            time.sleep(min(0.05, wait))
            return None

    def close(self) -> None:
        """No more frames."""
        self._socket.close()


class Rings:
    """Through shared memory; waiting is looking again and again, with ever longer naps."""

    SLOTS, SLOT_BYTES = 8, 4176
    SLOT = 16 + SLOT_BYTES
    RING = 64 + SLOTS * SLOT
    LOOKS = 500
    """Before the first nap."""

    def __init__(self, path: Path) -> None:
        with path.open("r+b") as file:
            self._memory = mmap.mmap(file.fileno(), 0)
        if len(self._memory) < 64 + 2 * self.RING or self._memory[:8] != b"RRIGSHM1":
            self._memory.close()
            raise ClientError(f"{path}: not the memory of a server of this version")
        self._next = self._number(64)

    def send(self, data: bytes) -> None:
        """One frame to the server."""
        ring = 64 + self.RING
        n = self._number(ring)
        slot = ring + 64 + n % self.SLOTS * self.SLOT
        self._put(slot, 2 * n + 1)
        self._memory[slot + 8 : slot + 12] = struct.pack("<I", len(data))
        self._memory[slot + 16 : slot + 16 + len(data)] = data
        self._put(slot, 2 * n + 2)
        self._put(ring, n + 1)

    def receive(self, wait: float) -> bytes | None:
        """The next frame; None where there is none within so long [s]."""
        until, looks = time.monotonic() + wait, 0
        while (frame := self._look()) is None:
            if time.monotonic() >= until:
                return None
            looks += 1
            if looks > self.LOOKS:
                time.sleep(5e-5)
        return frame

    def close(self) -> None:
        """No more frames."""
        self._memory.close()

    def _look(self) -> bytes | None:
        self._next = min(self._next, self._number(64))  # whoever wrote it, more cannot be
        while self._next < (written := self._number(64)):
            self._next = max(self._next, written - self.SLOTS)
            slot = 128 + self._next % self.SLOTS * self.SLOT
            stamp, self._next = 2 * self._next + 2, self._next + 1
            if self._number(slot) == stamp:
                size = min(struct.unpack("<I", self._memory[slot + 8 : slot + 12])[0], self.SLOT_BYTES)
                frame = self._memory[slot + 16 : slot + 16 + size]
                if self._number(slot) == stamp:
                    return frame
        return None

    def _number(self, at: int) -> int:
        return int(struct.unpack("<Q", self._memory[at : at + 8])[0])

    def _put(self, at: int, number: int) -> None:
        self._memory[at : at + 8] = struct.pack("<Q", number % 2**64)


def open_link(address: str, timeout: float) -> Datagrams | Rings:
    """The connection to an address: '127.0.0.1:5005', or '/name' of shared memory that is there within the timeout [s].

    Raises:
        ClientError: it is no address, or there is no shared memory of that name.
    """
    if not address.startswith("/"):
        return Datagrams(address)
    until = time.monotonic() + timeout
    while not (path := SHARED_MEMORY / address[1:]).is_file():
        if time.monotonic() > until:
            raise ClientError(f"{address}: no such shared memory; start `rollerrig serve CASE --shm {address}`")
        time.sleep(0.02)
    return Rings(path)
