"""Parts of an assembled model by the core's indices, and what its springs and wheelsets carry as it stands.

Vehicle -> [static_loads] -> preload of each element, load of each axle
"""

from dataclasses import dataclass

from rollerrig import _core
from rollerrig.config import Vehicle

ABSENT = -1
"""Index of what an axle does not have."""


@dataclass(frozen=True)
class WheelInfo:
    """One wheel of the assembled model."""

    name: str
    wheelset: str
    side: str
    contact: int


def static_loads(vehicle: Vehicle, gravity: float) -> tuple[dict[str, float], dict[str, float]]:
    """Vertical preloads and axle loads of the whole vehicle in its design position, solved by the core.

    Args:
        vehicle: all bodies and elements.
        gravity: its acceleration [m/s^2].

    Returns:
        Preload per element that carries load (force on its second body [N]), and load per wheelset [N].
    """
    names = [body.name for body in vehicle.body]
    loads = _core.static_loads(
        [
            _core.StandingBody(mass=body.mass, position=body.position, on_wheels=body.kind == "wheelset")
            for body in vehicle.body
        ],
        [
            _core.LoadSpring(body_a=names.index(e.between[0]), body_b=names.index(e.between[1]), point=e.end_b)
            for e in vehicle.element
            if e.carries_load
        ],
        gravity,
    )
    carrying = (element.name for element in vehicle.element if element.carries_load)
    wheelsets = {b.name: load for b, load in zip(vehicle.body, loads.on_body, strict=True) if b.kind == "wheelset"}
    return dict(zip(carrying, loads.preload, strict=True)), wheelsets
