"""Names in the drawing of a vehicle: of bodies and elements in its views, and the legend of their laws.

Scene -> [named_bodies, named_elements] -> Callouts;  Scene -> [legend] -> rows at the lower right of the sheet
"""

from __future__ import annotations

from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from rollerrig.cases import ACTUATORS, wheelsets
from rollerrig.config import Element, Rig
from rollerrig.plot import vehicle_symbols as symbols
from rollerrig.plot.callouts import Callout
from rollerrig.plot.style import colour
from rollerrig.plot.vehicle_scene import BODY, HELD, STEEL, WHEELSET, Scene, bodies, box


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
            words += [name for name in ("brake", "traction") if getattr(case, name)]
            words += ["torque"] if any(torque.wheelset == body.name for torque in case.axle_torque) else []
            place = (x, z + 0.8 * radius)
        elif body.name in part.fixed:
            edge, top = max(low, x - 0.5 * width), min(high, z + 0.5 * tall)
            place = (edge + 0.06 * radius, top - 0.12 * radius)
        else:
            place = (x + 0.2 * width, min(high - 0.05, z + 0.4 * tall))
        found.append(Callout(", ".join(words), (float(place[0]), float(place[1]))))
    foremost = max(body.position[0] for body in wheelsets(case)) - scene.origin
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
    """What everything is called, at the lower right of the sheet."""
    case, part = scene.case, scene.case.vehicle.part
    handles: list[Line2D] = []

    def row(text: str, **look: Any) -> None:
        handles.append(Line2D([], [], **{"linestyle": "none", **look}, label=text))

    for body in bodies(scene):
        face = WHEELSET if body.kind == "wheelset" else HELD if body.name in part.fixed else BODY
        words = [body.name, *(["held"] if body.name in part.fixed else [])]
        words += [f"locked: {', '.join(body.locked)}"] if body.locked else []
        row(", ".join(words), marker="s", markersize=7, markerfacecolor=face, markeredgecolor=symbols.INK)
    for number, (name, elements) in enumerate(scene.families.items()):
        row(f"{name}{f' ×{len(elements)}' if len(elements) > 1 else ''}: {_laws(elements[0])}", marker="o", markersize=4,
            linestyle="-", color=colour(number), linewidth=1.5)  # fmt: skip
    support = case.support.data
    under = (
        f"{support.name}, rollers of {1e3 * support.roller_radius:g} mm" if isinstance(support, Rig) else support.name
    )
    row(under, marker="s", markersize=7, markerfacecolor=STEEL, markeredgecolor=symbols.INK)
    acting = [name.replace("_", " ") for name in ACTUATORS if getattr(case, name)]
    acting += ["axle torque"] if case.axle_torque else []
    if acting:
        row(f"acting: {', '.join(acting)}", marker=".", markersize=0)
    row(
        "arrows: senses of forward running, + for torques on wheelsets",
        marker=r"$\circlearrowright$",
        markersize=8,
        color=symbols.INK,
    )
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
