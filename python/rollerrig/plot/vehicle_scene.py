"""What the views of a vehicle share: the case, its bodies and families of elements, and where they stand.

Case -> [scene_of] -> Scene -> places in a view
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from rollerrig.cases import wheelsets
from rollerrig.config import Body, Case, Element

STEEL, BODY, HELD = "#d7dde3", "#f3efe4", "#e4e4e4"
WHEELSET = "#b9c4cf"

VIEWS = {"side": ("x", "z"), "plan": ("x", "y"), "end": ("y", "z")}
"""View -> its axes, to the right (from behind: to the left) and up."""

INDEX = {"x": 0, "y": 1, "z": 2}


@dataclass(frozen=True)
class Scene:
    """What the views share.

    Attributes:
        case: what is drawn.
        origin: of the part that is run, along the vehicle [m].
        half_base: half distance between the tape circles [m].
        families: name -> elements of that name on any side, wheelset or bogie.
    """

    case: Case
    origin: float
    half_base: float
    families: dict[str, list[Element]]

    def place(self, position: Sequence[float], view: str) -> np.ndarray[Any, np.dtype[np.float64]]:
        """Place of a position of the vehicle in a view [m]."""
        moved = (position[0] - self.origin, position[1], position[2])
        return np.array([moved[INDEX[axis]] for axis in VIEWS[view]])

    @property
    def span(self) -> float:
        """Distance between the outer axles [m]."""
        places = [body.position[0] for body in wheelsets(self.case)]
        return max(places) - min(places)

    @property
    def size(self) -> float:
        """Length of a symbol [m]."""
        return 0.7 * self.case.vehicle.data.wheel.radius


def scene_of(case: Case) -> Scene:
    """What is drawn of a case."""
    wheel = case.vehicle.data.wheel
    part = case.vehicle.part
    families: dict[str, list[Element]] = {}
    for element in case.vehicle.data.elements_in(part):
        families.setdefault(family(element.name), []).append(element)
    return Scene(
        case=case,
        origin=part.origin_x,
        half_base=0.5 * wheel.back_to_back + wheel.tape_circle,
        families=families,
    )


def family(name: str) -> str:
    """`primary_1_left` and its like as `primary`."""
    return re.sub(r"_(left|right|front|rear|leading|trailing|\d+)(?=_|$)", "", name) or name


def bodies(scene: Scene) -> list[Body]:
    """Bodies of the part, held ones first, wheelsets last."""
    part, data = scene.case.vehicle.part, scene.case.vehicle.data
    found = [body for body in data.body if body.name in (*part.bodies, *part.fixed)]
    return sorted(found, key=lambda body: (body.name not in part.fixed, body.kind == "wheelset", -body.mass))


def box(body: Body) -> tuple[float, float, float]:
    """Edges along x, y, z of the homogeneous box with the body's mass and moments of inertia [m]."""
    total = sum(body.inertia)
    x, y, z = (np.sqrt(max(6.0 * (total - 2.0 * own) / body.mass, 1e-6)) for own in body.inertia)
    return float(x), float(y), float(z)
