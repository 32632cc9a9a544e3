"""A controller's side of `rollerrig serve`, in Python.

description, sensors <- [client] <- server;  commands -> [client] -> server
"""

from __future__ import annotations

import json
import socket
import time
from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass
from types import TracebackType
from typing import Any

from rollerrig.realtime import frames
from rollerrig.realtime.frames import Frame, pack, unpack


class ClientError(Exception):
    """The server does not answer, or another controller has the rig; one line."""


@dataclass(frozen=True)
class Sensors:
    """One frame of sensors.

    Attributes:
        time: simulated [s].
        state: of the server: 'waiting', 'running', 'ramping', 'safe' or 'ended'.
        values: numbers in the order of `Client.outputs`.
        sequence: of the frame.
    """

    time: float
    state: str
    values: tuple[float, ...]
    sequence: int


class Client:
    """A connection to a server; a context that closes its socket.

    Attributes:
        description: what the server told of itself: names, units and limits.
        inputs: names of the commands, in their order.
        outputs: names of the sensors, in their order.

    Example:
        >>> with Client("127.0.0.1:5005") as rig:  # doctest: +SKIP
        ...     for sensors in rig.sensors():
        ...         rig.command([0.0] * len(rig.inputs))
    """

    def __init__(self, address: str, *, timeout: float = 5.0) -> None:
        """Ask the server for its description; this makes the caller its controller.

        Args:
            address: of the server, '127.0.0.1:5005'.
            timeout: for its answers [s].

        Raises:
            ClientError: nobody answers, or another controller has the rig.
        """
        host, _, port = address.rpartition(":")
        self._timeout = timeout
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        try:
            self._socket.connect((host or "127.0.0.1", int(port)))
            self._session, self.description = self._ask(address)
        except BaseException:
            self._socket.close()
            raise
        self.inputs: tuple[str, ...] = tuple(one["name"] for one in self.description["inputs"])
        self.outputs: tuple[str, ...] = tuple(one["name"] for one in self.description["outputs"])
        self._sequence = 0
        self._last: Frame | None = None

    def __enter__(self) -> Client:
        """The client itself."""
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        """Close its socket."""
        self.close()

    def close(self) -> None:
        """Close the socket; the server's watchdog notices."""
        self._socket.close()

    def receive(self) -> Sensors:
        """The newest sensors: those that lie there already are passed over but for the last.

        Raises:
            ClientError: none arrive within the timeout.
        """
        frame = self._newest()
        if frame is None:
            raise ClientError(f"no sensors for {self._timeout:g} s; is the server still there?")
        self._last = frame
        return Sensors(1e-9 * frame.time_ns, frames.STATES[min(frame.state, 4)], frame.values, frame.sequence)

    def sensors(self) -> Iterator[Sensors]:
        """Sensors until the run has ended; the last ones have the state 'ended'.

        Raises:
            ClientError: none arrive within the timeout.
        """
        while True:
            found = self.receive()
            yield found
            if found.state == "ended":
                return

    def command(self, values: list[float] | tuple[float, ...] | Mapping[str, float], *, rearm: bool = False) -> None:
        """Answer the sensors that were received last.

        Args:
            values: in the order of `inputs`, or by their names, all of them.
            rearm: take the rig up again after the watchdog has brought it into its safe state.

        Raises:
            ValueError: the number of values is not that of the inputs, or a name is missing.
        """
        if isinstance(values, Mapping):
            missing = [name for name in self.inputs if name not in values]
            if missing or len(values) != len(self.inputs):
                raise ValueError(f"commands needed: {', '.join(self.inputs)}; given: {', '.join(values)}")
            values = [values[name] for name in self.inputs]
        if len(values) != len(self.inputs):
            raise ValueError(f"{len(self.inputs)} commands needed, {len(values)} given")
        self._sequence += 1
        last = self._last or Frame(frames.SENSORS)
        self._send(
            Frame(
                frames.COMMAND,
                flags=frames.REARM if rearm else 0,
                session=self._session,
                sequence=self._sequence,
                time_ns=last.time_ns,
                answers=last.sequence,
                values=tuple(float(v) for v in values),
            )
        )

    # ------------------------------------------------------------------------------------------------ frames

    def _send(self, frame: Frame) -> None:
        with suppress(ConnectionRefusedError):  # of an earlier datagram: nobody was there
            self._socket.send(pack(frame))

    def _frame(self, wait: float) -> Frame | None:
        """The next sound frame; None where there is none within so long [s]."""
        until = time.monotonic() + wait
        while True:
            self._socket.settimeout(max(0.0, until - time.monotonic()))
            try:
                data = self._socket.recv(frames.LARGEST_FRAME + 1)
            except (TimeoutError, BlockingIOError):
                return None
            except ConnectionRefusedError:
                time.sleep(min(0.05, wait))
                continue
            if (frame := unpack(data)) is not None:
                return frame

    def _newest(self) -> Frame | None:
        found, wait = None, self._timeout
        until = time.monotonic() + wait
        while True:
            frame = self._frame(wait)
            if frame is None:
                if found is not None or time.monotonic() >= until:
                    return found
                wait = max(0.0, until - time.monotonic())
                continue
            if frame.kind == frames.SENSORS and frame.session == self._session:
                found, wait = frame, 0.0
                if frames.STATES[min(frame.state, 4)] == "ended":
                    return found

    def _ask(self, address: str) -> tuple[int, dict[str, Any]]:
        """Session and description of the server, part by part."""
        parts: dict[int, bytes] = {}
        count = 1
        until = time.monotonic() + self._timeout
        while len(parts) < count:
            missing = next(i for i in range(count) if i not in parts)
            self._send(Frame(frames.ASK, answers=missing))
            part = self._frame(0.2)
            while part is not None and part.kind != frames.DESCRIPTION:
                part = self._frame(0.2)
            if part is None:
                if time.monotonic() > until:
                    raise ClientError(f"{address}: nobody answers; start `rollerrig serve CASE --udp {address}`")
                continue
            if part.answers == 0:
                raise ClientError(f"{address}: another controller has this rig; end it, or serve another rig")
            parts[part.sequence], count, session = part.text, part.answers, part.session
        found: dict[str, Any] = json.loads(b"".join(parts[i] for i in range(count)))
        return session, found
