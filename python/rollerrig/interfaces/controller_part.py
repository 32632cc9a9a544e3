"""One of our controllers alone: what an FMU of it carries, and what a process of its own runs.

case, name of its table -> [controller_part] -> _core.ControllerPart
measured axle speeds -> [SlideProtection] -> commands of the dump valves
"""

from __future__ import annotations

from collections.abc import Sequence

from rollerrig import _core
from rollerrig.config import Case, ConfigError, ConfigProblem
from rollerrig.config.errors import nearest
from rollerrig.interfaces.plant import assembled_model
from rollerrig.simulation.controllers import roles_of, with_brake_unit


def controller_part(case: Case, part: str) -> _core.ControllerPart:
    """A controller of the case with what it starts from.

    Raises:
        ConfigError: the case has no such controller, or not ours.
        StartError: no equilibrium was found to start from.
    """
    case, there = with_brake_unit(case, [part]), roles_of(case)
    if part not in there:
        raise part_refused(case, part, f"allowed: a controller of the case: {', '.join(there) or 'it has none'}", there)
    if not getattr(case, part).is_ours:
        raise part_refused(case, part, "the case has a controller of your own there; allowed: one of ours")
    axles = case.train.axles
    shared = case.sanding is not None or (case.adhesion is not None and case.adhesion.recovery_constant > 0.0)
    if part == "rig_control" and axles is not None and axles.simulated and shared:
        raise part_refused(
            case, part, "the simulated axles of [train.axles] run on its virtual rail, and clean it or take its sand"
        )
    others = [role for role in there if (table := getattr(case, role)) is not None and not table.is_ours]
    assembled = assembled_model(case, external=others)
    assert assembled.setup is not None
    sampled = next(one for one in assembled.setup.controllers if isinstance(one.controller, _core.controllers[part]))
    plant = _core.Plant(assembled)
    plant.start()
    names = list(assembled.names.axles)
    if isinstance(sampled.controller, _core.RigControl):  # of those on the rig alone
        names = names[: len(sampled.controller.train.static_load)]

    def at_start(quantity: str) -> list[float]:
        return [float(plant.get(plant.find(f"{axle}.{quantity}"))) for axle in names]

    return _core.ControllerPart(
        name=case.name,
        step=assembled.setup.step,
        controller=sampled,
        axles=names,
        train_speed=assembled.setup.speed,
        axle_speed=at_start("axle_speed"),
        roller_speed=at_start("roller_speed"),
    )


def part_refused(case: Case, part: str, allowed: str, choices: list[str] | None = None) -> ConfigError:
    """What is wrong with a part, with a guess."""
    return ConfigError([ConfigProblem(case.name, "part", repr(part), allowed, nearest(part, choices or []))])


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
