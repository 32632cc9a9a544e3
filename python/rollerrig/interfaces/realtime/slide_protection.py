"""Our slide protection in a process of its own, as a brake controller on the bench would run.

measured axle speeds -> [SlideProtection] -> commands of the dump valves
"""

from __future__ import annotations

from collections.abc import Sequence

from rollerrig import _core
from rollerrig.config import Case
from rollerrig.interfaces.controller_part import controller_part


class SlideProtection:
    """The slide protection of a case, without its rig.

    Attributes:
        sample_time: of the case's table [s].
    """

    def __init__(self, case: Case) -> None:
        """Begin at the speed of the case's start.

        Raises:
            ConfigError: the case has no slide protection, or not ours.
            StartError: no equilibrium was found to start from.
        """
        self._plant = _core.ControllerPlant(controller_part(case, "slide_protection"))
        self._plant.start()
        self.sample_time: float = self._plant.period
        names = [variable.name for variable in self._plant.variables]
        self._speeds = [i for i, name in enumerate(names) if name.endswith(".axle_speed")]
        self._valves = [i for i, name in enumerate(names) if name.endswith(".valve_command")]

    def step(self, time: float, axle_speed: Sequence[float]) -> list[float]:
        """One sample, to be taken every `sample_time`; those that were left out before are taken with it.

        Args:
            time: of the sample [s].
            axle_speed: as measured, shape (axle,) [rad/s].

        Returns:
            0 fill, 1 hold or 2 vent for each axle.
        """
        for index, speed in zip(self._speeds, axle_speed, strict=True):
            self._plant.set_input(index, speed)
        self._plant.advance((round(time / self.sample_time) + 1) * self.sample_time)
        return [self._plant.get(index) for index in self._valves]
