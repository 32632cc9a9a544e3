"""A controller's side of `rollerrig serve`, in Python.

description, sensors <- [client] <- server;  commands -> [client] -> server
"""

import json
import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from types import TracebackType
from typing import Any

from rollerrig.interfaces.realtime import frames
from rollerrig.interfaces.realtime.frames import Frame, pack, unpack
from rollerrig.interfaces.realtime.links import ClientError, open_link


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
    """A connection to a server; a context that closes it.

    Attributes:
        description: what the server reports of itself: names, units and limits.
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
            address: of the server, '127.0.0.1:5005', or '/name' of its shared memory.
            timeout: for its answers [s].

        Raises:
            ClientError: nobody answers, or another controller has the rig.
        """
        self._timeout = timeout
        self._link = open_link(address, timeout)
        try:
            self._session, self.description = self._ask(address)
        except BaseException:
            self._link.close()
            raise
        self.inputs: tuple[str, ...] = tuple(one["name"] for one in self.description["inputs"])
        self.outputs: tuple[str, ...] = tuple(one["name"] for one in self.description["outputs"])
        self._sequence = 0
        self._last: Frame | None = None

    def __enter__(self) -> "Client":
        """The client itself."""
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        """Close the connection."""
        self.close()

    def close(self) -> None:
        """Close the connection; the server's watchdog notices."""
        self._link.close()

    def receive(self) -> Sensors:
        """The newest sensors: those that lie there already are passed over but for the last.

        Raises:
            ClientError: none arrive within the timeout.
        """
        found, wait = None, self._timeout
        while (
            frame := self._next(lambda one: one.kind == frames.SENSORS and one.session == self._session, wait)
        ) is not None:
            self._last, wait = frame, 0.0
            found = Sensors(1e-9 * frame.time_ns, frames.STATES[min(frame.state, 4)], frame.values, frame.sequence)
            if found.state == "ended":
                break
        if found is None:
            raise ClientError(f"no sensors for {self._timeout:g} s; is the server still there?")
        return found

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
        self._link.send(pack(frame))

    def _next(self, wanted: Callable[[Frame], bool], wait: float) -> Frame | None:
        """The next sound frame that is wanted; None where there is none within so long [s], whatever else arrives."""
        until = time.monotonic() + wait
        while True:
            data = self._link.receive(max(0.0, until - time.monotonic()))
            frame = None if data is None else unpack(data)
            if frame is not None and wanted(frame):
                return frame
            if (data is None or wait) and time.monotonic() >= until:
                return None

    def _ask(self, address: str) -> tuple[int, dict[str, Any]]:
        """Session and description of the server, part by part."""
        parts: dict[int, bytes] = {}
        count = 1
        until = time.monotonic() + self._timeout
        while len(parts) < count:
            missing = next(i for i in range(count) if i not in parts)
            self._send(Frame(frames.ASK, answers=missing))
            part = self._next(lambda one: one.kind == frames.DESCRIPTION, 0.2)
            if part is None:
                if time.monotonic() > until:
                    raise ClientError(f"{address}: nobody answers; start `rollerrig serve CASE` with this address")
                continue
            if part.answers == 0:
                raise ClientError(f"{address}: another controller has this rig; end it, or serve another rig")
            parts[part.sequence], count, session = part.text, part.answers, part.session
        found: dict[str, Any] = json.loads(b"".join(parts[i] for i in range(count)))
        return session, found
