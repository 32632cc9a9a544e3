"""What the views of a vehicle share: the case, its bodies and families of elements, and the symbols of the drawing.

Case -> [scene_of] -> Scene -> places in a view
place, direction, colour -> [symbols] -> lines in axes
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import FancyArrowPatch

from rollerrig.cases import wheelsets
from rollerrig.common.arrays import Array
from rollerrig.config import Body, Case, Element

STEEL, BODY, WHEELSET = "#d7dde3", "#f3efe4", "#b9c4cf"

VIEWS = {"side": ("x", "z"), "plan": ("x", "y"), "end": ("y", "z")}
"""View -> its axes, to the right (from behind: to the left) and up."""

INDEX = {"x": 0, "y": 1, "z": 2}


@dataclass(frozen=True)
class Scene:
    """What the views of a case share: origin of the part that is run [m], half distance between the tape circles [m].

    Families: name -> elements of that name on any side, wheelset or bogie.
    """

    case: Case
    origin: float
    half_base: float
    families: dict[str, list[Element]]

    def place(self, position: Sequence[float], view: str) -> np.ndarray[Any, np.dtype[np.float64]]:
        """Place of a position of the vehicle in a view [m]."""
        moved = (position[0] - self.origin, position[1], position[2])
        return np.array([moved[INDEX[axis]] for axis in VIEWS[view]])

    def acting_on(self, wheelset: Body) -> list[str]:
        """What turns or brakes a wheelset."""
        found = [name for name in ("brake", "traction") if getattr(self.case, name)]
        return found + ["torque"] * any(torque.wheelset == wheelset.name for torque in self.case.axle_torque)

    @property
    def axles(self) -> list[float]:
        """Places of the wheelsets along x [m]."""
        return [body.position[0] - self.origin for body in wheelsets(self.case)]

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
    return Scene(case, part.origin_x, 0.5 * wheel.back_to_back + wheel.tape_circle, families)


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


INK = "#333333"


def spring(axes: Axes, middle: Array, along: Array, length: float, colour: str) -> None:
    """A zigzag of a length along a unit vector."""
    across = np.array([-along[1], along[0]])
    steps = np.array([-0.5, -0.32, -0.24, -0.08, 0.08, 0.24, 0.32, 0.5])
    sides = np.array([0.0, 0.0, 1.0, -1.0, 1.0, -1.0, 0.0, 0.0])
    points = middle + length * (steps[:, None] * along + 0.14 * sides[:, None] * across)
    axes.plot(points[:, 0], points[:, 1], color=colour, linewidth=1.0, zorder=6)


def damper(axes: Axes, middle: Array, along: Array, length: float, colour: str) -> None:
    """A pot and a piston of a length along a unit vector."""
    across = np.array([-along[1], along[0]])

    def stroke(*places: tuple[float, float]) -> None:
        points = np.array([middle + length * (s * along + t * across) for s, t in places])
        axes.plot(points[:, 0], points[:, 1], color=colour, linewidth=1.0, zorder=6, solid_joinstyle="miter")

    stroke((-0.5, 0.0), (-0.2, 0.0))
    stroke((0.22, -0.13), (-0.2, -0.13), (-0.2, 0.13), (0.22, 0.13))
    stroke((0.02, -0.1), (0.02, 0.1))
    stroke((0.02, 0.0), (0.5, 0.0))


def turning(
    axes: Axes, middle: Array, radius: float, colour: str, *, clockwise: bool = True, arrow: bool = True
) -> None:
    """An arc about a place, with a head in its sense of turning."""
    start, end = np.radians([200.0, -20.0] if clockwise else [-20.0, 200.0])
    angle = np.linspace(start, end, 40)
    points = middle + radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    axes.plot(points[:, 0], points[:, 1], color=colour, linewidth=1.0, zorder=6)
    if arrow:
        head(axes, points[-4], points[-1], colour)


def head(axes: Axes, start: Array, end: Array, colour: str) -> None:
    """An arrow from one place to another."""
    axes.add_patch(
        FancyArrowPatch(
            (float(start[0]), float(start[1])), (float(end[0]), float(end[1])), arrowstyle="-|>", mutation_scale=7.0,
            color=colour, linewidth=1.0, shrinkA=0.0, shrinkB=0.0, zorder=7,
        )
    )  # fmt: skip


def triad(axes: Axes, names: tuple[str, str], into: str, *, mirrored: bool) -> None:
    """Directions of a view's two axes in its corner, and the one that points into the picture or out of it."""
    options: dict[str, Any] = {"xycoords": "axes fraction", "textcoords": "axes fraction", "annotation_clip": False}
    box = axes.get_window_extent()
    width, height = 26.0 / max(box.width, 1.0), 26.0 / max(box.height, 1.0)
    corner = (1.0 - 0.6 * width, 0.02) if mirrored else (0.6 * width, 0.02)
    sign = -1.0 if mirrored else 1.0
    arrow = {"arrowstyle": "-|>", "color": INK, "linewidth": 1.1, "shrinkA": 0.0, "shrinkB": 0.0}
    for name, step in ((names[0], (sign * width, 0.0)), (names[1], (0.0, height))):
        tip = (corner[0] + step[0], corner[1] + step[1])
        axes.annotate("", tip, corner, arrowprops=arrow, **options)
        axes.annotate(name, (corner[0] + 1.25 * step[0], corner[1] + 1.25 * step[1]), xycoords="axes fraction", fontsize=7.5,
                      ha="center", va="center", annotation_clip=False)  # fmt: skip
    axes.annotate(into, (corner[0] + 1.5 * sign * width, corner[1]), xycoords="axes fraction", fontsize=6.5, color=INK,
                  ha="left" if sign > 0 else "right", va="center", annotation_clip=False)  # fmt: skip
