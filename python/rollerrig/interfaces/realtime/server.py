"""The server of a rig: a case or model file, whether one core holds its rate, where it listens, how its run ended.

case, rate -> [serve_case] -> Served: model, inputs, outputs, description
Served -> [open_server] -> _core.RigServer -> [run_server] -> Ended
"""

import json
import secrets
import sys
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from fnmatch import fnmatchcase
from typing import Any

import numpy as np

from rollerrig import _core
from rollerrig.cases import as_case
from rollerrig.common.arrays import Array
from rollerrig.common.formatting import number
from rollerrig.config import Case, ConfigError
from rollerrig.config.errors import nearest, one_of
from rollerrig.config.schema.units import Quantity
from rollerrig.interfaces.plant import assembled_model
from rollerrig.simulation.controllers import BRAKE_UNIT, COMMANDS, roles_of, with_brake_unit

RATE = Quantity("Hz", 1.0, 1e5)
SURROUNDINGS = (".friction_change", "train.force")
"""Ends of the names of inputs that no controller commands: frames do not carry them."""
LARGEST_FRAME = 512
"""Numbers that a frame holds."""


@dataclass(frozen=True)
class Served:
    """A rig ready to be served: case (None: of a model file), period [s], variables that are commanded and sent, safe values.

    Variables also by their indices, as the core counts them.
    """

    name: str
    case: Case | None
    assembled: _core.AssembledModel
    period: float
    inputs: tuple[_core.Variable, ...]
    outputs: tuple[_core.Variable, ...]
    safe: tuple[float, ...]
    input_indices: list[int]
    output_indices: list[int]

    @property
    def periods(self) -> int:
        """Number of periods of the run."""
        return max(1, round(self.assembled.options.final_time / self.period))


def serve_case(
    case: Case,
    rate: str | float = "1 kHz",
    *,
    external: Sequence[str] | None = None,
    outputs: Sequence[str] = (),
    safe: Mapping[str, float] | None = None,
    lock_step: bool = False,
) -> Served:
    """Prepare a case for a server.

    A case that leaves `time.method` open is run in real time with a method whose steps all cost about the same: that of
    `simulate` is the faster one on average, but a step that renews its matrices takes thirty times as long.

    Args:
        case: a checked case.
        rate: of commands and sensors [Hz]; its period is a multiple of `time.sampling_step`.
        external: tables of the case's controllers that are outside; None: 'slide_protection' and 'wheel_slip_control', as far
            as the case has them. They are asked every period.
        outputs: names of what is sent, '*' stands for anything; empty: what the controllers outside measure.
        safe: values of commands in the safe state, by name; 0 for the others, for the running speed that of the case.
        lock_step: not in real time: the method is that of `simulate`.

    Raises:
        ConfigError: the rate, a name or a value is not allowed, or two controllers would command the same valves.
        StartError: no equilibrium was found to start from.
    """
    there = roles_of(case)
    inside = ("rig_control", BRAKE_UNIT)
    roles = tuple(external if external is not None else (role for role in there if role not in inside))
    case = with_brake_unit(case, roles)
    for role in roles:
        if role not in there:
            raise ConfigError.of(case.name, "external", role, one_of(there), nearest(role, there))
        if not (table := getattr(case, role)).is_ours:
            allowed = "two controllers for one command: remove it, or leave its table out of --external"
            key, value = ("user", table.user) if table.user is not None else ("fmu", table.fmu.file)
            raise ConfigError.of(case.name, f"{role}.{key}", repr(value), allowed)
    period = _period(case.name, rate, case.time.sampling_step if case.sampled else 0.0)
    changes: dict[str, object] = {f"{role}.sample_time": period for role in roles}
    if case.sampled and case.time.method is None and not lock_step:
        changes |= {"time.method": "exponential_rk4", "time.step": case.time.sampling_step}
    case = case.with_changes(changes) if changes else case
    return _served(assembled_model(case, external=roles), case, case.name, period, outputs, safe or {})


def serve_model(
    assembled: _core.AssembledModel,
    rate: str | float = "1 kHz",
    *,
    name: str = "",
    outputs: Sequence[str] = (),
    safe: Mapping[str, float] | None = None,
) -> Served:
    """Prepare an assembled model for a server; method, external controllers and their sample times are those it was made with.

    Args:
        assembled: as `rollerrig.read_model` gives it.
        rate: of commands and sensors [Hz]; its period is a multiple of the model's sampling step.
        name: of its file, for messages.
        outputs: as for `serve_case`.
        safe: as there.

    Raises:
        ConfigError: the rate, a name or a value is not allowed.
    """
    name = name or assembled.name
    period = _period(name, rate, _core.Plant(assembled).sampling_step)
    return _served(assembled, None, name, period, outputs, safe or {})


def _served(
    assembled: _core.AssembledModel,
    case: Case | None,
    name: str,
    period: float,
    outputs: Sequence[str],
    safe: Mapping[str, float],
) -> Served:
    variables = _core.Plant(assembled).variables
    inputs = tuple(v for v in variables if v.causality == "input" and not v.name.endswith(SURROUNDINGS))
    chosen = _chosen(name, variables, outputs)
    if max(len(inputs), len(chosen)) > LARGEST_FRAME:
        allowed = f"a frame holds at most {LARGEST_FRAME} numbers; name fewer with --outputs"
        raise ConfigError.of(name, "outputs", f"{len(chosen)} variables", allowed)
    number = {v.name: index for index, v in enumerate(variables)}
    indices = ([number[v.name] for v in some] for some in (inputs, chosen))
    return Served(name, case, assembled, period, inputs, chosen, _safe(name, inputs, safe), *indices)


def describe(served: Served, *, session: int, lock_step: bool, patience: int) -> str:
    """Description of the server for a controller, as JSON."""

    def entry(variable: _core.Variable, **more: Any) -> dict[str, Any]:
        return {"name": variable.name, "unit": variable.unit, "meaning": variable.description, **more}

    told = {
        "case": served.name,
        "session": session,
        "period": served.period,
        "lock_step": lock_step,
        "watchdog_periods": patience,
        "inputs": [
            entry(v, start=v.start, safe=s, least=_finite(v.least), most=_finite(v.most), whole=v.whole)
            for v, s in zip(served.inputs, served.safe, strict=True)
        ],
        "outputs": [entry(v, measured=_is_measured(v)) for v in served.outputs],
    }
    return json.dumps(told, separators=(",", ":"), ensure_ascii=False)


# ---------------------------------------------------------------------------------------------------- parts


def _period(name: str, rate: str | float, step: float) -> float:
    number = rate
    with suppress(ValueError):  # else a text with its unit
        number = float(rate)
    try:
        found = RATE.parse(number)
    except ValueError:
        raise ConfigError.of(name, "rate", repr(rate), f"allowed: a rate like '1 kHz', {RATE.bounds}") from None
    if step == 0.0:
        return 1.0 / found
    steps = 1.0 / found / step
    if round(steps) < 1 or abs(steps - round(steps)) > 1e-6 * steps:
        near = _kilohertz(1.0 / (max(1, round(steps)) * step))
        allowed = f"allowed: a rate whose period is a multiple of time.sampling_step, {1e3 * step:g} ms; the nearest is {near}"
        raise ConfigError.of(name, "rate", _kilohertz(found), allowed)
    return round(steps) * step


def _kilohertz(rate: float) -> str:
    return f"{number(1e-3 * rate, 3)} kHz"


def _chosen(name: str, variables: Sequence[_core.Variable], patterns: Sequence[str]) -> tuple[_core.Variable, ...]:
    outputs = [v for v in variables if v.causality == "output"]
    if not patterns:
        measured = tuple(v for v in outputs if _is_measured(v))
        return measured or tuple(v for v in outputs if v.name.endswith((".axle_speed", ".pitch_rate")))
    for pattern in patterns:
        if not any(fnmatchcase(v.name, pattern) for v in outputs):
            names = [v.name for v in outputs]
            allowed = f"allowed: names of outputs, with '*' for anything, like '{names[0]}'"
            raise ConfigError.of(name, "outputs", repr(pattern), allowed, nearest(pattern, names))
    return tuple(v for v in outputs if any(fnmatchcase(v.name, pattern) for pattern in patterns))


def _safe(name: str, inputs: Sequence[_core.Variable], given: Mapping[str, float]) -> tuple[float, ...]:
    names = [v.name for v in inputs]
    for own, value in given.items():
        if own not in names:
            raise ConfigError.of(name, "safe", repr(own), one_of(names), nearest(own, names))
        limits = inputs[names.index(own)]
        if not limits.least <= value <= limits.most or (limits.whole and value != round(value)):
            kind = "a whole number" if limits.whole else "a number"
            allowed = f"allowed: {kind} from {limits.least:g} to {limits.most:g}"
            raise ConfigError.of(name, f"safe: {own}", f"{value:g}", allowed)
    return tuple(float(given.get(v.name, v.start if v.name.startswith("run.") else 0.0)) for v in inputs)


def _is_measured(variable: _core.Variable) -> bool:
    """Whether a controller outside sees it, through its sensors."""
    return variable.name.startswith(tuple(f"{role}." for role in COMMANDS))


def _finite(value: float) -> float | None:
    return value if np.isfinite(value) else None


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
            raise ConfigError.of(served.name, "shm", address, f"{error}; {allowed}") from None
        allowed = "allowed: a free port of this machine; 0 takes any"
        raise ConfigError.of(served.name, "udp", f"{address}:{port}", f"{error}; {allowed}") from None


def check_system(served: Served) -> None:
    """See that this system has a server, with a ConfigError where it has not."""
    try:
        _core.require_real_time()
    except RuntimeError as error:
        raise ConfigError.of(
            served.name, "serve", sys.platform, f"{error}; allowed: `--replay`, and `rollerrig run`"
        ) from None


def check_rate(served: Served) -> float:
    """Run some periods as quickly as they go, and see whether the rate can be held.

    Returns:
        The largest rate that can [Hz], by processor time.

    Raises:
        ConfigError: it is below that of the server; the message says what can be held. Or this system has no server.
    """
    check_system(served)
    found = _core.measure_rig(
        served.assembled,
        served.input_indices,
        served.output_indices,
        period=served.period,
        periods=MEASURED_PERIODS,
        repeats=2,
    )
    longest = 1e-9 * found[2]
    rate = LOAD / longest if longest > 0 else float("inf")
    if rate < 1.0 / served.period:
        allowed = (
            f"one core of this machine holds {_kilohertz(rate)} of this case: 99 of 100 steps take at most "
            f"{1e3 * longest:.3g} ms, {100 * LOAD:.0f} % of a period is allowed"
        )
        raise ConfigError.of(served.name, "rate", _kilohertz(1.0 / served.period), allowed)
    return rate


def replay(served: Served, commands: Array) -> Array:
    """Sensors of a run whose commands, shape (period, input), are known; shape (period + 1, output), those of the start first."""
    found: Array = _core.replay_rig(
        served.assembled,
        served.input_indices,
        served.output_indices,
        period=served.period,
        commands=np.ascontiguousarray(commands, dtype=np.float64),
    )
    return found


@dataclass(frozen=True)
class Ended:
    """How a server's run ended."""

    ending: str  # 'ran', 'stopped_by_caller', 'plant_ended' or 'controller_silent'
    status: str  # of the run, as in the results: 'ok', 'stopped', 'contact_lost' ...
    sentence: str  # what the status means
    memory: str  # 'locked', or why not
    scheduling: str  # 'SCHED_FIFO', or why not
    statistics: dict[str, Any]  # of deadlines and frames; times are (count, median, 99 %, 99.99 %, longest) [ns]


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
