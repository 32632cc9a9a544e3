"""Parts of an assembled model by the core's indices, and what its springs and wheelsets carry as it stands.

Vehicle -> [static_loads] -> preload of each element, load of each axle
[no_parts] -> [add_part] ... -> _core.ModelParts
"""

from dataclasses import dataclass
from typing import Any, TypeAlias

from rollerrig import _core
from rollerrig.config import Vehicle

ABSENT = -1
"""Index of what an axle does not have."""


Parts: TypeAlias = dict[str, Any]
"""Arguments of `_core.ModelParts`."""


def no_parts(gravity: float, laws: _core.ContactLaws) -> Parts:
    """Parts of a model without bodies, at rest on straight track; gravity [m/s^2]."""
    lists = ("bodies", "elements", "profiles", "contacts", "axle_torques", "roller_torques", "brakes", "track_brakes")
    rail = _core.RailLayout(y=[], z=[], roll=[])
    heads = _core.RailHeads(profiles=[], place=[], period=0.0)
    return {name: [] for name in (*lists, "rolling_wheelsets")} | {
        "gravity": gravity,
        "laws": laws,
        "resistance": _core.RunningResistance(body=ABSENT, constant=0.0, linear=0.0, quadratic=0.0, gradient=0.0),
        "speed": [],
        "line": _core.Line(curvature=[], cant=[], cant_base=1.5, left=rail, right=rail),
        "start": 0.0,
        "irregularity": None,
        "left_heads": heads,
        "right_heads": heads,
        "contact_loss_limit": 0.2,
    }


def add_part(parts: Parts, kind: str, part: Any) -> int:
    """Index of a further part of a kind in the core."""
    parts[kind].append(part)
    return len(parts[kind]) - 1


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
