"""Our slide protection in a process of its own, as a brake controller on the bench would run.

measured axle speeds -> [SlideProtection] -> commands of the dump valves
"""

from __future__ import annotations

from collections.abc import Sequence

from rollerrig import _core
from rollerrig.config import Case, ConfigError, ConfigProblem
from rollerrig.mechatronics.setup import slide_protection


class SlideProtection:
    """The slide protection of a case, without its rig.

    Attributes:
        sample_time: of the case's table [s].
    """

    def __init__(self, case: Case, axles: int = 2) -> None:
        """Begin at the speed of the case's start.

        Args:
            case: has a table [slide_protection].
            axles: that are protected.

        Raises:
            ConfigError: the case has no slide protection.
        """
        table = case.slide_protection
        if table is None:
            raise ConfigError([ConfigProblem(case.name, "slide_protection", "missing", "needed: this table")])
        self.sample_time = float(table.sample_time)
        law = _core.controllers["slide_protection"](law=slide_protection(table, case.vehicle.data.wheel.radius))
        self._unit = _core.SlideProtectionUnit(law, axles, case.motion.speed, self.sample_time)

    def step(self, time: float, axle_speed: Sequence[float]) -> list[float]:
        """One sample, to be taken every `sample_time`.

        Args:
            time: of the sample [s].
            axle_speed: as measured, shape (axle,) [rad/s].

        Returns:
            0 fill, 1 hold or 2 vent for each axle.
        """
        found: list[float] = self._unit.step(time, list(axle_speed))
        return found
