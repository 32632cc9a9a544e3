"""A user's own controller in place of one of ours.

'module:Class', 'file.py:Class' or an object -> [controllers] -> asked at its sample times, its commands checked

A controller has a `sample_time` [s] and a method `step(measurements) -> commands`. Measurements are a dict with `time` [s]
and one array of shape (axle,) for each of MEASUREMENTS; commands are a dict with the one array that COMMANDS names.
"""

from __future__ import annotations

import importlib
import importlib.util
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from rollerrig.config import ConfigError, ConfigProblem

Measurements = dict[str, Any]

COMMANDS = {
    "slide_protection": ("valve", "0 fill, 1 hold, 2 vent"),
    "wheel_slip_control": ("torque_factor", "0 to 1"),
    "rig_control": ("roller_torque", "N m, any finite number"),
}
"""Table of the case -> its command and what is allowed."""

MEASUREMENTS = {
    "axle_speed": "measured speed of each axle [rad/s]",
    "roller_speed": "measured speed of each roller axle, positive as under a wheel that rolls forward [rad/s]",
    "roller_torque": "of each roller drive since the last sample, as measured; positive drives the wheel forward [N m]",
    "estimated_force": "our estimate of the contact force on each axle, forward [N]",
    "estimated_torque": "our estimate of the torque on each axle [N m]",
    "virtual_speed": "speed of each axle of the virtual train [rad/s]",
    "feed_forward": "our feed-forward torque of each roller drive [N m]",
    "axle_load": "measured vertical force under each axle [N]",
}
"""What a controller is given beside `time`; on track only `axle_speed` means anything."""


class UserController(Protocol):
    """What a user writes."""

    sample_time: float

    def step(self, measurements: Measurements) -> object:
        """Commands for the time until the next sample."""
        ...


class ControllerError(Exception):
    """A controller failed during a run; the message has its name, the time and what it was given."""


def load_controller(place: str, key: str, file: str) -> UserController:
    """An object of the class that a case names.

    Args:
        place: 'module:Class' or 'file.py:Class'.
        key: where the case names it.
        file: the case, for messages.

    Raises:
        ConfigError: there is no such module, file or class, or it cannot be made.
    """
    module_name, colon, name = place.rpartition(":")
    if not colon or not module_name or not name.isidentifier():
        raise _refused(file, key, place, "allowed: 'module:Class' or 'file.py:Class'")
    try:
        if module_name.endswith(".py"):
            spec = importlib.util.spec_from_file_location(Path(module_name).stem, module_name)
            if spec is None or spec.loader is None:
                raise ImportError(f"{module_name} is no Python file")
            module = importlib.util.module_from_spec(spec)
            spec.loader.exec_module(module)
        else:
            module = importlib.import_module(module_name)
        made = getattr(module, name)()
    except Exception as error:  # whatever the user's module does while it is loaded
        raise _refused(file, key, place, f"{type(error).__name__}: {error}") from error
    checked: UserController = check_controller(made, key, file)
    return checked


def check_controller(controller: Any, key: str, file: str) -> Any:
    """The controller, if it has what it needs.

    Raises:
        ConfigError: no positive `sample_time`, or no method `step`.
    """
    name = type(controller).__name__
    time = getattr(controller, "sample_time", None)
    if isinstance(time, bool) or not isinstance(time, int | float) or not 0 < time < np.inf:
        raise _refused(file, key, name, f"needed: an attribute sample_time, a positive number in s; it is {time!r}")
    if not callable(getattr(controller, "step", None)):
        raise _refused(file, key, name, "needed: a method step(measurements) that returns commands")
    return controller


def _refused(file: str, key: str, value: str, allowed: str) -> ConfigError:
    return ConfigError([ConfigProblem(file, key, repr(value), allowed)])


def ask(controller: UserController, role: str, measurements: Measurements) -> NDArray[np.float64]:
    """The checked command of one sample, shape (axle,).

    Raises:
        ControllerError: it raised, or returned what is no command.
    """
    axles = len(measurements["axle_speed"])
    command, allowed = COMMANDS[role]
    name = f"{role}, controller {type(controller).__name__}"
    given = json.dumps({k: np.round(v, 6).tolist() for k, v in measurements.items()})

    def failed(what: str) -> ControllerError:
        return ControllerError(f"t = {measurements['time']:.4g} s, {name}: {what}; it was given {given}")

    copies = {k: np.array(v) if k != "time" else v for k, v in measurements.items()}
    try:
        answer = controller.step(copies)
    except Exception as error:
        raise failed(f"raised {type(error).__name__}: {error}") from error
    if not isinstance(answer, Mapping) or set(answer) != {command}:
        found = sorted(map(str, answer)) if isinstance(answer, Mapping) else type(answer).__name__
        raise failed(f"returned {found}; needed: a dict with the one key {command!r}")
    try:
        values = np.asarray(answer[command], dtype=np.float64)
    except (TypeError, ValueError):
        raise failed(f"{command} holds what is no number") from None
    if values.shape != (axles,):
        raise failed(f"{command} has shape {values.shape}; needed: ({axles},), one per axle")
    valid = np.isfinite(values)
    if role == "slide_protection":
        valid &= np.isin(values, (0.0, 1.0, 2.0))
    if role == "wheel_slip_control":
        valid &= (values >= 0) & (values <= 1)
    if not valid.all():
        raise failed(f"{command} = {values.tolist()}; allowed: {allowed}")
    return values
