"""Contact patches of a simulation that runs: asked of the core's contact geometry at the pose of each wheelset.

AssembledModel, values of a frame -> [LiveContacts] -> values of the columns of patches
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import partial

from rollerrig import _core
from rollerrig.assembly.model import AssembledModel
from rollerrig.viewer.contact_places import seen_from_rail, static_contact, support_under

PATCH = (
    "x",
    "y",
    "z",
    "peak_pressure",
    "length",
    "width",
    "a",
    "b",
    "normal",
    "contact_angle",
    "creep_force_x",
    "creep_force_y",
    "sliding_x",
    "sliding_y",
)
_POSE = ("longitudinal", "lateral", "vertical", "yaw", "roll")


class LiveContacts:
    """The most loaded patch of every wheel.

    Args:
        model: of the run.
    """

    def __init__(self, model: AssembledModel) -> None:
        self._wheels = [
            (
                model.bodies.index(wheel.wheelset),
                model.bodies.index(under) if (under := support_under(model, wheel.wheelset, wheel.side)) else -1,
                wheel.side == "right",
                static_contact(model, wheel.wheelset),
                partial(seen_from_rail, model, under, wheel.wheelset),
            )
            for wheel in model.wheels
        ]

    def values(self, frame: Mapping[str, float]) -> list[float]:
        """Values of the columns PATCH of all wheels, one after the other; NaN where a wheel does not touch."""
        found: list[float] = []
        for number, (body, under, right, contact, seen) in enumerate(self._wheels):
            pose = [frame.get(f"b{body}.{name}", 0.0) for name in _POSE]
            moved = [frame.get(f"b{under}.{name}", 0.0) for name in _POSE] if under >= 0 else [0.0] * len(_POSE)
            x, y, z, yaw, roll = (one - other for one, other in zip(pose, moved, strict=True))
            y -= frame.get(f"w{number}.rail_lateral", 0.0)
            z -= frame.get(f"w{number}.rail_vertical", 0.0)
            y, z = seen(y, z, moved[-1]).tolist()
            patches = contact.patches(x, y, z, yaw, roll, right) if math.isfinite(x + y + z + yaw + roll) else []
            found += (
                _columns(max(patches, key=lambda patch: patch.normal), frame, number)
                if patches
                else [math.nan] * len(PATCH)
            )
        return found


def _columns(patch: _core.StaticPatch, frame: Mapping[str, float], number: int) -> list[float]:
    inwards = -patch.direction[1] if not patch.right else patch.direction[1]
    shape = (patch.peak_pressure, patch.length, patch.width, patch.a, patch.b, patch.normal)
    slip = (frame.get(f"w{number}.{name}_sliding", math.nan) for name in ("longitudinal", "lateral"))
    return [
        *patch.point,
        *shape,
        math.atan2(inwards, patch.direction[2]),
        frame.get(f"w{number}.creep", 0.0),
        0.0,
        *slip,
    ]
