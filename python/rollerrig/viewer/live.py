"""A simulation that goes on while somebody moves its sliders: a plant, and what a page draws of it.

    case -> [sliders]; variables of its plant -> [gains] -> sliders with names, units and ranges
    case -> [LiveRun: plant, sliders] -> frames: time, values of the page's columns

Friction, torque, brake and the gains of the controllers act on the run as it goes. Speed, radius of the rollers and
stiffness make another model; it starts at once from its own equilibrium, the vehicle displaced sideways and yawed as it was.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from rollerrig import _core
from rollerrig.assembly.model import AssembledModel, assemble
from rollerrig.cases import leading_wheelset, wheelsets
from rollerrig.config import Case, ConfigError, Rig
from rollerrig.interfaces.plant import assembled_model
from rollerrig.simulation.starting_state import StartError
from rollerrig.viewer import parts
from rollerrig.viewer.contacts import PATCH, Standing, live_places
from rollerrig.viewer.scene import MOTION, WHEEL, head_of, plots

_RANGE = (0.1, 4.0)
"""Range of a gain, over its own value."""

_SHOWN = {"rad/s": ("Hz", 2.0 * math.pi), "1": ("", 1.0), "N m": ("kN m", 1e3), "s": ("ms", 1e-3)}
"""Unit of a parameter -> that of its slider, and what one of the latter is."""

_FEEDBACK, _GAINS_GIVEN = "rig_control.feedback", ("proportional", "integral")
GAINS = {
    "slide_protection.vent_slip": "slip that vents",
    "slide_protection.fill_slip": "slip that fills",
    "wheel_slip_control.slip": "slip, less torque",
    "rig_control.estimator.bandwidth": "estimator bandwidth",
    f"{_FEEDBACK}.bandwidth": "feedback bandwidth",
    f"{_FEEDBACK}.damping_ratio": "feedback damping",
    f"{_FEEDBACK}.proportional": "proportional gain",
    f"{_FEEDBACK}.integral": "integral gain",
    f"{_FEEDBACK}.switching": "switched torque",
    f"{_FEEDBACK}.boundary_layer": "boundary layer",
    "rig_control.drive_command.gain": "torque loop gain",
    "rig_control.drive_command.ahead": "drives asked ahead",
}
"""Tunable parameters of a plant that have a slider, and what stands beside it."""


@dataclass(frozen=True)
class Slider:
    """What a visitor may move: range and begin, in the slider's unit; `factor` of the plant's number over the slider's."""

    name: str
    label: str
    unit: str
    least: float
    most: float
    value: float
    factor: float = 1.0


def sliders(case: Case) -> list[Slider]:
    """Those that a case has, but for the gains of its controllers."""
    support, speed = case.support.data, 3.6 * case.motion.speed
    found = [Slider("speed", "speed", "km/h", 10.0, max(360.0, 1.5 * speed), speed)]
    if isinstance(support, Rig):
        radius = support.roller_radius
        found.append(Slider("radius", "roller radius", "m", 0.4 * radius, 3.0 * radius, radius))
    found.append(Slider("friction", "friction ×", "", 0.05, 2.0, 1.0))
    found.append(Slider("stiffness", "stiffness along ×", "", 0.05, 3.0, 1.0))
    if case.brake is not None:
        found.append(Slider("brake", "more brake", "bar", 0.0, 4.0, 0.0, 1e5))
    if not case.sampled:
        found.append(Slider("torque", "axle torque", "kN m", -8.0, 8.0, 0.0, 1e3))
    return found


def gains(variables: Sequence[_core.Variable]) -> list[Slider]:
    """Gains of the controllers, as the plant has them: those that may change in a run and are not zero."""
    there = {one.name: one for one in variables if one.variability == "tunable" and one.start > 0.0}
    if all(f"{_FEEDBACK}.{name}" in there for name in _GAINS_GIVEN):  # in place of what follows from them
        there = {name: one for name, one in there.items() if not name.endswith(("feedback.bandwidth", "damping_ratio"))}
    return [_slider(there[name], label) for name, label in GAINS.items() if name in there]


def _slider(one: _core.Variable, label: str) -> Slider:
    unit, factor = one.unit, 1.0
    if not one.name.endswith("boundary_layer"):  # a difference of speeds
        unit, factor = _SHOWN.get(one.unit, (unit, factor))
    least, most = (max(one.least, min(one.most, part * one.start)) / factor for part in _RANGE)
    return Slider(one.name, label, unit, least, most, one.start / factor, factor)


FRAME = 1.0 / 30.0
"""Between two frames [s]."""

_WHEEL = {"creep": "longitudinal_creep_force"} | {name: name for name in WHEEL}
_AXLE = ("axle_speed", "roller_speed", "cylinder_pressure", "roller_torque", "traction_torque")
_PUSH, _MOST_OFFSET, _MOST_YAW = 3e-3, 0.02, 0.05
_PAUSE = 1.5
"""After the end of a run, before it begins again [s]."""


class LiveRun:
    """The simulation of a case, from its beginning.

    Raises:
        ConfigError: a controller of the case is written in Python, or nothing holds the vehicle on its rollers.
        StartError: no equilibrium was found.

    Attributes:
        scene: what the page is given; `version` counts how often it became another one.
        told: what a visitor should know now.
    """

    def __init__(self, case: Case) -> None:
        self.case = _endless(case)
        self.sliders = {one.name: one for one in sliders(case)}
        self.values = {name: one.value for name, one in self.sliders.items()}
        self.version, self.told, self.time, self._ended = 0, "", 0.0, 0.0
        self._begin({}, case.disturbance != ())

    # --------------------------------------------------------------------------------------------- what visitors do

    def set(self, name: str, value: float) -> None:
        """Move a slider.

        Raises:
            KeyError: there is none of that name.
            ValueError: the value is outside its range.
            ConfigError: the case cannot be run with it, e.g. too fast for its curves; all goes on as it was.
            StartError: no equilibrium was found; likewise.
        """
        one = self.sliders[name]
        if not (math.isfinite(value) and one.least - 1e-9 <= value <= one.most + 1e-9):
            raise ValueError(f"{one.label}: {value:g} is not between {one.least:g} and {one.most:g} {one.unit}".strip())
        before, self.values[name] = dict(self.values), value
        if name not in ("speed", "radius", "stiffness"):
            self._apply()
            return
        offsets = self._offsets()
        try:
            self._begin(offsets)
        except (ConfigError, StartError, ValueError):
            self.values = before
            self._begin(offsets)
            raise

    def push(self) -> None:
        """The leading wheelset 3 mm to the left."""
        self._begin({leading_wheelset(self.case).name: {"lateral": _PUSH}})

    def again(self) -> None:
        """All sliders and the vehicle as at the start."""
        self.values = {name: one.value for name, one in self.sliders.items()}
        self._begin({}, disturbed=True)

    # ------------------------------------------------------------------------------------------------ its own going on

    def advance(self, seconds: float) -> None:
        """On by so much [s]; a run that has ended begins again after a pause."""
        self.time += seconds
        if self._ended:
            if self.time - self._ended > _PAUSE:
                self._ended, self.told = 0.0, ""
                self._begin({}, disturbed=True)
            return
        status = self.plant.advance(self.time - self._start)
        if status != 0:
            self._ended, wheel = self.time, self.plant.failed_wheel
            self.told = f"this run has ended{f' at {wheel}' if wheel else ''}; it begins again"

    def frame(self) -> dict[str, Any]:
        """Time, values in the order of the scene's columns, and the message to show; None where there is no number."""
        own = self.plant.values(self._indices).tolist()
        own[self._forces] = [v - r for v, r in zip(own[self._forces], self._rest, strict=True)]
        named = dict(zip(self._columns, own, strict=True))
        found = [*own, *live_places(self._standing, self._model.bodies, named)]
        values = [float(f"{v:.6g}") if math.isfinite(v) else None for v in found]
        return {"time": round(self.time, 4), "values": values, "told": self.told}

    def value(self, name: str) -> float | None:
        """A variable of the plant now; None: it has none of that name."""
        return self.plant.get(self._variables[name]) if name in self._variables else None

    # --------------------------------------------------------------------------------------------------- another model

    def _begin(self, offsets: Mapping[str, Mapping[str, float]], disturbed: bool = False) -> None:
        """A run of the model that the sliders ask for."""
        changes: dict[str, Any] = {"motion.speed": f"{self.values['speed']} km/h"}
        if "radius" in self.values:
            changes["support.roller_radius"] = self.values["radius"]
        if not disturbed:
            changes["disturbance"] = [{"body": body, **given} for body, given in offsets.items()]
        case = self.case.with_changes(changes)
        plant = _core.Plant(assembled_model(case))
        if self.values["stiffness"] != 1.0:
            for index, variable in enumerate(plant.variables):
                if variable.name.startswith("primary") and variable.name.endswith(".x_stiffness"):
                    plant.set_parameter(index, variable.start * self.values["stiffness"])
        plant.start()
        self.plant, self._start = plant, self.time
        variables = plant.variables
        self._variables = {variable.name: index for index, variable in enumerate(variables)}
        for one in gains(variables):
            self.sliders.setdefault(one.name, one)
            self.values.setdefault(one.name, one.value)
        self._inputs = {one.name: index for index, one in enumerate(variables) if one.causality == "input"}
        model = assemble(case)
        self._lay_out(model)
        self._apply()

    def _apply(self) -> None:
        """What acts on a run as it goes."""
        moved = {name: self.sliders[name].factor * value for name, value in self.values.items()}
        inputs = (("brake", "brake_demand"), ("torque", "axle_torque"))
        given = {"friction_change": moved["friction"] - 1.0} | {key: moved[k] for k, key in inputs if k in moved}
        for name, index in self._inputs.items():
            key = name.rpartition(".")[2]
            if key in given and not name.startswith("train."):
                self.plant.set_input(index, given[key])
        for name in moved.keys() & self._variables.keys():
            self.plant.set_parameter(self._variables[name], moved[name])

    def _offsets(self) -> dict[str, dict[str, float]]:
        """Where the vehicle is now, sideways and in yaw."""
        found = {}
        for body in self._model.lateral_bodies:
            y, yaw = (self.plant.get(self._variables[f"{body}.{name}"]) for name in ("lateral", "yaw"))
            if math.isfinite(y + yaw) and (y or yaw):
                clipped = max(-_MOST_OFFSET, min(_MOST_OFFSET, y)), max(-_MOST_YAW, min(_MOST_YAW, yaw))
                free = self.case.vehicle.data.body_named(body).locked
                kept = {"lateral": clipped[0], "yaw": clipped[1]}
                found[body] = {k: v for k, v in kept.items() if {"lateral": "y", "yaw": "yaw"}[k] not in free}
        return {body: given for body, given in found.items() if given}

    def _lay_out(self, model: AssembledModel) -> None:
        """The page's columns, where their numbers come from, and the scene."""
        self._model = model
        self._columns: list[str] = []
        self._indices: list[int] = []

        def add(column: str, variable: str) -> None:
            if variable in self._variables:
                self._columns.append(column)
                self._indices.append(self._variables[variable])

        for k, body in enumerate(model.bodies):
            for name in MOTION if body not in model.fixed else ():
                add(f"b{k}.{name}", f"{body}.{name}")
        for k, wheel in enumerate(model.wheels):
            for column, name in _WHEEL.items():
                add(f"w{k}.{column}", f"{wheel.name}.{name}")
        for k, wheelset in enumerate(model.wheelsets):
            for name in _AXLE:
                add(f"a{k}.{name}", f"{wheelset}.{name}")
        add("speed", "run.speed")
        add("distance", "run.distance")
        if "train.speed" in self._variables:
            add("train_speed", "train.speed")
        elements = [{**one, "direction": _direction(one), "rest": 0.0, "largest": 5e3} for one in parts.elements(model)]
        first = len(self._columns)
        for one in elements:
            kind = "force" if one["direction"] in "xyz" else "moment"
            add(f"e{one['number']}", f"{one['name']}.{kind}_{one['direction']}")
        self._forces = slice(first, len(self._columns))
        loads = self.plant.values(self._indices).tolist()[self._forces]
        self._rest = [v if one["carries"] else 0.0 for v, one in zip(loads, elements, strict=True)]
        self._standing = [Standing(model, wheel) for wheel in model.wheels]
        self.scene = self._scene(model, elements)
        self.version += 1

    def _scene(self, model: AssembledModel, elements: list[dict[str, Any]]) -> dict[str, Any]:
        columns = [*self._columns, *(f"w{k}.p0.{name}" for k in range(len(model.wheels)) for name in PATCH)]
        texts = self.case.name, self.case.name, self.case.description, ""
        acting = 1, self.case.brake is not None, self.case.traction is not None
        head = head_of(model, texts, elements, (0.0, 4000.0), acting)
        head |= {"columns": {name: [] for name in columns}, "load": 0.5 * max(model.axle_loads.values())}
        head["plots"] = plots(head)
        head["columns"] = {}
        shown = [{**vars(one), "first": one.value, "value": self.values[one.name]} for one in self.sliders.values()]
        head["live"] = {"columns": columns, "sliders": shown, "note": NOTE}
        return head


NOTE = (
    "Speed, roller radius and stiffness make another model, which starts at once from its own equilibrium, displaced as the "
    "vehicle was; all else acts on the run as it goes. Of several patches of a wheel the most loaded one is drawn."
)


def _direction(element: Mapping[str, Any]) -> str:
    directions: list[str] = element["directions"]
    return "z" if element["carries"] or "z" in directions else directions[-1]


def _endless(case: Case) -> Case:
    """The case without end, and with a torque on each axle that can be set."""
    output = 1000 * case.time.sampling_step if case.sampled else 1.0  # what is kept, which is nothing here
    changes: dict[str, Any] = {"time.duration": "36000 s", "time.output_step": f"{output} s"}
    if case.motion.speed_table is not None:
        changes["motion.speed_table"] = None
    if not case.sampled:
        changes["axle_torque"] = [{"wheelset": body.name, "constant": 0.0} for body in wheelsets(case)]
    return case.with_changes(changes)
