"""What a page draws of a case: bodies, wheels, force elements, profiles, the line. Lengths and places, no motion.

    AssembledModel, run -> [parts] -> plain tables for the page

Profiles, radii, places and ends are the case's own. Shapes that a case does not give (frames, car bodies, coils, motors) are
drawn around the ends of its elements; the page says that they are schematic.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np

from rollerrig.assembly.model import AssembledModel
from rollerrig.common.arrays import Array, Mask
from rollerrig.config import Element, Rig, Track
from rollerrig.config.schema.vehicle import DIRECTIONS
from rollerrig.profiles import ProfileTable
from rollerrig.results.run_info import describe

Table = dict[str, Any]

SIDES = ("left", "right")

_FLAT = 0.03e-3
"""A drawn profile leaves the true one by less than this [m]."""

_AHEAD, _BEHIND, _LINE_STEP = 160.0, 120.0, 2.0
"""Length of the line ahead and behind that the page knows, and its step, along the way run [m]."""


def bodies(model: AssembledModel) -> list[Table]:
    """Name, kind, place and attachments of each body, in the order of the model."""
    info = describe(model)
    ends: dict[str, list[list[float]]] = {name: [] for name in model.bodies}
    for element in _elements(model):
        for body, end in zip(element.between, (element.end_a, element.end_b), strict=True):
            ends[body].append(_relative(model, body, end))
    return [
        {
            "name": body.name,
            "kind": {"vehicle body": "frame" if info.on_wheelsets(body) else "car body"}.get(body.role, body.role),
            "at": [round(value, 6) for value in body.position],
            "fixed": body.fixed,
            "ends": ends[body.name],
            "sides": [side for side in SIDES if not body.name.endswith(SIDES) or body.name.endswith(side)],
        }
        for body in info.bodies
    ]


def elements(model: AssembledModel) -> list[Table]:
    """Bodies, ends and kind of each element of the vehicle, and the number of it in the run."""
    found = []
    for element in _elements(model):
        laws = element.laws
        linear = [direction for direction in DIRECTIONS[:3] if direction in laws]
        a, b = element.between
        found.append(
            {
                "name": element.name,
                "number": model.elements.index(element.name),
                "bodies": [model.bodies.index(a), model.bodies.index(b)],
                "ends": [_relative(model, a, element.end_a), _relative(model, b, element.end_b)],
                "directions": linear or [direction for direction in DIRECTIONS[3:] if direction in laws],
                "kind": _element_kind(element, linear),
                "carries": element.carries_load,
            }
        )
    return found


def _element_kind(element: Element, linear: Sequence[str]) -> str:
    if not linear:
        return "bar"
    laws = [law for direction, law in element.laws.items() if direction in linear]
    if not any(law.stiffness or law.table for law in laws):
        return "damper"
    if all(law.table and not law.stiffness for law in laws):
        return "stop"
    return "rod" if linear == ["x"] else "spring"


def _elements(model: AssembledModel) -> list[Element]:
    vehicle, known = model.case.vehicle, set(model.elements)
    return [element for element in vehicle.data.elements_in(vehicle.part) if element.name in known]


def _relative(model: AssembledModel, body: str, point: tuple[float, float, float]) -> list[float]:
    x, y, z = model.positions[body]
    return [round(point[0] - model.case.vehicle.part.origin_x - x, 6), round(point[1] - y, 6), round(point[2] - z, 6)]


def wheels(model: AssembledModel) -> list[Table]:
    """Name, body and side of each wheel, in the order of the run."""
    return [
        {"name": wheel.name, "body": model.bodies.index(wheel.wheelset), "side": 1 if wheel.side == "left" else -1}
        for wheel in model.wheels
    ]


def shapes(model: AssembledModel) -> Table:
    """Profiles as they are drawn, and the lengths that place them [m]."""
    wheel, support = model.case.vehicle.data.wheel, model.case.support.data
    return {
        "wheel": outline(model.wheel_profile),
        "rail": outline(model.rail_profile),
        "wheel_radius": wheel.radius,
        "back_to_back": wheel.back_to_back,
        "tape_circle": wheel.back_to_back / 2 + wheel.tape_circle,
        "rail_origin": model.rail_origin_y,
        "roller_radius": support.roller_radius if isinstance(support, Rig) else 0.0,
        "gauge": support.gauge,
    }


def outline(profile: ProfileTable) -> list[list[float]]:
    """The whole shape as few points as its curvature needs, along the abscissa (n, 2) [m]."""
    points = np.asarray(profile.outline)
    if points[0, 0] > points[-1, 0]:
        points = points[::-1]
    keep = np.zeros(len(points), dtype=bool)
    keep[[0, -1]] = True
    _simplify(points, 0, len(points) - 1, keep)
    return [[round(float(y), 6), round(float(z), 6)] for y, z in points[keep]]


def _simplify(points: Array, first: int, last: int, keep: Mask) -> None:
    """Douglas and Peucker."""
    if last - first < 2:
        return
    chord = points[last] - points[first]
    length = float(np.hypot(*chord)) or 1.0
    inner = points[first + 1 : last] - points[first]
    distance = np.abs(chord[0] * inner[:, 1] - chord[1] * inner[:, 0]) / length
    farthest = int(np.argmax(distance))
    if distance[farthest] > _FLAT:
        middle = first + 1 + farthest
        keep[middle] = True
        _simplify(points, first, middle, keep)
        _simplify(points, middle, last, keep)


def track(model: AssembledModel, run_from: float, run_to: float) -> Table | None:
    """Plan, heading, cant and height of the line over the way run, from least to greatest distance [m]; None on a rig."""
    if not isinstance(model.case.support.data, Track):
        return None
    s = np.arange(run_from - _BEHIND, run_to + _AHEAD + _LINE_STEP, _LINE_STEP)
    heading, cant, base = np.zeros_like(s), np.zeros_like(s), 1.5
    if (line := model.line) is not None:
        heading, cant, base = np.asarray(line.heading(s)), np.asarray(line.cant.evaluate(s)), line.cant_base
    middles = ((way[1:] + way[:-1]) / 2 for way in (np.cos(heading), np.sin(heading)))
    x, y = (np.concatenate([[0.0], np.cumsum(rate * _LINE_STEP)]) for rate in middles)
    at_start = np.interp(0.0, s, x), np.interp(0.0, s, y)
    columns = {"x": x - at_start[0], "y": y - at_start[1], "heading": heading, "cant": cant}
    rounded = {name: np.round(values, 5).tolist() for name, values in columns.items()}
    return {"start": float(s[0]), "step": _LINE_STEP, "base": base, **rounded}
