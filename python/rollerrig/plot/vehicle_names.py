"""Names in the drawing of a vehicle: in a row above each view, each with a line to what it names, and the legend.

view, names with places -> [callouts] -> texts and lines
Scene -> [named_bodies, named_elements] -> Callouts;  Scene -> [legend] -> laws, at the lower right of the sheet
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, cast

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from rollerrig.config import Element, Rig
from rollerrig.config.schema.case import ACTUATORS
from rollerrig.plot.style import colour
from rollerrig.plot.vehicle_scene import INK, STEEL, Scene, bodies, box

_LINE, _GAP, _ABOVE = 11.0, 5.0, 6.0
"""Height of a row, least room between two names, and between the view and the lowest row [points]."""
_SIZE = 6.8


@dataclass(frozen=True)
class Callout:
    """What is named: text, place in the view [data], colour of the line."""

    text: str
    place: tuple[float, float]
    colour: str = "#333333"


def callouts(axes: Axes, named: Sequence[Callout], *, wide: bool) -> int:
    """Write the names above the axes, whose position and limits are settled; how many rows they need.

    `wide`: a row may go on to the right edge of the figure.
    """
    figure = cast(Figure, axes.get_figure(root=True))
    points = 72.0 / figure.dpi
    box = axes.get_window_extent()
    right = figure.get_figwidth() * 72.0 - _GAP if wide else box.x1 * points
    low, high, top = box.x0 * points, right, box.y1 * points + _ABOVE
    widths = _widths(figure, named)
    anchors = [tuple(axes.transData.transform(one.place) * points) for one in named]
    order = in_order(anchors)
    rows = max(1, int(np.ceil((sum(widths) + _GAP * len(named)) / (high - low))))
    placed: dict[int, tuple[float, float]] = {}
    for row in range(rows):
        places = _spread(order[row::rows], anchors, widths, (low, high))
        placed |= {k: (x, top + row * _LINE) for k, x in places.items()}
    width, height = figure.get_figwidth() * 72.0, figure.get_figheight() * 72.0
    for k, (x, y) in placed.items():
        line = {"arrowstyle": "-", "color": named[k].colour, "linewidth": 0.6, "shrinkA": 0.0, "shrinkB": 0.0}
        axes.annotate(named[k].text, named[k].place, (x / width, y / height), textcoords="figure fraction", fontsize=_SIZE,
                      ha="center", va="bottom", arrowprops={**line, "relpos": (0.5, 0.0)}, zorder=9, annotation_clip=False,
                      gid="callout")  # fmt: skip
        axes.plot(*named[k].place, "o", color=named[k].colour, markersize=2.0, zorder=9)
    return rows


def room(rows: int = 1) -> float:
    """That rows of names take above a view [points]."""
    return rows * _LINE + 8.0


def _widths(figure: Figure, named: Sequence[Callout]) -> list[float]:
    """Widths of the names [points]."""
    renderer = cast(Any, figure.canvas).get_renderer()
    found = []
    for one in named:
        text = figure.text(0.0, 0.0, one.text, fontsize=_SIZE)
        found.append(text.get_window_extent(renderer).width * 72.0 / figure.dpi)
        text.remove()
    return found


def in_order(anchors: Sequence[tuple[float, ...]]) -> list[int]:
    """Places of the names from left to right, so that few lines cross: of those above each other, the highest first."""
    return sorted(range(len(anchors)), key=lambda k: (round(anchors[k][0]), -anchors[k][1]))


def _spread(
    order: list[int], anchors: list[tuple[float, ...]], widths: list[float], limits: tuple[float, float]
) -> dict[int, float]:
    """Middles of names in this order: pushed to the right until none overlaps, then back from the right end."""
    low, high = limits
    found: dict[int, float] = {}
    edge = low
    for k in order:
        found[k] = max(anchors[k][0], edge + 0.5 * widths[k])
        edge = found[k] + 0.5 * widths[k] + _GAP
    edge = high
    for k in reversed(order):
        found[k] = min(found[k], edge - 0.5 * widths[k])
        edge = found[k] - 0.5 * widths[k] - _GAP
    return found


def named_bodies(scene: Scene, axes: Axes) -> list[Callout]:
    """Bodies with what holds or drives them, and what the wheels stand on, where they are seen from the right."""
    case, part, support = scene.case, scene.case.vehicle.part, scene.case.support.data
    radius, (low, _), (_, high) = case.vehicle.data.wheel.radius, axes.get_xlim(), axes.get_ylim()
    found = []
    for body in bodies(scene):
        words = [body.name, *(["held"] if body.name in part.fixed else [])]
        words += [f"locked {', '.join(body.locked)}"] if body.locked else []
        x, z = scene.place(body.position, "side")
        width, _, tall = box(body)
        if body.kind == "wheelset":
            words += scene.acting_on(body)
            place = (x, z + 0.8 * radius)
        elif body.name in part.fixed:
            edge, top = max(low, x - 0.5 * width), min(high, z + 0.5 * tall)
            place = (edge + 0.06 * radius, top - 0.12 * radius)
        else:
            place = (x + 0.2 * width, min(high - 0.05, z + 0.4 * tall))
        found.append(Callout(", ".join(words), (float(place[0]), float(place[1]))))
    foremost = max(scene.axles)
    if isinstance(support, Rig):
        drive = "rig control" if case.rig_control else case.motion.drive.replace("_", " ")
        along = 0.8 * support.roller_radius
        return [*found, Callout(f"roller, drive: {drive}", (foremost + along, -0.55 * support.roller_radius))]
    return [*found, Callout("rail", (foremost + 1.6 * radius, -0.08))]


def named_elements(scene: Scene) -> list[Callout]:
    """Each family by the foremost of its elements on the left, seen from above."""
    found = []
    for number, (name, elements) in enumerate(scene.families.items()):
        places = [0.5 * (scene.place(one.end_a, "plan") + scene.place(one.end_b, "plan")) for one in elements]
        place = max(places, key=lambda at: (round(float(at[1]), 6) > 0.0, float(at[0]), float(at[1])))
        found.append(Callout(name, (float(place[0]), float(place[1])), colour(number)))
    return found


def legend(figure: Figure, scene: Scene, beside: bool) -> None:
    """The laws of the elements, the support and what acts, at the lower right of the sheet."""
    case, support = scene.case, scene.case.support.data
    rows: dict[str, dict[str, Any]] = {}
    for number, (name, elements) in enumerate(scene.families.items()):
        count = f" ×{len(elements)}" if len(elements) > 1 else ""
        look = {"marker": "o", "markersize": 4, "linestyle": "-", "color": colour(number), "linewidth": 1.5}
        rows[f"{name}{count}: {_laws(elements[0])}"] = look
    rollers = f", rollers of {1e3 * support.roller_radius:g} mm" if isinstance(support, Rig) else ""
    rows[f"{support.name}{rollers}"] = {
        "marker": "s",
        "markersize": 7,
        "markerfacecolor": STEEL,
        "markeredgecolor": INK,
    }
    acting = [name.replace("_", " ") for name in ACTUATORS if getattr(case, name)]
    if acting := acting + ["axle torque"] * bool(case.axle_torque):
        rows[f"acting: {', '.join(acting)}"] = {}
    arrows = "arrows: senses of forward running, + for torques on wheelsets"
    rows[arrows] = {"marker": r"$\circlearrowright$", "markersize": 8, "color": INK}
    handles = [Line2D([], [], **{"linestyle": "none", **look}, label=text) for text, look in rows.items()]
    figure.legend(handles=handles, loc="lower right", bbox_to_anchor=(0.995, 0.01), fontsize=6.8, frameon=False,
                  title=f"{case.name}: {case.vehicle.data.name}, {case.vehicle.cut}", title_fontsize=8, alignment="left",
                  ncols=1 if beside else 3)  # fmt: skip


def _laws(element: Element) -> str:
    """`spring x, y, z; damper z` of an element."""
    laws = element.laws.items()
    springs = [way for way, law in laws if law.stiffness is not None or law.table is not None]
    dampers = [way for way, law in laws if any((law.damping, law.damping_table, law.damper))]
    parts = [f"{what} {', '.join(ways)}" for what, ways in (("spring", springs), ("damper", dampers)) if ways]
    return "; ".join(parts)
