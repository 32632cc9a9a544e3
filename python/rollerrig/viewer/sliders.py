"""What a visitor may move in a live simulation: what every case has, and the gains of its controllers.

case -> [sliders]; variables of its plant -> [gains] -> sliders with names, units and ranges
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from rollerrig import _core
from rollerrig.config import Case, Rig

_RANGE = (0.1, 4.0)
"""Range of a gain, over its own value."""

_HERTZ = 2.0 * math.pi

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
    """What a visitor may move.

    Attributes:
        name: of it; of a gain that of the plant's parameter.
        label: beside it.
        unit: of its numbers.
        least, most, value: its range and where it begins.
        factor: of the plant's number over the slider's.
    """

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
    unit, factor = {"rad/s": ("Hz", _HERTZ), "1": ("", 1.0), "N m": ("kN m", 1e3), "s": ("ms", 1e-3)}.get(
        one.unit, (one.unit, 1.0)
    )
    if one.name.endswith("boundary_layer"):
        unit, factor = one.unit, 1.0  # a difference of speeds
    least, most = (max(one.least, min(one.most, part * one.start)) / factor for part in _RANGE)
    return Slider(one.name, label, unit, least, most, one.start / factor, factor)
