"""The server of a rig: whether one core holds its rate, where it listens, and how its run ended.

Served -> [open_server] -> _core.RigServer -> [run_server] -> Ended
"""

from __future__ import annotations

import secrets
import sys
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rollerrig import _core
from rollerrig.cases import as_case
from rollerrig.config import Case
from rollerrig.interfaces.realtime.served import Served, describe, hertz, refused, serve_case

MEASURED_PERIODS = 1000
"""Periods that are run before the server opens, to see whether the rate can be held."""
LOAD = 0.8
"""Part of a period that a step may take in 99 of 100 periods; the rest is for frames, and for what else the system does."""


def open_server(
    served: Served,
    address: str,
    port: int,
    *,
    lock_step: bool = False,
    at_once: bool = False,
    patience: int = 10,
    ramp: float = 0.2,
    oldest: int = 3,
    give_up: float = 10.0,
    spin: float = 5e-5,
    record: bool = False,
) -> _core.RigServer:
    """A server that listens; its `run` is the loop.

    Args:
        served: the rig.
        address: of IPv4; '127.0.0.1' is the loopback. Or '/name' of shared memory to be made.
        port: of UDP; 0: any that is free.
        lock_step: wait for the command of each step, whatever time that takes.
        at_once: begin without a controller.
        patience: periods without a command until the watchdog acts.
        ramp: time from there to the safe state [s].
        oldest: periods that the sensors may be old that a command answers.
        give_up: in lock-step the run ends after so long without a command [s].
        spin: how long before a deadline the loop is awake already [s].
        record: keep what acted and what was sent.

    Raises:
        ConfigError: the port cannot be had, or this system has no server.
    """
    check_system(served)
    session = secrets.randbelow(10**9 - 1) + 1
    settings = _core.ServerSettings(
        period=served.period, periods=served.periods, session=session, oldest=oldest, patience=patience,
        ramp=round(ramp / served.period), lock_step=lock_step, at_once=at_once, give_up=give_up,
        spin=min(spin, 0.25 * served.period), record=record,
    )  # fmt: skip
    try:
        return _core.RigServer(
            assembled=served.assembled,
            inputs=served.input_indices,
            outputs=served.output_indices,
            safe=list(served.safe),
            description=describe(served, session=session, lock_step=lock_step, patience=patience),
            address=address,
            port=port,
            settings=settings,
        )
    except RuntimeError as error:  # of the system: in use, not of this machine
        if address.startswith("/"):
            allowed = f"allowed: a name that is not in use; if no server runs, remove /dev/shm{address}"
            raise refused(served.name, "shm", address, f"{error}; {allowed}") from None
        allowed = "allowed: a free port of this machine; 0 takes any"
        raise refused(served.name, "udp", f"{address}:{port}", f"{error}; {allowed}") from None


def check_system(served: Served) -> None:
    """See that this system has a server.

    Raises:
        ConfigError: it has not.
    """
    try:
        _core.require_real_time()
    except RuntimeError as error:
        raise refused(
            served.name, "serve", sys.platform, f"{error}; allowed: `--replay`, and `rollerrig run`"
        ) from None


def check_rate(served: Served, periods: int = MEASURED_PERIODS) -> float:
    """Run some periods as quickly as they go, and see whether the rate can be held.

    Returns:
        The largest rate that can [Hz], by processor time.

    Raises:
        ConfigError: it is below that of the server; the message says what can be held. Or this system has no server.
    """
    check_system(served)
    found = _core.measure_rig(
        served.assembled, served.input_indices, served.output_indices, period=served.period, periods=periods, repeats=2
    )
    longest = 1e-9 * found[2]
    rate = LOAD / longest if longest > 0 else float("inf")
    if rate < 1.0 / served.period:
        allowed = (
            f"one core of this machine holds {hertz(rate)} of this case: 99 of 100 steps take at most "
            f"{1e3 * longest:.3g} ms, {100 * LOAD:.0f} % of a period is allowed"
        )
        raise refused(served.name, "rate", hertz(1.0 / served.period), allowed)
    return rate


def replay(served: Served, commands: NDArray[np.float64]) -> NDArray[np.float64]:
    """Sensors of a run whose commands are known, shape (period + 1, output): those of the start come first.

    Args:
        served: the rig.
        commands: what acts in each period, shape (period, input).
    """
    found: NDArray[np.float64] = _core.replay_rig(
        served.assembled,
        served.input_indices,
        served.output_indices,
        period=served.period,
        commands=np.ascontiguousarray(commands, dtype=np.float64),
    )
    return found


@dataclass(frozen=True)
class Ended:
    """How a server's run ended.

    Attributes:
        ending: 'ran', 'stopped_by_caller', 'plant_ended' or 'controller_silent'.
        status: of the run, as in the results: 'ok', 'stopped', 'contact_lost' ...
        sentence: what the status means.
        memory: 'locked', or why not.
        scheduling: 'SCHED_FIFO', or why not.
        statistics: of deadlines and frames; times are (count, median, 99 %, 99.99 %, longest) [ns].
    """

    ending: str
    status: str
    sentence: str
    memory: str
    scheduling: str
    statistics: dict[str, Any]


def run_server(server: _core.RigServer) -> Ended:
    """Run a server to its end; other threads may look on and stop it."""
    ending, code, memory, scheduling = server.run()
    status = next(name for name, number in _core.status_codes.items() if number == code)
    wheel = f"{server.failed_wheel}: " if server.failed_wheel else ""
    return Ended(ending, status, wheel + _core.status_sentence(code), memory, scheduling, server.statistics())


def serve(
    case: Case | str, rate: str | float = "1 kHz", *, address: str = "127.0.0.1", port: int = 0, **options: Any
) -> Ended:
    """Serve a case until it ends, `rollerrig serve`; a controller commands it over UDP.

    Args:
        case: what to serve, or its name in the catalogue.
        rate: of commands and sensors [Hz].
        address: to listen at; the loopback unless another one is given: frames are not encrypted.
        port: 0: any that is free.
        options: of `serve_case` and `open_server`.

    Returns:
        How it ended.

    Raises:
        ConfigError: something is not allowed, the port is in use, or one core cannot hold the rate.
        StartError: no equilibrium was found to start from.
    """
    of_case = {name: options.pop(name) for name in ("external", "outputs", "safe") if name in options}
    lock_step = bool(options.get("lock_step"))
    served = serve_case(as_case(case), rate, lock_step=lock_step, **of_case)
    if not lock_step:
        check_rate(served)
    return run_server(open_server(served, address, port, **options))
