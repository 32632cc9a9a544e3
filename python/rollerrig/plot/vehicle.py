"""A vehicle on its rig or track, to scale, from the right, from above and from behind.

Case -> [vehicle] -> Figure

Wheels, rollers and rails have their own profiles and radii. A body whose shape the case does not know is drawn as the homogeneous
box of its mass and moments of inertia. Symbols of springs and dampers lie along the directions in which they act.
"""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Polygon, Rectangle

from rollerrig.cases import as_case, wheelsets
from rollerrig.config import Body, Case, Element, Rig
from rollerrig.config.schema.support import heads
from rollerrig.plot.style import GREY, colour, house_style
from rollerrig.plot.vehicle_names import callouts, legend, named_bodies, named_elements, room
from rollerrig.plot.vehicle_scene import (
    BODY,
    INDEX,
    INK,
    STEEL,
    VIEWS,
    WHEELSET,
    Scene,
    bodies,
    box,
    damper,
    scene_of,
    spring,
    triad,
    turning,
)
from rollerrig.profiles import gauge_point, profile_from_spec

_TITLES = {
    "side": "from the right: x forward, z up",
    "plan": "from above: x forward, y to the left",
    "end": "from behind: y to the left",
}
_ANGLES = {"roll": "x", "pitch": "y", "yaw": "z"}


@house_style()
def vehicle(case: Case | str) -> Figure:
    """The vehicle of a case on its rig or track, drawn to scale from three sides.

    Bodies, force elements with their directions, locked directions, brakes, drives and torques are named; axes and senses of
    turning are those of every key and result. Curves and cant are not drawn.

    Args:
        case: or its name, or its file.

    Example:
        >>> vehicle("wheelset_rollers").axes[0].get_title(loc="left")
        'from the right: x forward, z up'
    """
    scene = scene_of(as_case(case))
    figure, panels, beside = _sheet(scene)
    for view, axes in panels.items():
        _ground(axes, scene, view)
        for body in bodies(scene):
            _body(axes, scene, body, view)
        for number, elements in enumerate(scene.families.values()):
            for element in elements:
                _element(axes, scene, element, view, colour(number))
        _frame(axes, view)
    _turning(panels["side"], scene)
    legend(figure, scene, beside)
    figure.canvas.draw()
    for view, named in (("side", named_bodies(scene, panels["side"])), ("plan", named_elements(scene))):
        rows = callouts(panels[view], named, wide=view == "plan")
        panels[view].set_title(_TITLES[view], loc="left", fontsize=8.5, pad=room(rows))
    for view, axes in panels.items():
        into = {"side": "y into the page", "plan": "z towards you", "end": "x into the page"}[view]
        triad(axes, VIEWS[view], into, mirrored=view == "end")
    return figure


def _extent(scene: Scene) -> tuple[tuple[float, float], tuple[float, float], tuple[float, float]]:
    """What is shown along x, y and z [m]; of a held body only what is near the others."""
    part, radius = scene.case.vehicle.part, scene.case.vehicle.data.wheel.radius
    elements = [element for family in scene.families.values() for element in family]
    points = [np.array(end) for element in elements for end in (element.end_a, element.end_b)]
    for body in (body for body in bodies(scene) if body.name not in part.fixed):
        edges = (2 * radius, 0.0, 2 * radius) if body.kind == "wheelset" else box(body)
        points += [np.array(body.position) + sign * np.array(edges) for sign in (-0.5, 0.5)]
    x, y, z = np.transpose(points)
    across = max(float(np.abs(y).max()), scene.half_base + 0.25)
    support = scene.case.support.data
    below = -min(2.05 * support.roller_radius, 2.2) if isinstance(support, Rig) else -0.35
    x = x - scene.origin
    reach = min(support.roller_radius, 1.2) if isinstance(support, Rig) else 0.0
    axles = scene.axles
    low, high = min(float(x.min()), min(axles) - reach) - 0.3, max(float(x.max()), max(axles) + reach) + 0.3
    return (low, high), (-across - 0.2, across + 0.2), (below, float(z.max()) + 0.35)


def _sheet(scene: Scene) -> tuple[Figure, dict[str, Axes], bool]:
    """A sheet with the three views at one scale: the end beside the side, the plan below it; whether names fit beside that."""
    (x0, x1), (y0, y1), (z0, z1) = _extent(scene)
    gap, width = 0.55, 11.0
    scale = (width - 3 * gap) / ((x1 - x0) + (y1 - y0))  # inches per metre
    upright, flat = scale * (z1 - z0), scale * (y1 - y0)
    rows = len(scene.families) + 4
    beside = scale * (x1 - x0) < 0.6 * width  # room for the names at the right of the plan
    strip = 0.0 if beside else 0.055 * rows + 0.25
    lower = max(flat, 0.17 * rows) if beside else strip + flat
    names = room() / 72.0  # above the side and the plan
    height = upright + lower + 3 * gap + 2 * names
    figure = Figure(figsize=(width, height))
    FigureCanvasAgg(figure)

    def panel(left: float, bottom: float, wide: float, high: float) -> Axes:
        return figure.add_axes((left / width, bottom / height, wide / width, high / height))

    upper = 2 * gap + lower + names
    side = panel(gap, upper, scale * (x1 - x0), upright)
    end = panel(2 * gap + scale * (x1 - x0), upper, flat, upright)
    plan = panel(gap, gap + lower - flat, scale * (x1 - x0), flat)
    for axes, across, up in ((side, (x0, x1), (z0, z1)), (plan, (x0, x1), (y0, y1)), (end, (y1, y0), (z0, z1))):
        axes.set_xlim(*across)
        axes.set_ylim(*up)
    return figure, {"side": side, "plan": plan, "end": end}, beside


def _frame(axes: Axes, view: str) -> None:
    across, up = VIEWS[view]
    axes.set_aspect("equal")
    axes.grid(visible=False)
    axes.tick_params(labelsize=7)
    axes.set_xlabel(f"{across} [m]", fontsize=7.5, labelpad=1)
    axes.set_ylabel(f"{up} [m]", fontsize=7.5, labelpad=1)
    axes.set_title(_TITLES[view], loc="left", fontsize=8.5)


def _ground(axes: Axes, scene: Scene, view: str) -> None:
    """Rollers under the wheelsets, or rails."""
    support = scene.case.support.data
    radius = support.roller_radius if isinstance(support, Rig) else 0.16
    steel: dict[str, Any] = {"facecolor": STEEL, "edgecolor": INK, "linewidth": 0.8, "zorder": 1.5}
    if view == "side":
        axes.axhline(0.0, color=GREY, linewidth=0.7, linestyle=(0, (5, 3)), zorder=1)
        if not isinstance(support, Rig):
            low, high = axes.get_xlim()
            axes.add_patch(Rectangle((low, -0.16), high - low, 0.16, **steel))
        for x in scene.axles if isinstance(support, Rig) else ():
            axes.add_patch(Circle((x, -radius), radius, **steel))
            axes.plot(x, -radius, "+", color=INK, markersize=6)
        return
    for sign, head in zip((1.0, -1.0), heads(support).values(), strict=True):
        rail = profile_from_spec(head.arguments(), "rail")
        abscissa = np.linspace(*rail.domain, 120)
        crown = rail.evaluate(abscissa)
        y = sign * (0.5 * support.gauge - gauge_point(rail, support.gauge_depth) + abscissa)
        if view == "end":
            depth = 2 * radius if isinstance(support, Rig) else radius
            outline = np.concatenate([np.stack([y, crown], axis=1), [[y[-1], -depth], [y[0], -depth]]])
            axes.add_patch(Polygon(outline, closed=True, **steel))
            if isinstance(support, Rig) and sign > 0:
                axes.plot([-y[0], y[0]], [-radius, -radius], color=INK, linewidth=2.0, zorder=1.4)
        else:
            rollers = [(x - radius, x + radius) for x in scene.axles] if isinstance(support, Rig) else []
            for low, high in rollers or [axes.get_xlim()]:
                axes.add_patch(Rectangle((low, min(y[0], y[-1])), high - low, abs(y[-1] - y[0]), **steel))


def _wheelset(axes: Axes, scene: Scene, body: Body, view: str) -> None:
    wheel = scene.case.vehicle.data.wheel
    table = profile_from_spec(wheel.profile.arguments(), "wheel")
    abscissa = np.linspace(*table.domain, 160)
    middle = scene.place(body.position, view)
    steel: dict[str, Any] = {"facecolor": WHEELSET, "edgecolor": INK, "linewidth": 0.9, "zorder": 4}
    if view == "side":
        axes.add_patch(Circle((middle[0], middle[1]), wheel.radius, **{**steel, "alpha": 0.85}))
        axes.plot(*middle, "+", color=INK, markersize=6, zorder=8)
        return
    radius = wheel.radius + table.evaluate(abscissa)
    ends = np.array([1.0, -1.0]) * (scene.half_base + 0.18)
    axle = (0.0 * ends + middle[0], ends) if view == "plan" else (ends, 0.0 * ends + middle[1])
    axes.plot(*axle, color=INK, linewidth=2.2, zorder=3.5)
    for sign in (1.0, -1.0):
        y = sign * (scene.half_base + abscissa)
        rim = np.stack([np.concatenate([y, y[::-1]]), np.concatenate([radius, -radius[::-1]])], axis=1)
        if view == "plan":
            rim = rim[:, ::-1]
        axes.add_patch(Polygon(middle * ([1, 0] if view == "plan" else [0, 1]) + rim, closed=True, **steel))


def _body(axes: Axes, scene: Scene, body: Body, view: str) -> None:
    if body.kind == "wheelset":
        _wheelset(axes, scene, body, view)
        return
    held = body.name in scene.case.vehicle.part.fixed
    if held and view == "plan":  # it would cover all
        return
    size = np.array([box(body)[INDEX[axis]] for axis in VIEWS[view]])
    middle = scene.place(body.position, view)
    look: dict[str, Any] = {"facecolor": BODY, "edgecolor": INK, "zorder": 2.5}
    if held:
        look = {"facecolor": "white", "edgecolor": "#c4c4c4", "zorder": 1.2, "hatch": "////"}
    axes.add_patch(Rectangle(tuple(middle - size / 2), *size, alpha=0.75, clip_on=True, linewidth=0.9, **look))


def _element(axes: Axes, scene: Scene, element: Element, view: str, ink: str) -> None:
    """Its laws in the directions that the view shows, at the ends or in the middle between them."""
    a, b = scene.place(element.end_a, view), scene.place(element.end_b, view)
    middle, size = 0.5 * (a + b), scene.size
    for number, axis in enumerate(VIEWS[view]):
        law = getattr(element, axis)
        if law is None:
            continue
        along = np.eye(2)[number]
        reach = max(abs(float((b - a) @ along)), size)
        both = law.stiffness is not None or law.table is not None, any((law.damping, law.damping_table, law.damper))
        shift = 0.16 * size * np.array([-along[1], along[0]]) if all(both) else np.zeros(2)
        if both[0]:
            spring(axes, middle + shift, along, reach, ink)
        if both[1]:
            damper(axes, middle - shift, along, reach, ink)
    for angle, axis in _ANGLES.items():
        if getattr(element, angle) is not None and axis not in VIEWS[view]:
            turning(axes, middle, 0.45 * size, ink, arrow=False)
    axes.plot(*middle, "o", color=ink, markersize=2.5, zorder=7)


def _turning(axes: Axes, scene: Scene) -> None:
    """Senses of turning in which forward running, driving torques and brakes are counted."""
    case, support = scene.case, scene.case.support.data
    for body in wheelsets(case):
        middle = scene.place(body.position, "side")
        turning(axes, middle, 0.55 * case.vehicle.data.wheel.radius, INK)
        if isinstance(support, Rig):
            below = np.array([middle[0], -support.roller_radius])
            turning(axes, below, 0.4 * support.roller_radius, INK, clockwise=False)
    if isinstance(support, Rig) and support.restraint:
        low = axes.get_xlim()[0]
        start = np.array([low + 0.02, support.restraint.height])
        spring(axes, start + [0.5 * scene.size, 0.0], np.array([1.0, 0.0]), scene.size, INK)
        axes.annotate("coupler rod", tuple(start + [0.0, 0.5 * scene.size]), fontsize=6.5)
