"""Small motions of the bench about steady rolling: from its commands to its outputs, by the names of the plant.

    Case, speed, names -> [linearize] -> control.StateSpace, or A, B, C, D as an xarray.Dataset

The vehicle, its rollers or rails and its contacts are the core's exact linearisation; drives are their linear torque loops. The
controllers are outside: their commands are inputs. Brakes have small motions about a pressure: at none, springs hold their pads
off. The rollers' drives then hold the speed, or on track what holds the frame.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from importlib.util import find_spec
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr
from scipy.linalg import block_diag

from rollerrig import _core
from rollerrig.analysis.linear_system import LinearSystem
from rollerrig.assembly.actuators import assemble_with_actuators
from rollerrig.assembly.laws import angular
from rollerrig.assembly.model import AssembledModel, assemble
from rollerrig.cases import as_case, at_speed, wheelsets
from rollerrig.common.arrays import Array
from rollerrig.config import Case, ConfigError, ConfigProblem, Motor
from rollerrig.config.errors import nearest
from rollerrig.simulation.starting_state import StartError, starting_state

if TYPE_CHECKING:
    import control

MOTIONS = tuple(name for name, _, _ in _core.body_fields)[:12]
"""Coordinates and rates of a body, as the core orders them."""

_LISTED = 12  # so many names a message lists


@dataclass(frozen=True)
class Signal:
    """A named row of a linear system: `row @ x + through @ acting`, acting on the model's columns."""

    name: str
    unit: str
    row: Array
    through: Array


@dataclass(frozen=True)
class Lag:
    """A drive between a command and a torque of the model, or a control valve before a cylinder."""

    column: int  # of the torque or pressure
    bandwidth: float  # of the torque loop or the control valve [rad/s]
    damping: float  # of a second-order loop; 0: first order
    steps: int  # by which the command acts late, in sampling steps


def steady_case(case: Case, speed: float | None = None) -> Case:
    """The case rolling steadily at a speed [m/s], by default its own: nothing disturbs it, nothing is demanded.

    Its drives and controllers stay. Wheelsets that no torque acts on get one of zero, so that there is an input.
    """
    if not case.sampled:
        steady = at_speed(case, speed) if case.motion.drive == "speed_controlled" else case
        given = [torque.model_dump() for torque in case.axle_torque]
        free = {body.name for body in wheelsets(case)} - {torque.wheelset for torque in case.axle_torque}
        given += [{"wheelset": name, "constant": 0.0} for name in sorted(free)]
        case = steady.with_changes({"axle_torque": given})
    nothing = [[0.0, 0.0], [1.0, 0.0]]
    changes: dict[str, object] = {
        "disturbance": [],
        "motion.speed": f"{case.motion.speed if speed is None else speed} m/s",
    }
    if case.motion.speed_table is not None:
        changes["motion.speed_table"] = None
    if case.motion.torque_table is not None:
        changes["motion.torque_table"] = nothing
    for table in ("brake", "traction"):
        if getattr(case, table) is not None:
            changes[f"{table}.demand"] = nothing
    if case.support.data.irregularity is not None:
        changes["support.irregularity"] = None
    return case.with_changes(changes)


class LinearBench:
    """A case in steady rolling at one speed, linearised once; systems of any inputs and outputs are read off it."""

    def __init__(self, case: Case, speed: float | None = None, brake_pressure: float = 0.0) -> None:
        """Assemble, find the equilibrium, linearise; arguments and errors as of `linearize`."""
        self.case = steady_case(case, speed)
        self.speed = self.case.motion.speed
        self.model = assemble_with_actuators(self.case, torque_on_all=True) if case.sampled else assemble(self.case)
        state = starting_state(self.model)
        self._simulation = _core.Simulation(self.model.core)
        self._axles = dict(zip(self.model.wheelsets, self.model.axles, strict=False))  # none without actuators
        self.brake_pressure = brake_pressure
        pressures = self._pressures(brake_pressure)
        self.holding_torque: tuple[float, ...] = ()
        """Torque of the rollers' drives, which hold the speed against the brakes [N m]; on track none."""
        if pressures:
            state, torques, found = self._simulation.hold_speed(0.0, state, pressures)
            self.holding_torque = tuple(torques)
            if not found:
                raise StartError(
                    f"{case.name}: no steady rolling at {3.6 * self.speed:.4g} km/h and {brake_pressure / 1e5:.3g} bar in the "
                    "brake cylinders: the wheels would slide, or nothing holds the vehicle along the track"
                )
        a, b, self._c, self._d = self._simulation.linear_model(0.0, state, pressures, list(self.holding_torque))
        self._names = _state_names(self._simulation, self.model)
        driven = {
            self._simulation.rate_index[self.model.body_index(name)][4]
            for name in self.model.rollers
            if self.case.motion.drive == "speed_controlled"
        }
        self._kept = np.array([i for i in range(len(a)) if i not in driven])
        self._a, self._b = a[np.ix_(self._kept, self._kept)], b[self._kept]

    def _pressures(self, brake_pressure: float) -> list[float]:
        """Pressure of each brake of the model [Pa], empty: none is applied; ConfigError: it is none, or there are no brakes."""
        brakes = [axle.brake for axle in self.model.axles if axle.brake >= 0]
        allowed = "" if np.isfinite(brake_pressure) and 0.0 <= brake_pressure <= 1e7 else "allowed: from 0 to 1e7 Pa"
        if brake_pressure and not brakes:
            allowed = "allowed: 0, of a case without [brake] or with motors that replace it"
        if allowed:
            raise ConfigError.of(self.case.name, "brake_pressure", f"{brake_pressure:g} Pa", allowed)
        return [brake_pressure] * len(brakes) if brake_pressure else []

    @cached_property
    def torques(self) -> Mapping[str, int]:
        """Torque of the model by name -> its column."""
        model, columns = self.model, [*self._simulation.torque_bodies]
        return {
            f"{model.bodies[body]}.{'roller' if model.bodies[body] in model.rollers else 'axle'}_torque": k
            for k, body in enumerate(columns)
        }

    @cached_property
    def pressures(self) -> Mapping[str, int]:
        """Cylinder pressure by name -> its column; none where the brakes are not applied."""
        applied = self._axles if self.brake_pressure else {}
        first = len(self.torques)
        return {f"{name}.cylinder_pressure": first + axle.brake for name, axle in applied.items() if axle.brake >= 0}

    @property
    def holding(self) -> Mapping[str, float]:
        """Commands of the rollers' drives that hold the speed against the brakes [N m]; where nothing brakes none."""
        return {
            f"{wheelset}.roller_torque_command": self.holding_torque[axle.roller_torque]
            for wheelset, axle in self._axles.items()
            if 0 <= axle.roller_torque < len(self.holding_torque)
        }

    @cached_property
    def commands(self) -> Mapping[str, Lag]:
        """Command by name -> the drive, or the control valve, that follows it."""
        found: dict[str, Lag] = {}
        case, step = self.case, self.case.time.sampling_step
        for wheelset, axle in self._axles.items():
            if case.traction is not None:
                column = self.torques[f"{wheelset}.axle_torque"]
                found[f"{wheelset}.motor_torque"] = _lag(column, case.traction.motor, 0)
            if case.rig_control is not None and axle.roller >= 0:
                column = self.torques[f"{self.model.bodies[axle.roller]}.roller_torque"]
                late = round(case.rig_control.delay / step)
                found[f"{wheelset}.roller_torque_command"] = _lag(column, case.rig_control.motor, late)
        for name, column in self.pressures.items():
            assert case.brake is not None
            # Behind the control valve the cylinder has no lag in small motions: flow grows as the root of what drives it.
            found[name.replace("cylinder_pressure", "brake_demand")] = Lag(column, case.brake.follow_rate, 0.0, 0)
        return found

    @cached_property
    def inputs(self) -> tuple[str, ...]:
        """Names of all inputs."""
        return (*self.commands, *self.torques, *self.pressures)

    @cached_property
    def outputs(self) -> Mapping[str, Signal]:
        """All outputs by name."""
        found: list[Signal] = []
        angles = self._simulation.angle_index
        width = len(_core.body_fields)
        for k, body in enumerate(self.model.bodies):
            for i, (name, unit, _) in enumerate(_core.body_fields):
                if name == "pitch" and angles[k] >= 0:  # it only accumulates
                    continue
                row = k * width + i
                found.append(Signal(f"{body}.{name}", unit, self._c[row, self._kept], self._d[row]))
        first = width * len(self.model.bodies)
        for k, wheel in enumerate(self.model.wheels):
            for i, (name, unit, _) in enumerate(_core.wheel_fields):
                row = first + k * len(_core.wheel_fields) + i
                found.append(Signal(f"{wheel.name}.{name}", unit, self._c[row, self._kept], self._d[row]))
        by_name = {signal.name: signal for signal in found}
        for wheelset, axle in self._axles.items():
            turning = {"axle_speed": (wheelset, 1.0)}
            if axle.roller >= 0:
                turning["roller_speed"] = (self.model.bodies[axle.roller], -1.0)
            for name, (body, sign) in turning.items():
                spin = by_name[f"{body}.pitch_rate"]
                found.append(Signal(f"{wheelset}.{name}", spin.unit, sign * spin.row, sign * spin.through))
        return {signal.name: signal for signal in found}

    def system(self, inputs: Sequence[str], outputs: Sequence[str], *, discrete: bool = False) -> LinearSystem:
        """Linear system from some inputs to some outputs, by name; ConfigError: there is none, or the case has no samples.

        If `discrete` from sample to sample of the case, under commands held between, with their delay; else without it.
        """
        lags = [self.commands.get(name) for name in self._known("inputs", inputs, self.inputs)]
        signals = [self.outputs[name] for name in self._known("outputs", outputs, self.outputs)]
        if discrete and not self.case.sampled:
            allowed = (
                "allowed: false, of a case without sampled actuators or controllers; or .sampled(step) of the result"
            )
            raise ConfigError.of(self.case.name, "discrete", "true", allowed)
        columns = {**self.torques, **self.pressures}
        places = [columns[name] if lag is None else lag.column for name, lag in zip(inputs, lags, strict=True)]
        chosen = np.eye(self._b.shape[1])[:, places]
        # States x, then of each lag its torque (or pressure) and rate; they act on the model, or the inputs without a lag do.
        none = np.zeros((0, 0)), np.zeros((0, 1)), np.zeros((1, 0))
        loops = [none if lag is None else torque_loop(lag.bandwidth, lag.damping) for lag in lags]
        own, driven, read = (block_diag(*matrices) for matrices in zip(*loops, strict=True))
        acting, direct = chosen @ read, chosen @ np.diag([float(lag is None) for lag in lags])
        a = np.block([[self._a, self._b @ acting], [np.zeros((len(own), len(self._a))), own]])
        b = np.vstack([self._b @ direct, driven])
        names = [self._names[i] for i in self._kept]
        for name, loop in zip(inputs, loops, strict=True):
            names += [f"{name}.acting", f"{name}.acting_rate"][: len(loop[0])]
        through = np.array([signal.through for signal in signals])
        c, d = np.hstack([[signal.row for signal in signals], through @ acting]), through @ direct
        system = LinearSystem(
            self.case.name, self.speed, 0.0, a, b, c, d,
            tuple(names), tuple(inputs), tuple(outputs), tuple(map(self.unit_of, inputs)), tuple(s.unit for s in signals),
        )  # fmt: skip
        if not discrete:
            return system
        return system.sampled(self.case.time.sampling_step).delayed([lag.steps if lag else 0 for lag in lags])

    def unit_of(self, name: str) -> str:
        """Unit of an input."""
        lag = self.commands.get(name)
        column = lag.column if lag else {**self.torques, **self.pressures}[name]
        return "N m" if column < len(self.torques) else "Pa"

    def _known(self, key: str, asked: Sequence[str], there: Iterable[str]) -> Sequence[str]:
        choices = tuple(there)
        problems = [
            ConfigProblem(self.case.name, key, repr(name), _allowed(choices, name), nearest(name, choices))
            for name in asked
            if name not in choices
        ]
        if not asked:
            problems = [ConfigProblem(self.case.name, key, "none", f"allowed: {_listed(choices, '')}")]
        for name in {name for name in asked if list(asked).count(name) > 1}:
            problems.append(ConfigProblem(self.case.name, key, repr(name), "allowed: each name once"))
        if problems:
            raise ConfigError(problems)
        return asked


def _allowed(choices: Sequence[str], asked: str) -> str:
    """Why it is no input, where that is known, and what there is."""
    quantity = asked.rpartition(".")[2]
    if quantity in ("brake_demand", "cylinder_pressure") and asked not in choices:
        return "allowed with brake_pressure: at no pressure springs hold the pads off, and a small demand does nothing"
    if quantity == "valve_command":
        return "allowed: brake_demand or cylinder_pressure; a dump valve fills, holds or vents, nothing between"
    return f"allowed: {_listed(choices, asked)}"


def _listed(choices: Sequence[str], asked: str) -> str:
    """The choices, of many those of the same part, or of every part one."""
    part = asked.rpartition(".")[0]
    near = [name for name in choices if name.rpartition(".")[0] == part] or list(choices)
    return ", ".join(near[:_LISTED]) + (f" and {len(choices) - _LISTED} more" if len(near) > _LISTED else "")


def _lag(column: int, motor: Motor, steps: int) -> Lag:
    return Lag(column, angular(motor.bandwidth), motor.damping_ratio, steps)


def torque_loop(bandwidth: float, damping: float) -> tuple[Array, Array, Array]:
    """The linear torque loop of a drive, `Motor::rates` of the core without its limits: A and B of torque (and rate), and C."""
    w = bandwidth
    if damping > 0.0:
        matrix = np.array([[0.0, 1.0], [-(w**2), -2.0 * damping * w]])
        return matrix, np.array([[0.0], [w**2]]), np.array([[1.0, 0.0]])
    return np.array([[-w]]), np.array([[w]]), np.array([[1.0]])


def _state_names(simulation: _core.Simulation, model: AssembledModel) -> list[str]:
    names = [f"inner_node_{i}" for i in range(simulation.state_count)]
    for places, fields in ((simulation.coordinate_index, MOTIONS[:6]), (simulation.rate_index, MOTIONS[6:])):
        for body, row in zip(model.bodies, places, strict=True):
            for name, index in zip(fields, row, strict=True):
                if index >= 0:
                    names[index] = f"{body}.{name}"
    return names


def linearize(
    case: Case | str,
    speed: float | None = None,
    inputs: Sequence[str] = (),
    outputs: Sequence[str] = (),
    *,
    discrete: bool = False,
    brake_pressure: float = 0.0,
) -> control.StateSpace | xr.Dataset:
    """The bench in small motions about steady rolling, with exact derivatives.

    Args:
        case: the case, or its name.
        speed: running speed [m/s]; None: that of the case.
        inputs: names as the plant has them: wheelset_1.roller_torque_command, wheelset_1.motor_torque,
            wheelset_1.axle_torque ...; none or a wrong one: the message lists them. With a brake pressure also
            wheelset_1.brake_demand and wheelset_1.cylinder_pressure.
        outputs: names: wheelset_1.lateral, wheelset_1_left.vertical_force, wheelset_1.axle_speed ...
        discrete: at the case's time.sampling_step, commands held between the samples and as late as they act.
        brake_pressure: of all brake cylinders, over the ambient [Pa]: the rollers' drives, or on track what holds the frame, then
            hold the speed against the brakes.

    Returns:
        A control.StateSpace where python-control is installed, else a Dataset with A, B, C, D, see
        `LinearSystem.to_dataset`. In both, signals have their names; python-control allows no dots in them: wheelset_1/left/Q.

    Raises:
        ConfigError: an unknown name, a speed that the case does not allow, no samples, a pressure without brakes.
        StartError: no rolling equilibrium was found.

    Example:
        >>> import rollerrig as rr
        >>> names = {"inputs": ["wheelset_1.roller_torque_command"], "outputs": ["wheelset_1.axle_speed"]}
        >>> rr.linearize("adhesion_brake", speed=20.0, **names).ninputs
        1
    """
    system = LinearBench(as_case(case), speed, brake_pressure).system(inputs, outputs, discrete=discrete)
    return system.to_control() if find_spec("control") is not None else system.to_dataset()
