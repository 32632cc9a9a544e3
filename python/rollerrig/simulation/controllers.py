"""A user's own controller in place of one of ours.

'module:Class', 'file.py:Class' or an object -> [controllers] -> asked at its sample times, its commands checked

A controller has a `sample_time` [s] and a method `step(measurements) -> commands`. Measurements are a dict with `time` [s]
and one array of shape (axle,) for each of MEASUREMENTS; commands are a dict with the one array that COMMANDS names.
"""

from __future__ import annotations

import ast
import importlib
import json
import sys
from collections.abc import Collection, Mapping
from pathlib import Path
from types import ModuleType
from typing import Any, Protocol

import numpy as np

from rollerrig import _core
from rollerrig.common.arrays import Array
from rollerrig.common.input_files import LARGEST_TEXT, InputError, read_input
from rollerrig.config import Case, Code, ConfigError
from rollerrig.simulation.fmu_controller import FmuController, FmuError
from rollerrig.simulation.fmu_file import MEASUREMENTS as MEASUREMENTS

Measurements = dict[str, Any]

COMMANDS: dict[str, _core.CommandField] = dict(_core.commands)
"""Table of the case -> its command, and what is allowed."""

BRAKE_UNIT = "brake_unit"


def roles_of(case: Case) -> list[str]:
    """Tables of the controllers that the case has; each brake has a unit, with a table or without."""
    own_unit = {BRAKE_UNIT} if case.brake is not None else set()
    return [role for role in COMMANDS if getattr(case, role) is not None or role in own_unit]


def with_brake_unit(case: Case, roles: Collection[str]) -> Case:
    """The case with a table of its brake unit, asked at every sampling step, where that is among the roles."""
    if BRAKE_UNIT not in roles or case.brake_unit is not None or case.brake is None:
        return case
    return case.with_changes({BRAKE_UNIT: {"sample_time": case.time.sampling_step}})


class UserController(Protocol):
    """What a user writes."""

    sample_time: float

    def step(self, measurements: Measurements) -> object:
        """Commands for the time until the next sample."""
        ...


class ControllerError(Exception):
    """A controller failed during a run; the message has its name, the time and what it was given."""


def users_controllers(case: Case, given: Mapping[str, Any]) -> dict[str, UserController]:
    """Controllers of the case and of the caller, whose sample times fit the sampling step.

    Raises:
        ConfigError: one cannot be used.
    """
    found: dict[str, UserController] = {}
    for role in given:
        if role not in COMMANDS or getattr(case, role) is None:
            allowed = f"allowed: a table of the case: {', '.join(roles_of(case)) or 'it has none'}"
            raise ConfigError.of(case.name, "controllers", repr(role), allowed)
        found[role] = check_controller(given[role], role, case.name)
    for role in COMMANDS:
        table = getattr(case, role)
        if role not in found and table is not None and table.user is not None:
            found[role] = load_controller(table.user, f"{role}.user", case.name)
        if role not in found and table is not None and table.fmu is not None:
            found[role] = fmu_controller(case, role)
    for role, controller in found.items():
        steps = controller.sample_time / case.time.sampling_step
        if round(steps) < 1 or abs(steps - round(steps)) > 1e-6 * steps:
            name = f"{role}, {type(controller).__name__}.sample_time"
            near = max(1, round(steps)) * case.time.sampling_step
            step = f"{case.time.sampling_step:g} s"
            allowed = f"allowed: a multiple of time.sampling_step, {step}; the nearest is {near:g} s"
            raise ConfigError.of(case.name, name, f"{controller.sample_time:g}", allowed)
    return found


def fmu_controller(case: Case, role: str) -> FmuController:
    """The FMU that a case names in a table, connected; none of its code has been run.

    Raises:
        ConfigError: it cannot be used.
    """
    table = getattr(case, role)
    axles = case.axle_names if role != "rig_control" else tuple(body.name for body in case.vehicle.wheelsets)
    return FmuController(table.fmu, f"{role}.fmu", case.name, axles, COMMANDS[role].name, table.sample_time)


def close_controllers(users: Mapping[str, UserController]) -> None:
    """End what runs outside of Python; each may begin another run."""
    for controller in users.values():
        if isinstance(controller, FmuController):
            controller.close()


def provenance_of(users: Mapping[str, UserController]) -> dict[str, str]:
    """Attributes of results that say which FMUs took part, `slide_protection_fmu` and so on."""
    return {f"{role}_fmu": user.provenance for role, user in users.items() if isinstance(user, FmuController)}


def look_at_controller(code: Code, file: str) -> None:
    """See that a file of code is there, is Python and has the class, without running any of it.

    Args:
        code: what the case names; of a module nothing can be seen without running it. An FMU is looked at by
            `fmu_controller`.
        file: the case, for messages.

    Raises:
        ConfigError: it cannot be used.
    """
    if not code.is_file or code.is_fmu:
        return
    place = f"{code.source}:{code.name}"
    try:
        tree = ast.parse(read_input(code.source, LARGEST_TEXT), code.source)
    except InputError as error:
        raise ConfigError.of(file, code.key, repr(place), f"{error.strerror}; allowed: a Python file") from None
    except (OSError, SyntaxError, ValueError, RecursionError, MemoryError) as error:
        raise ConfigError.of(file, code.key, repr(place), f"{type(error).__name__}: {error}") from None
    made = {getattr(node, "name", "") for node in tree.body} | {
        getattr(part, "id", getattr(part, "asname", None) or getattr(part, "name", ""))
        for node in tree.body
        for part in (*getattr(node, "targets", ()), *getattr(node, "names", ()))
    }
    if code.name not in made and "*" not in made:
        raise ConfigError.of(file, code.key, repr(place), f"needed: a class {code.name} in that file")


def load_controller(place: str, key: str, file: str) -> UserController:
    """An object of the class that a case names under a key, as 'module:Class' or 'file.py:Class'.

    Raises:
        ConfigError: there is no such module, file or class, or it cannot be made.
    """
    module_name, colon, name = place.rpartition(":")
    if not colon or not module_name or not name.isidentifier():
        raise ConfigError.of(file, key, repr(place), "allowed: 'module:Class' or 'file.py:Class'")
    try:
        of_a_file = module_name.endswith(".py")
        module = _module_of(module_name) if of_a_file else importlib.import_module(module_name)
        made = getattr(module, name)()
    except InputError as error:
        raise ConfigError.of(file, key, repr(place), f"{error.strerror}; allowed: a Python file") from None
    except Exception as error:  # whatever the user's module does while it is loaded
        raise ConfigError.of(file, key, repr(place), f"{type(error).__name__}: {error}") from error
    checked: UserController = check_controller(made, key, file)
    return checked


def _module_of(path: str) -> ModuleType:
    """The module in a file: of the text there, not of compiled code that may lie beside it."""
    text = read_input(path, LARGEST_TEXT)
    module = ModuleType(f"rollerrig_controller_{Path(path).stem}")
    module.__file__ = path
    sys.modules[module.__name__] = module  # where dataclasses look for it
    exec(compile(text, path, "exec"), module.__dict__)
    return module


def check_controller(controller: Any, key: str, file: str) -> Any:
    """The controller, if it has what it needs.

    Raises:
        ConfigError: no positive `sample_time`, or no method `step`.
    """
    name = type(controller).__name__
    time = getattr(controller, "sample_time", None)
    if isinstance(time, bool) or not isinstance(time, int | float) or not 0 < time < np.inf:
        needed = f"needed: an attribute sample_time, a positive number in s; it is {time!r}"
        raise ConfigError.of(file, key, repr(name), needed)
    if not callable(getattr(controller, "step", None)):
        raise ConfigError.of(file, key, repr(name), "needed: a method step(measurements) that returns commands")
    return controller


def ask(controller: UserController, role: str, measurements: Measurements) -> Array:
    """The checked command of one sample, shape (axle,).

    Raises:
        ControllerError: it raised, or returned what is no command.
    """
    axles = len(measurements["axle_speed"])
    field = COMMANDS[role]
    command = field.name
    name = f"{role}, controller {getattr(controller, 'name', type(controller).__name__)}"

    def failed(what: str) -> ControllerError:
        given = json.dumps({k: np.round(v, 6).tolist() for k, v in measurements.items()})
        return ControllerError(f"t = {measurements['time']:.4g} s, {name}: {what}; it was given {given}")

    copies = {k: np.array(v) if k != "time" else v for k, v in measurements.items()}
    try:
        answer = controller.step(copies)
    except FmuError as error:
        raise failed(str(error)) from error
    except ControllerError:  # of the one inside a controller with faults
        raise
    except Exception as error:
        raise failed(f"raised {type(error).__name__}: {error}") from error
    if not isinstance(answer, Mapping) or set(answer) != {command}:
        found = sorted(map(str, answer)) if isinstance(answer, Mapping) else type(answer).__name__
        raise failed(f"returned {found}; needed: a dict with the one key {command!r}")
    try:
        values = np.asarray(answer[command], dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        raise failed(f"{command} holds what is no number") from None
    if values.shape != (axles,):
        raise failed(f"{command} has shape {values.shape}; needed: ({axles},), one per axle")
    valid = np.isfinite(values) & (values >= field.lowest) & (values <= field.highest)
    if field.whole:
        valid &= values == np.round(values)
    if not valid.all():
        raise failed(f"{command} = {values.tolist()}; allowed: {field.allowed}")
    return values
