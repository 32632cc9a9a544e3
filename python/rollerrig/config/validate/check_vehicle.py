"""Checks of a vehicle across its tables: names that must exist, ends that must lie on an axle."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from rollerrig.config.errors import Mistake, join_key, nearest, one_of, show_value
from rollerrig.config.schema.vehicle import DIRECTIONS, Element, Vehicle
from rollerrig.config.validate.check_profile import check_profile
from rollerrig.config.validate.messages import item_labels

_ON_AXLE = 1e-6  # [m] round-off of positions written in decimals


def check_vehicle_names(raw: Mapping[str, Any]) -> Iterator[Mistake]:
    """Names used twice or nowhere defined; works on raw tables, so that other mistakes do not hide these."""
    found: dict[str, dict[str, None]] = {"body": {}, "element": {}}
    for kind, names in found.items():
        for label, item in labelled(raw, kind):
            name = item.get("name")
            if isinstance(name, str) and name in names:
                yield f"{label}.name", show_value(name), "allowed: each name once"
            elif isinstance(name, str):
                names[name] = None
    bodies = tuple(found["body"])
    if not bodies:
        return
    for label, element in labelled(raw, "element"):
        yield from unknown_names(element.get("between"), bodies, f"{label}.between")
    cuts = raw.get("cut")
    for name, cut in cuts.items() if isinstance(cuts, Mapping) else ():
        for key in ("bodies", "fixed") if isinstance(cut, Mapping) else ():
            yield from unknown_names(cut.get(key), bodies, f"cut.{name}.{key}")


def labelled(raw: Mapping[str, Any], key: str) -> Iterator[tuple[str, Mapping[str, Any]]]:
    """The tables of an array of tables, each with its dotted key; whatever is not a table is skipped."""
    items = raw.get(key)
    if not isinstance(items, list | tuple):
        return
    for label, item in zip(item_labels(items), items, strict=True):
        if isinstance(item, Mapping):
            yield join_key(key, label), item


def unknown_names(names: object, known: Sequence[str], key: str) -> Iterator[Mistake]:
    """A mistake for each name that is not known; a single text counts as a list of one."""
    for name in names if isinstance(names, list | tuple) else [names]:
        if isinstance(name, str) and name not in known:
            yield key, show_value(name), one_of(known), nearest(name, known)


def check_vehicle(vehicle: Vehicle) -> Iterator[Mistake]:
    """What only a vehicle of valid tables can be asked."""
    radius = vehicle.wheel.radius
    for body in vehicle.body:
        x, y, z = body.position
        if body.kind == "wheelset" and (abs(z - radius) > _ON_AXLE or abs(y) > _ON_AXLE):
            allowed = f"allowed for a wheelset: [x, 0, {radius:g}], its wheels of radius {radius:g} m standing at z = 0"
            yield f"body.{body.name}.position", show_value((x, y, z)), allowed
    for element in vehicle.element:
        yield from _ends(vehicle, element)
    for name in vehicle.cut_names():
        yield from _cut(vehicle, name)
    yield from check_profile(vehicle.wheel.profile, "wheel", "wheel.profile")


def _ends(vehicle: Vehicle, element: Element) -> Iterator[Mistake]:
    for name, end in zip(element.between, (element.end_a, element.end_b), strict=True):
        body = vehicle.body_named(name)
        x, _, z = body.position
        if body.kind == "wheelset" and (abs(end[0] - x) > _ON_AXLE or abs(end[2] - z) > _ON_AXLE):
            allowed = f"allowed: a point on the axle of {name}, which does not turn with it: [{x:g}, y, {z:g}]"
            yield f"element.{element.name}.{'points' if element.points else 'point'}", show_value(end), allowed
    kinds = [vehicle.body_named(name).kind for name in element.between]
    if kinds[0] == "wheelset":  # the force acts at the end on b: beside the axle of a, which it would turn
        allowed = "allowed: the wheelset as the second of the two, since the force acts at the end on the second body"
        yield f"element.{element.name}.between", show_value(element.between), allowed
    if element.pitch is not None and "wheelset" in kinds:
        allowed = "allowed: no moment about the axle of a wheelset, which spins"
        yield f"element.{element.name}.pitch", "a law", allowed


def _cut(vehicle: Vehicle, name: str) -> Iterator[Mistake]:
    cut, key = vehicle.cut_named(name), f"cut.{name}"
    for body in vehicle.bodies_in(cut):
        supported = any(body.name in element.between for element in vehicle.elements_in(cut))
        if body.kind == "rigid" and not supported and len(set(body.locked)) < len(DIRECTIONS):
            allowed = "allowed: wheelsets, and bodies that an element of the cut holds up"
            yield f"{key}.bodies", show_value(body.name), allowed
    for body_name in sorted(set(cut.bodies) & set(cut.fixed)):
        yield f"{key}.fixed", show_value(body_name), "allowed: bodies that are not also kept free"
    for body_name in cut.fixed:
        if vehicle.body_named(body_name).kind == "wheelset":
            yield f"{key}.fixed", show_value(body_name), "allowed: bodies that are not wheelsets"
    for field, names in (("bodies", cut.bodies), ("fixed", cut.fixed)):
        for body_name in sorted({n for n in names if names.count(n) > 1}):
            yield f"{key}.{field}", show_value(body_name), "allowed: each body once"
    if not any(body.kind == "wheelset" for body in vehicle.bodies_in(cut)):
        yield f"{key}.bodies", show_value(cut.bodies), "needed: at least one body of kind = 'wheelset'"
