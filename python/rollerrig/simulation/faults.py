"""Faults of single axles: what brake unit and slide protection measure and command, altered for the axles that have one.

Case, AssembledModel, the user's controllers -> [with_faults] -> controllers that are asked in time, with the faults of the case

Brake unit and slide protection of a case with faults are asked as a user's are, our own through `_core.ControllerPlant`. Physics
stays in the core: a fault only changes what goes in and comes out.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from rollerrig import _core
from rollerrig.assembly.model import AssembledModel
from rollerrig.config import Case, ConfigError
from rollerrig.config.schema.actuators import Brake
from rollerrig.config.schema.faults import AnyFault
from rollerrig.results import Draft
from rollerrig.simulation.controllers import BRAKE_UNIT, COMMANDS, Measurements, UserController, ask
from rollerrig.simulation.mechatronics import controller_of

FILL = 0.0
"""Command of a dump valve."""


def faulty_roles(case: Case) -> list[str]:
    """Tables of the controllers that faults of the case go through."""
    roles = (BRAKE_UNIT, "slide_protection") if case.slide_protection else (BRAKE_UNIT,)
    return list(roles) if case.fault else []


def refuse_faults(case: Case) -> None:
    """Refuse with a ConfigError a case with faults, where its controllers are not asked in time."""
    if case.fault:
        allowed = "allowed in runs, and in studies made of runs; here without [[fault]]"
        raise ConfigError.of(case.name, "fault", f"{len(case.fault)} faults", allowed)


def with_faults(model: AssembledModel, users: Mapping[str, UserController]) -> dict[str, UserController]:
    """Controllers of a run by table: those of the user, and with faults of the case also our own of brakes.

    Raises:
        ConfigError: the brake unit of the case has no table.
    """
    case, names = model.case, list(model.axle_names)
    faults = [(names.index(fault.axle), fault) for fault in case.fault]
    found = dict(users)
    for role in faulty_roles(case):
        inner = users.get(role) or OwnController(model, role)
        found[role] = FaultyController(inner, role, faults, case.brake)
    return found


class OwnController:
    """One of our controllers, asked as a user's is.

    Attributes:
        name: of its table, for messages.
        sample_time: of the case's table [s].
        times: from which on what is known after each sample holds [s].
        known: signal -> values after each sample, one for each axle: a brake unit's valves; one of the train: reference_speed.
    """

    def __init__(self, model: AssembledModel, role: str) -> None:
        """Begin at the speed of the case's start."""
        case, axles = model.case, list(model.axle_names)
        self.name, self.sample_time = role, getattr(case, role).sample_time
        self.times: list[float] = []
        self.known: dict[str, list[list[float]]] = {}
        step, speed = case.time.sampling_step, case.motion.speed
        sampling = _core.Sampling(every=round(self.sample_time / step), delay=0, external=False)
        turning = [speed / case.vehicle.data.wheel.radius] * len(axles)
        sampled = _core.SampledController(sampling=sampling, controller=controller_of(model, role))
        part = _core.ControllerPart(
            name=case.name, step=step, controller=sampled, axles=axles, train_speed=speed,
            axle_speed=turning, roller_speed=turning,
        )  # fmt: skip
        self._plant = _core.ControllerPlant(part)
        self._plant.start()
        self._command = COMMANDS[role].name
        self._inputs: list[tuple[int, str, int]] = []
        self._outputs: list[int] = []
        self._known: dict[str, list[int]] = {}
        for place, variable in enumerate(self._plant.variables):
            axle, _, name = variable.name.rpartition(".")
            if variable.causality == "input":
                self._inputs.append((place, name, axles.index(axle)))
            elif name == f"{self._command}_command":
                self._outputs.append(place)
            elif variable.causality == "output":
                self._known.setdefault(name, []).append(place)

    def step(self, measurements: Measurements) -> dict[str, Any]:
        """Commands of one sample."""
        for place, name, axle in self._inputs:
            self._plant.set_input(place, measurements[name][axle])
        sample = round(measurements["time"] / self.sample_time)
        self._plant.advance((sample + 1) * self.sample_time)
        self.times.append((sample + (self.name == BRAKE_UNIT)) * self.sample_time)  # a brake unit's is that at the end
        for name, places in self._known.items():
            self.known.setdefault(name, []).append([self._plant.get(place) for place in places])
        return {self._command: [self._plant.get(place) for place in self._outputs]}


class FaultyController:
    """A controller whose measurements and commands are those of axles with faults.

    Attributes:
        sample_time: of the controller inside [s].
        inner: that controller.
    """

    def __init__(
        self, inner: UserController, role: str, faults: Sequence[tuple[int, AnyFault]], brake: Brake | None
    ) -> None:
        """Take a controller of a table, and of each fault the number of its axle."""
        self.inner, self.sample_time = inner, inner.sample_time
        self._role, self._faults, self._brake = role, faults, brake

    def step(self, measurements: Measurements) -> dict[str, Any]:
        """Commands of one sample."""
        acting = [(axle, fault) for axle, fault in self._faults if measurements["time"] >= fault.begin]
        for axle, fault in acting:
            if change := MEASURED.get((self._role, fault.kind)):
                name, value = change
                measurements[name][axle] = value(measurements[name][axle], fault)
        command = ask(self.inner, self._role, measurements)
        for axle, fault in acting:
            if self._role == BRAKE_UNIT and (made := PRESSURE.get(fault.kind)):
                command[axle] = made(command[axle], fault, self._brake)
        return {COMMANDS[self._role].name: command}


MEASURED: Mapping[tuple[str, str], tuple[str, Callable[[float, Any], float]]] = {
    (BRAKE_UNIT, "isolated"): ("brake_demand", lambda _, __: 0.0),
    (BRAKE_UNIT, "never_vents"): ("dump_valve", lambda _, __: FILL),
    ("slide_protection", "silent_sensor"): ("axle_speed", lambda _, __: 0.0),
    ("slide_protection", "wheel_radius"): ("axle_speed", lambda speed, fault: speed / fault.factor),
}
"""Table and kind of a fault -> measurement that it changes, and to what."""


def _of_pads(pressure: float, fault: Any, brake: Any) -> float:
    """At which the other axles' pads exert the torque of these, which is in proportion to A p - F_s, (A6)."""
    touching = brake.spring_force / brake.piston_area
    return max(0.0, touching + fault.factor * (pressure - touching)) if pressure > touching else pressure


PRESSURE: Mapping[str, Callable[[float, Any, Any], float]] = {
    "dragging": lambda pressure, fault, _: max(pressure, fault.pressure),
    "pads": _of_pads,
}
"""Kind of a fault -> cylinder pressure that acts, of that which the brake unit makes."""


def add_signals_of_ours(draft: Draft, users: Mapping[str, UserController]) -> None:
    """Write into results what our slide protection and brake unit know, where they were asked as a user's are."""
    for user in users.values():
        inner = getattr(user, "inner", None)
        if not isinstance(inner, OwnController) or not inner.times:
            continue
        at = np.searchsorted(np.array(inner.times), draft.values("time") + 1e-9, side="right") - 1
        for name, values in inner.known.items():
            dims, old, attributes = draft.variables[name]
            found = np.array(values)[np.maximum(at, 0)].reshape(np.shape(old))
            draft.variables[name] = (dims, found.astype(np.asarray(old).dtype), attributes)
        if "reference_speed" in inner.known:
            dims, old, attributes = draft.variables["reference_speed_error"]
            error = draft.values("reference_speed") - draft.values("train_speed")
            draft.variables["reference_speed_error"] = (dims, error.astype(np.asarray(old).dtype), attributes)
