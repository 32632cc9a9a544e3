"""The bench as a Gymnasium environment: commands in, sensors out, the test of a case as an episode.

    Case, the controller that the agent stands for -> [BenchEnv] -> reset, step;  [make_vector] -> a process per environment

Actions are the commands of that controller, observations what it would see, with the noise and the steps of [sensors]: names,
order and units of the plant. The other controllers of the case stay. Needs gymnasium: pip install "rollerrig[gym]".
"""

import os
from functools import partial
from typing import Any

import gymnasium
import numpy as np

from rollerrig import _core
from rollerrig.cases import as_case
from rollerrig.common.arrays import Array
from rollerrig.config import Case, ConfigError
from rollerrig.config.errors import nearest
from rollerrig.interfaces.plant import assembled_model
from rollerrig.simulation.controllers import BRAKE_UNIT, COMMANDS, roles_of

LARGEST = {"rad/s": 1e3, "N m": 1e6, "N": 1e7, "m/s": 200.0}
"""Bounds of observations by their unit: far beyond any test, so that spaces are finite; what exceeds them is clipped."""

SLIP_ALLOWED, SLIP_WEIGHT = 0.1, 2.0
TRACKING_SCALE = 0.1
"""Scales of the rewards: slip without a penalty [-], weight of what is beyond; speed error that costs 1 per second [rad/s]."""

PENALTY = 10.0
"""Taken off where the run leaves the model's validity, or the rig's protection ends it."""


class BenchEnv(gymnasium.Env[Array, Any]):
    """One controller of a case, replaced by an agent.

    Actions: of slide_protection 0 fill, 1 hold, 2 vent per axle; of wheel_slip_control and rig_control -1 to 1 per axle, over the
    range of the command (torque factor; torque up to the drive's limit).

    Reward per second of the test, with v the train's speed, r w an axle's, mean over the axles:
        slide_protection      -v' / (1 m/s^2) - 2 max(0, |v - r w| / v - 0.1)
        wheel_slip_control     v' / (1 m/s^2) - 2 max(0, |v - r w| / v - 0.1)
        rig_control           -|w - w_virtual| / (0.1 rad/s)
    and 10 less once where the run fails. An episode is terminated there and where the train has stopped; it is truncated at the
    end of the case's duration.

    `reset(seed=...)` draws the noise of the sensors: same seed and actions, same bytes.
    """

    metadata: dict[str, Any] = {"render_modes": []}  # noqa: RUF012 - as Gymnasium declares it

    def __init__(self, case: Case | str = "adhesion_brake", controller: str = "slide_protection") -> None:
        """Assemble the case once, to know its commands and sensors.

        Args:
            case: the case, or its name.
            controller: the table of the case that the agent stands for.

        Raises:
            ConfigError: the case has no such controller.
        """
        self.case, self.controller = as_case(case), controller
        there = [role for role in roles_of(self.case) if role != BRAKE_UNIT]
        if controller not in there:
            allowed = f"allowed: {', '.join(there) or 'nothing: the case has no controller'}"
            raise ConfigError.of(self.case.name, "controller", repr(controller), allowed, nearest(controller, there))
        self.period: float = getattr(self.case, controller).sample_time
        self._radius = self.case.vehicle.data.wheel.radius
        self._plant = self._new_plant()
        variables = self._plant.variables
        ending = f".{COMMANDS[controller].name}_command"
        self._commands = [
            k for k, one in enumerate(variables) if one.causality == "input" and one.name.endswith(ending)
        ]
        self._sensors = [k for k, one in enumerate(variables) if one.name.startswith(f"{controller}.")]
        axles = [variables[k].name.removesuffix(ending) for k in self._commands]
        kind = "virtual_speed" if controller == "rig_control" else "axle_speed"
        self._speeds = [self._plant.find(f"{axle}.axle_speed") for axle in axles]
        self._wanted = [self._plant.find(f"{axle}.{kind}") for axle in axles]
        self._train = self._plant.find("train.speed")
        self._bound = np.array([LARGEST.get(variables[k].unit, 1e6) for k in self._sensors])
        self._low, self._high = self._limits(variables)
        self.observation_names = tuple(variables[k].name for k in self._sensors)
        self.action_names = tuple(variables[k].name for k in self._commands)
        self.observation_space = gymnasium.spaces.Box(-self._bound, self._bound, dtype=np.float64)
        count = len(self._commands)
        self.action_space = (
            gymnasium.spaces.MultiDiscrete([3] * count)
            if controller == "slide_protection"
            else gymnasium.spaces.Box(-1.0, 1.0, (count,), dtype=np.float64)
        )

    def _limits(self, variables: list[_core.Variable]) -> tuple[Array, Array]:
        """Range of each command; that of an unlimited torque is what the drive can do."""
        control = self.case.rig_control
        drive = control.motor.largest_torque if control is not None and control.motor.largest_torque else 2e4
        low, high = (np.array([getattr(variables[k], end) for k in self._commands]) for end in ("least", "most"))
        return np.where(np.isfinite(low), low, -drive), np.where(np.isfinite(high), high, drive)

    def _new_plant(self) -> _core.Plant:
        return _core.Plant(assembled_model(self.case, external=[self.controller], allow_unrestrained=True))

    # ------------------------------------------------------------------------------------------------- an episode

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Array, dict[str, Any]]:
        """Begin the test anew; `seed` of the sensors' noise, no options are known."""
        super().reset(seed=seed, options=options)
        if self.case.sensors is not None:
            self.case = self.case.with_changes({"sensors.seed": int(self.np_random.integers(2**31))})
        self._plant = self._new_plant()
        self._plant.start()
        self._step, self._speed = 0, self._plant.get(self._train)
        return self._observed(), self._info("ok")

    def step(self, action: Any) -> tuple[Array, float, bool, bool, dict[str, Any]]:
        """Give the commands of one sample, one per axle, and run to the next."""
        given = np.asarray(action, dtype=float)
        if self.controller != "slide_protection":
            given = self._low + 0.5 * (np.clip(given, -1.0, 1.0) + 1.0) * (self._high - self._low)
        for index, value in zip(self._commands, given.tolist(), strict=True):
            self._plant.set_input(index, value)
        self._step += 1
        code = self._plant.advance(self._step * self.period)
        status = _STATUS.get(code, "unknown")
        reward = self._reward() - (PENALTY if status not in ("ok", "stopped") else 0.0)
        ended = self._step * self.period >= self.case.time.duration - 1e-9
        return self._observed(), reward, status != "ok", ended and status == "ok", self._info(status)

    def _reward(self) -> float:
        before, self._speed = self._speed, self._plant.get(self._train)
        speeds = self._plant.values(self._speeds)
        if self.controller == "rig_control":
            error = float(np.mean(np.abs(speeds - self._plant.values(self._wanted))))
            return -self.period * error / TRACKING_SCALE
        change = self._speed - before
        slip = np.abs(self._speed - self._radius * speeds) / max(abs(self._speed), 1.0)
        beyond = float(np.mean(np.maximum(0.0, slip - SLIP_ALLOWED)))
        return (change if self.controller == "wheel_slip_control" else -change) - self.period * SLIP_WEIGHT * beyond

    def _observed(self) -> Array:
        seen = np.nan_to_num(self._plant.values(self._sensors))
        return np.clip(seen, -self._bound, self._bound)

    def _info(self, status: str) -> dict[str, Any]:
        return {"time": self._plant.time, "train_speed": self._speed, "status": status}


_STATUS = {code: name for name, code in _core.status_codes.items()}


def make_vector(
    case: Case | str = "adhesion_brake", controller: str = "slide_protection", count: int | None = None
) -> gymnasium.vector.AsyncVectorEnv:
    """Environments side by side, each in a process of its own.

    Args:
        case: as of `BenchEnv`; a script needs `if __name__ == "__main__":`.
        controller: as of `BenchEnv`.
        count: how many; None: one per core.
    """
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    return gymnasium.vector.AsyncVectorEnv([partial(BenchEnv, case, controller)] * (count or cores), context="spawn")
